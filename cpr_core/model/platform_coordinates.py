# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which motions the platform of a robot has, and which of them an inverse problem controls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.controlled_coordinates import CONTROLLED_COORDINATES
from ..description.robot_description import RobotDescription
from ..kernels.twist_layout import FIRST_LINEAR
from ..validation import read_only

__all__ = ["PlatformCoordinates", "platform_coordinates", "six_components"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class PlatformCoordinates(NamedTuple):
    """Components of the world twist [omega; v].

    Attributes:
        axes: Those the platform has.
        controlled: Those that move the controlled coordinates. Where angles are controlled the first
            three stand for roll, pitch and yaw.
        controls_angles: Whether single angles of Rz(yaw) Ry(pitch) Rx(roll) are controlled.
        controls_turns: Whether any turn of the platform is.
        controlled_positions: Those of x y z that are controlled.
    """

    axes: Integers
    controlled: Integers
    controls_angles: bool
    controls_turns: bool
    controlled_positions: slice

    @property
    def poses_are_whole(self) -> bool:
        """Whether a pose alone tells where the platform is; with single angles it is asked each time."""
        return len(self.controlled) == len(self.axes) and not self.controls_angles


def platform_coordinates(description: RobotDescription) -> PlatformCoordinates:
    """The platform coordinates of a robot."""
    if description.planar:
        axes = np.array([3, 4] if description.point_platform else [2, 3, 4])
    else:
        axes = np.arange(6)
    coordinates = [CONTROLLED_COORDINATES[name] for name in description.controlled]
    controlled = [axis for coordinate in coordinates for axis in coordinate.axes]
    positions = [axis - FIRST_LINEAR for axis in controlled if axis >= FIRST_LINEAR]
    return PlatformCoordinates(
        axes=read_only(axes),
        controlled=read_only(np.array(controlled, dtype=np.int64)),
        controls_angles=any(coordinate.is_single_angle for coordinate in coordinates),
        controls_turns=any(coordinate.turns for coordinate in coordinates),
        controlled_positions=_evenly_apart(positions),
    )


def _evenly_apart(positions: list[int]) -> slice:
    """Some of x y z, as any of them are: numpy finds a slice in a third of the time of a list."""
    if not positions:
        return slice(0)
    first, last = min(positions), max(positions)
    return slice(first, last + 1, max(1, last - first) if len(positions) == 2 else 1)


def six_components(axes: Integers, own: Floats) -> Floats:
    """Twists or wrenches, (6, ...), of which a platform has some components: the others are zero.

    Args:
        axes: Components it has.
        own: Their values, (b, ...).
    """
    found = np.zeros((6, *own.shape[1:]))
    found[axes] = own
    return found
