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


class MotorLimitArrays(NamedTuple):
    """Limits that motors have, K of them, by motor, that of a position before that of an effort.

    Attributes:
        motors: Number of the motor of each, (K,).
        of_effort: Whether it is one of effort, (K,).
        columns: Where its value is among positions and efforts of n motors, (K,).
        ends: Least and largest value, infinite where not limited [rad, m, N m or N], (K, 2).
        inward: What both distances from these ends are told in, away from the end: natural units of
            the position, or the largest effort, (K, 2) [the same units].
        finite: Which ends there are, (K, 2).
    """

    motors: NDArray[np.int64]
    of_effort: NDArray[np.bool_]
    columns: NDArray[np.int64]
    ends: Floats
    inward: Floats
    finite: NDArray[np.bool_]

    def sides_left(self, motors: Floats, efforts: Floats) -> Floats:
        """How far positions and efforts, (..., n), are from both ends of every limit, (..., K, 2).

        In natural units, and relative to the limits of effort. Unlike the nearest end it has no kink.
        """
        values = np.concatenate([motors, efforts], axis=-1)[..., self.columns, None]
        left: Floats = (values - self.ends) / self.inward
        return left

    def left(self, motors: Floats, efforts: Floats) -> Floats:
        """How far they are from the nearest end of every limit, (..., K)."""
        found: Floats = self.sides_left(motors, efforts).min(axis=-1)
        return found


def motor_limit_arrays(description: RobotDescription, units: Floats) -> MotorLimitArrays:
    """The limits of the motors of a robot, whose natural units are (n,)."""
    limits, count = [motor.limits for motor in description.motors], len(description.motors)
    ranges = [((limit.lower, limit.upper), (-limit.effort, limit.effort)) for limit in limits]
    ends = np.array(ranges, np.float64).reshape(2 * count, 2)
    scales = np.stack([units, ends[1::2, 1]], axis=1).ravel()
    there = np.flatnonzero(np.isfinite(ends).any(axis=1))
    motors, of_effort, ends = there // 2, there % 2 == 1, ends[there]
    inward = scales[there, None] * np.array([1.0, -1.0])
    arrays = motors, of_effort, motors + count * of_effort, ends, inward, np.isfinite(ends)
    return MotorLimitArrays(*map(read_only, arrays))
