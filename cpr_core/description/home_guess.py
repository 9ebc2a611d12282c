# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a description knows of the home equilibrium: motors, sides of the rods, rough joints and pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description_part import Part
from ..errors import CprError
from ..lie import rotation_from_quaternion
from ..rods.rod import strain_series
from .leg_description import DescribedMotor, LegDescription, described_motors
from .plausibility import check_home_joints, check_home_motors, check_quaternion
from .robot_description import HomeGuess
from .rough_joints import rough_joints

__all__ = ["home_guess"]

Floats = NDArray[np.float64]


def home_guess(whole: Part, legs: tuple[LegDescription, ...]) -> HomeGuess:
    """The rough home.

    Args:
        whole: The whole description.
        legs: The legs.

    Raises:
        DescriptionError: Not as many motors, sides or strains as there are, or nothing but motors.
    """
    part = whole.part("home")
    motors = _motors(part, legs)
    if not any(name in part for name in ("bow", "platform", "joints", "strain")):
        problem = "expected bow (the side of every rod), rough joints or a rough platform pose"
        raise part.fail("", problem)
    strain = part.get("strain", ())
    if "strain" in part and len(strain) != len(legs):
        raise part.fail("strain", f"expected {len(legs)} entries, one per leg, got {len(strain)}")
    for index, (series, leg) in enumerate(zip(part.parts("strain"), legs, strict=False)):
        if len(leg.rods) != 1:
            problem = (
                f"expected legs of one rod, legs[{index}] has {len(leg.rods)}: give bow instead"
            )
            raise part.fail("strain", problem)
        if part.planar and ("torsion" in series or "bending_2" in series):
            raise series.fail("", "a planar robot bends about d3 only: expected bending_3")
    platform, joints = part.part("platform"), rough_joints(part, legs)
    longest = max(leg.longest_rod for leg in legs)
    check_home_joints(part, (joint for leg in legs for joint in leg.joints), joints, longest)
    return HomeGuess(
        motors=motors,
        platform_position=platform.vector("position") if "platform" in part else None,
        platform_rotation=_rotation(platform) if "quaternion_wxyz" in platform else None,
        strain=tuple(strain_series(series) for series in strain) if "strain" in part else None,
        bow=_bow(part, legs, motors, joints),
        joints=joints,
    )


def _motors(part: Part, legs: tuple[LegDescription, ...]) -> Floats:
    """Motor positions, (n,)."""
    motors, described = part.get("motors"), described_motors(legs)
    if len(motors) != len(described):
        problem = f"expected {len(described)} numbers, one per motor ({_moved(described, legs)})"
        raise part.fail("motors", f"{problem}, got {len(motors)}")
    by_name = dict(zip((motor.name for motor in described), motors, strict=True))
    for rod in (rod for leg in legs for rod in leg.rods):
        if rod.motor is not None and (length := rod.length_at(by_name[rod.motor])) <= 0.0:
            raise part.fail("motors", f"expected positive rod lengths, got {length}")
    check_home_motors(part, described, motors, max(leg.longest_rod for leg in legs))
    return np.array(motors, float)


def _moved(described: Sequence[DescribedMotor], legs: tuple[LegDescription, ...]) -> str:
    """Motors with the legs they move: a name that was copied with its leg is seen there."""
    return ", ".join(
        f"{motor.name} of "
        + " and ".join(
            leg.name for leg in legs if any(motor.name == part.motor for part in leg.chain)
        )
        for motor in described
    )


def _rotation(part: Part) -> Floats:
    """Rotation of the platform, (3, 3)."""
    quaternion = part.get("quaternion_wxyz")
    try:
        rotation = rotation_from_quaternion(quaternion)
    except CprError as error:
        raise part.fail("quaternion_wxyz", str(error)) from None
    check_quaternion(part, "quaternion_wxyz", quaternion)
    if part.planar and rotation[2, 2] < 1.0 - 1e-9:
        raise part.fail(
            "quaternion_wxyz",
            f"expected a rotation about z in a planar robot, w 0 0 z, got {list(quaternion)}",
        )
    return rotation


def _bow(
    part: Part,
    legs: tuple[LegDescription, ...],
    motors: Floats,
    joints: Mapping[str, float],
) -> tuple[Floats | None, ...]:
    """Sides to which the rods bow, in the world; None: straight."""
    given = part.get("bow", [None] * len(legs))
    # One side for all legs: a word, or a vector.
    same_for_all = isinstance(given, str) or (
        len(given) == 3 and all(isinstance(entry, int | float) for entry in given)
    )
    every = [given] * len(legs) if same_for_all else given
    if len(every) != len(legs):
        raise part.fail("bow", f"expected {len(legs)} sides, got {len(every)}")
    middle = np.mean([leg.base_position for leg in legs], axis=0)
    names = [motor.name for motor in described_motors(legs)]
    positions = dict(zip(names, motors.tolist(), strict=True))
    found: list[Floats | None] = []
    for index, (side, leg) in enumerate(zip(every, legs, strict=True)):
        frame = leg.rod_frame(positions, joints)
        name = "bow" if same_for_all else f"bow[{index}]"
        found.append(None if side is None else _side(part, name, side, leg, frame, middle))
    return tuple(found)


def _side(
    part: Part, name: str, side: Any, leg: LegDescription, frame: Floats, middle: Floats
) -> Floats:
    """A side as a unit vector across the rod at its base."""
    tangent, left = frame[:, 0], frame[:, 1]
    if side in ("left", "right"):
        if not part.planar:
            raise part.fail(name, f"expected outward, inward or a vector, got {side!r}")
        vector = left if side == "left" else -left
    elif side in ("outward", "inward"):
        vector = leg.base_position - middle
        vector = vector if side == "outward" else -vector
    else:
        vector = part.in_plane(name, side)
    across = vector - (vector @ tangent) * tangent
    # The length of a vector says nothing; which way from the middle to a base is short, rods say.
    size = float(np.linalg.norm(vector))
    if isinstance(side, str):
        size = max(size, leg.longest_rod)
    if np.linalg.norm(across) <= 1e-6 * size:
        raise part.fail(name, f"expected a side across the tangent of {leg.name} at its base")
    return np.asarray(across / np.linalg.norm(across))
