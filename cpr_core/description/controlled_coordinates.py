# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The platform coordinates that an inverse problem may control, and the poses that are made of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..lie import (
    roll_pitch_yaw,
    rotation_from_angles,
    rotation_from_quaternion,
    turn_about_z,
)

__all__ = [
    "CONTROLLED_COORDINATES",
    "Coordinate",
    "meant_by",
    "no_inverse_problem",
    "numbers_of",
    "pose_of",
]

Floats = NDArray[np.float64]

#: Numbers of a coordinate by position (3,) and rotation (3, 3) of the platform, and what gives the
#: quaternion w x y z, which is dear and asked for by those only who need it.
Reading = Callable[[Floats, Floats, Callable[[], Floats]], Sequence[float]]

_PLACE, _ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
_QUATERNION = ("qw", "qx", "qy", "qz")


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of the platform.

    Attributes:
        axes: Components of the world twist [omega; v] that move it; of a single angle of
            Rz(yaw) Ry(pitch) Rx(roll) the one whose place it takes.
        spaces: Of which robots it is one: ``planar``, ``spatial``.
        numbers: Names of its numbers in a pose.
        read: These numbers [m, rad].
    """

    axes: tuple[int, ...]
    spaces: tuple[str, ...]
    numbers: tuple[str, ...]
    read: Reading

    @property
    def turns(self) -> bool:
        """Whether turning the platform changes it."""
        return self.numbers[0] not in _PLACE

    @property
    def is_angle(self) -> bool:
        """Whether it is one number in radians."""
        return self.turns and len(self.numbers) == 1

    @property
    def is_single_angle(self) -> bool:
        """Whether it is an angle of a rotation that has others."""
        return self.numbers[0] in _ANGLES


def _position(axis: int) -> Reading:
    return lambda position, *_: (position.item(axis),)


def _single_angle(number: int) -> Reading:
    return lambda _, rotation, *__: (roll_pitch_yaw(rotation).item(number),)


_SPATIAL, _ANY = ("spatial",), ("planar", "spatial")
#: By name, in the order in which errors list them.
CONTROLLED_COORDINATES = {
    "x": Coordinate((3,), _ANY, ("x",), _position(0)),
    "y": Coordinate((4,), _ANY, ("y",), _position(1)),
    "z": Coordinate((5,), _SPATIAL, ("z",), _position(2)),
    "angle": Coordinate((2,), ("planar",), ("angle",), lambda _, turn, __: (turn_about_z(turn),)),
    "orientation": Coordinate(
        (0, 1, 2), _SPATIAL, _QUATERNION, lambda _, __, quaternion: quaternion().tolist()
    ),
    "roll": Coordinate((0,), _SPATIAL, ("roll",), _single_angle(0)),
    "pitch": Coordinate((1,), _SPATIAL, ("pitch",), _single_angle(1)),
    "yaw": Coordinate((2,), _SPATIAL, ("yaw",), _single_angle(2)),
}


@cache
def numbers_of(controlled: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the numbers that make up a pose of some coordinates."""
    return tuple(number for name in controlled for number in CONTROLLED_COORDINATES[name].numbers)


def pose_of(
    controlled: tuple[str, ...],
    position: Floats,
    rotation: Floats,
    quaternion: Callable[[], Floats],
) -> Floats:
    """The numbers of some coordinates, in their order [m, rad].

    Args:
        controlled: Names of the coordinates.
        position: Of the platform, (3,) [m].
        rotation: Of the platform, (3, 3).
        quaternion: Gives the same w x y z, of either sign.
    """
    numbers = list[float]()
    for name in controlled:
        numbers += CONTROLLED_COORDINATES[name].read(position, rotation, quaternion)
    return np.array(numbers)


def meant_by(
    controlled: tuple[str, ...], pose: Floats, position: Floats, rotation: Floats
) -> tuple[Floats, Floats]:
    """Position, (3,) [m], and rotation, (3, 3), that a pose means.

    Args:
        controlled: Names of the coordinates.
        pose: Their numbers, as `pose_of` has them; a pitch of at most pi/2.
        position: What those of the position are that it does not say, (3,) [m].
        rotation: The same of the rotation, (3, 3).

    Raises:
        InvalidQuaternion: A quaternion far from unit length.
    """
    numbers, coordinates = pose.tolist(), position.tolist()
    places, turns = _places_of(controlled)
    for number, axis in places:
        coordinates[axis] = numbers[number]
    if turns:
        given = dict(zip(numbers_of(controlled), numbers, strict=True))
        rotation = _rotation_meant_by(given, rotation)
    return np.array(coordinates), rotation


@cache
def _places_of(controlled: tuple[str, ...]) -> tuple[tuple[tuple[int, int], ...], bool]:
    """Which numbers of a pose are which of x y z, and whether there are others."""
    names = numbers_of(controlled)
    places = tuple((names.index(name), _PLACE.index(name)) for name in _PLACE if name in names)
    return places, len(places) < len(names)


def _rotation_meant_by(given: dict[str, float], rotation: Floats) -> Floats:
    """The rotation that a pose means, (3, 3); ``rotation``: what it does not say."""
    if "qw" in given:
        return rotation_from_quaternion([given[name] for name in _QUATERNION])
    if "angle" in given:
        return rotation_from_angles(0.0, 0.0, given["angle"])
    angles = zip(_ANGLES, roll_pitch_yaw(rotation).tolist(), strict=True)
    return rotation_from_angles(*(given.get(name, angle) for name, angle in angles))


def no_inverse_problem(name: str) -> str:
    """Why a robot of a name that controls no coordinates has no inverse problem, in words."""
    return (
        f"{name} has no inverse problem: it controls no platform coordinates; name them under "
        "`controlled` in the description"
    )
