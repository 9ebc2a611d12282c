# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How numbers look that are in another unit or order, and how far a robot reaches."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .leg_description import DescribedMotor
from .robot_description import RobotDescription

__all__ = [
    "DEGREES",
    "FAR",
    "MILLIMETRES",
    "ORDER",
    "degrees_doubt",
    "doubtful_lead",
    "in_other_units",
    "motor_doubt",
    "reach_of",
    "way_doubt",
]

Floats = NDArray[np.float64]

DEGREES = "looks like degrees, expected radians"
MILLIMETRES = "looks like millimetres, expected metres"
ORDER = "looks like x y z w, expected w x y z"
#: Distance in rod lengths beyond which a place is doubted.
FAR = 10.0
#: Angle of a motor, or of the joint it moves, beyond which it is doubted [rad].
_MANY_TURNS = 4.0 * math.pi
#: Angle of a platform beyond which it is doubted [rad]: a whole turn, and rounding.
_TURN = 2.0 * math.pi + 1e-9
#: Way per turn of a screw, belt or drum that is doubted where it is longer than a rod too [m].
_LEAD = 0.5


def motor_doubt(motor: DescribedMotor, position: float, length: float) -> str:
    """What looks wrong with a position of a motor [rad or m], of a robot of so long rods [m]."""
    if doubtful_lead(motor.unit, motor.moves, motor.ratio, length):
        return ""  # which is said where it is read, and where a number leads says nothing then
    return way_doubt(motor.unit, motor.moves, motor.ratio * position, length)


def way_doubt(unit: str, moves: str, way: float, length: float) -> str:
    """What looks wrong with a number in a unit by which a joint would go so far [rad or m]."""
    if abs(way) <= (_MANY_TURNS if moves == "rad" else FAR * length):
        return ""
    return DEGREES if unit == "rad" else MILLIMETRES


def doubtful_lead(unit: str, moves: str, ratio: float, length: float) -> bool:
    """Whether a motor that turns shifts a joint, or feeds a rod, farther in a turn than screws do."""
    way = 2.0 * math.pi * abs(ratio)
    return (unit, moves) == ("rad", "m") and way > max(_LEAD, length)


def reach_of(description: RobotDescription) -> tuple[float, Floats]:
    """Longest rod [m], and the middle of the bases (3,) [m]; a few that are far away do not move it."""
    middle = np.median([leg.base_position for leg in description.legs], axis=0)
    return description.longest_rod, middle


def degrees_doubt(name: str, angle: float) -> str:
    """What looks wrong with an angle [rad] of a platform, unchanged by whole turns; empty: nothing."""
    if abs(angle) <= _TURN:
        return ""
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return f"{name} at {angle:g} {DEGREES}; radians are taken without whole turns: {wrapped:.6g}"


def in_other_units(description: RobotDescription, motors: Floats) -> Iterator[tuple[Floats, str]]:
    """Motors (n,) as they were meant if they are in another unit, and what then looks wrong."""
    for unit, factor, doubt in (("rad", math.pi / 180.0, DEGREES), ("m", 1e-3, MILLIMETRES)):
        meant = np.array([motor.unit == unit for motor in description.motors], np.bool_)
        if meant.any():
            yield np.where(meant, factor * motors, motors), f"motors: {doubt}"
