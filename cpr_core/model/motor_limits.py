# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of motors as arrays: looked at in every step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.robot_description import RobotDescription
from ..validation import read_only

__all__ = ["MotorLimitArrays", "motor_limit_arrays"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class MotorLimitArrays(NamedTuple):
    """Limits that motors have.

    Attributes:
        ranged: Numbers of the motors with a position limit, (k,).
        lower: Smallest, and
        upper: largest position of these, infinite where not limited [rad or m].
        loaded: Numbers of the motors with an effort limit, (m,).
        effort: Largest effort of these [N m or N].
        order: Position limits, then effort limits, by motor, (k + m,).
        unit: Natural units of the motors with a position limit, (k,) [rad or m].
    """

    ranged: Integers
    lower: Floats
    upper: Floats
    loaded: Integers
    effort: Floats
    order: Integers
    unit: Floats

    def ranges_left(self, motors: Floats) -> Floats:
        """How far motors at (..., n) are from their position limits, in natural units, (..., k)."""
        at = motors[..., self.ranged]
        left: Floats = np.minimum(at - self.lower, self.upper - at) / self.unit
        return left

    def sides_left(self, motors: Floats, efforts: Floats) -> Floats:
        """How far motors (n,) and efforts (n,) are from either end of their limits, (2 k + 2 m,).

        In natural units, and relative to the limits of effort. Unlike the nearest end it has no kink.
        """
        at, part = motors[self.ranged], efforts[self.loaded] / self.effort
        lower, upper = (at - self.lower) / self.unit, (self.upper - at) / self.unit
        return np.concatenate([lower, upper, 1.0 + part, 1.0 - part])

    def effort_reserves(self, efforts: Floats) -> Floats:
        """What efforts (..., n) leave of the effort limits, relative to these, (..., m)."""
        reserves: Floats = 1.0 - np.abs(efforts[..., self.loaded]) / self.effort
        return reserves


def motor_limit_arrays(description: RobotDescription, units: Floats) -> MotorLimitArrays:
    """The limits of the motors of a robot, whose natural units are (n,)."""
    limits = [motor.limits for motor in description.motors]
    ranges = np.array([(limit.lower, limit.upper) for limit in limits]).reshape(-1, 2)
    efforts = np.array([limit.effort for limit in limits])
    ranged = np.flatnonzero(np.isfinite(ranges).any(axis=1))
    loaded = np.flatnonzero(np.isfinite(efforts))
    lower, upper = ranges[ranged].T
    order = np.argsort(np.concatenate([ranged, loaded]), kind="stable")
    arrays = ranged, lower, upper, loaded, efforts[loaded], order, units[ranged]
    return MotorLimitArrays(*map(read_only, arrays))
