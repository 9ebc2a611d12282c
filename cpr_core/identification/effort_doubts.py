# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motor efforts that look like others than expected: in other units, of the other sign, of the joint.

A wrench that nobody knows changes efforts too. So another sign, or a gear, is only looked for where
measurements cannot be explained as they are; units where no wrench makes efforts so large or small.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.robot import Robot
from ..model.world_response import effort_units

__all__ = ["BETTER", "THOUSAND", "EffortReading", "effort_unit_doubt", "other_efforts"]

Floats = NDArray[np.float64]

#: Ratios of measured to predicted numbers between which one unit is taken for another.
THOUSAND = (200.0, 5000.0)
#: What another reading of a measurement has to leave, of what is left of it as it is.
BETTER = 0.3
#: What efforts that are too large, or too small, are large or small beside, in natural units.
_LARGE, _SMALL = 10.0, 0.01
#: How far beyond its limit no motor is by a strong wrench.
_BEYOND_LIMIT = 10.0
#: Gears that change efforts by less are not told from a wrench.
_GEAR = 5.0


@dataclass(frozen=True, eq=False)
class EffortReading:
    """What measured efforts may be.

    Attributes:
        factors: What makes of them those that are expected, (n,).
        doubt: What looks wrong then, in words.
    """

    factors: Floats
    doubt: str


def effort_unit_doubt(robot: Robot, measured: Floats, modelled: Floats) -> str:
    """What looks like other units in efforts, whatever pushes on the robot; empty: nothing.

    Args:
        robot: The robot.
        measured: Its efforts, NaN for those that were not measured, (n,) [N m or N].
        modelled: Those of the model without a wrench, (n,) [N m or N].
    """
    sizes = _Sizes(robot, measured, modelled)
    large, small = sizes.measured, sizes.modelled
    if THOUSAND[0] * small < large < THOUSAND[1] * small and large > _LARGE:
        factor, seen = (
            1e-3,
            "a thousand times those of the model without a wrench: are they in N mm?",
        )
    elif THOUSAND[0] * large < small < THOUSAND[1] * large and small > _SMALL:
        factor, seen = 1e3, "a thousandth of those of the model without a wrench: are they in kN m?"
    else:
        return ""
    units = EffortReading(
        np.full(robot.motor_count, factor),
        f"the measured efforts are about {seen} N m and N are expected",
    )
    nearest = min(
        [units, *other_efforts(robot, measured, modelled)],
        key=lambda each: sizes.apart(each.factors),
    )
    return nearest.doubt


def other_efforts(robot: Robot, measured: Floats, modelled: Floats) -> Iterator[EffortReading]:
    """Other signs and places of efforts by which they are near those of the model, and else are not.

    Args:
        robot: The robot.
        measured: Its efforts in any number of rows, NaN for those that were not measured, (..., n)
            [N m or N].
        modelled: Those of the model, (..., n) [N m or N].
    """
    sizes = _Sizes(robot, measured, modelled)
    if not sizes.modelled > _SMALL:
        return
    ones = np.ones(robot.motor_count)
    if sizes.near(-ones):
        yield EffortReading(
            -ones,
            "efforts look like those with the other sign (expected: what the motor does to the rod)",
        )
    ratios = np.array([motor.ratio for motor in robot.description.motors])
    limits = np.array([motor.limits.effort for motor in robot.description.motors])
    beyond = np.abs(sizes.efforts) > np.minimum(
        _LARGE, _BEYOND_LIMIT * limits / effort_units(robot)
    )
    for factors, place in ((ratios, "those behind"), (1.0 / ratios, "those taken twice through")):
        change = sizes.change(factors)
        told = change * _GEAR < 1.0 and beyond.any() if change < 1.0 else change > _GEAR
        if told and sizes.near(factors):
            yield EffortReading(factors, f"efforts look like {place} {_gear(robot, sizes, ratios)}")


class _Sizes:
    """Sizes of efforts in natural units, as far as they are measured.

    Torques count in E J / l, forces in E J / l^2, so that motors that turn and such that push add up.
    """

    def __init__(self, robot: Robot, measured: Floats, modelled: Floats) -> None:
        """Arguments as in :func:`other_efforts`."""
        known, self.units = np.isfinite(measured), effort_units(robot)
        self.efforts = np.where(known, measured, 0.0) / self.units
        self.expected = np.where(known, modelled, 0.0) / self.units
        self.measured = float(np.linalg.norm(self.efforts))
        self.modelled = float(np.linalg.norm(self.expected))

    def change(self, factors: Floats) -> float:
        """How large efforts are times factors, over what they are without."""
        size = float(np.linalg.norm(factors * self.efforts))
        return size / self.measured if self.measured > 0.0 else 1.0

    def apart(self, factors: Floats) -> float:
        """How far efforts times factors are from those of the model, of both sizes, in [0, 1]."""
        meant = factors * self.efforts
        both = float(np.linalg.norm(meant)) + self.modelled
        return float(np.linalg.norm(meant - self.expected)) / both if both > 0.0 else 0.0

    def near(self, factors: Floats) -> bool:
        """Whether they are near those of the model, and nearer than without factors."""
        left = float(np.linalg.norm(factors * self.efforts - self.expected))
        before = float(np.linalg.norm(self.efforts - self.expected))
        return self.apart(factors) < BETTER and left < BETTER * before


def _gear(robot: Robot, sizes: _Sizes, ratios: Floats) -> str:
    """The gear or the screw of the motor whose effort is farthest from the model, in words."""
    motors, count = robot.description.motors, robot.motor_count
    away = np.abs(sizes.efforts - sizes.expected).reshape(-1, count) * (ratios != 1.0)
    row, number = np.unravel_index(int(np.argmax(away)), away.shape)
    motor, unit = motors[number], sizes.units[number]
    own, expected = (
        values.reshape(-1, count)[row, number] * unit for values in (sizes.efforts, sizes.expected)
    )
    screw = (motor.unit, motor.moves) == ("rad", "m")
    gear, name, size = (
        ("screw", "lead", 2.0 * math.pi * motor.ratio) if screw else ("gear", "ratio", motor.ratio)
    )
    return (
        f"the {gear}: {motor.name} at {own:.3g} {motor.effort_unit}, expected about {expected:.2g}; "
        f"{name} is {size:g}"
    )
