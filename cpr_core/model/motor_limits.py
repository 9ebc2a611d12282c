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
    """Limits that motors have, K of them, each at one end of a range.

    They are by motor, that of a position before that of an effort, the lower end before the upper one.

    Attributes:
        motors: Number of the motor of each, (K,).
        of_effort: Whether it is one of effort, (K,).
        upper: Whether it is the upper end of a range, (K,).
        ends: The end [rad, m, N m or N], (K,).
        inward: What the distance from it is told in, negative for upper ends: natural units of the
            position, or the largest effort, (K,) [the same units].
    """

    motors: NDArray[np.int64]
    of_effort: NDArray[np.bool_]
    upper: NDArray[np.bool_]
    ends: Floats
    inward: Floats

    def left(self, motors: Floats, efforts: Floats) -> Floats:
        """How far positions and efforts, (..., n), are from every limit, (..., K)."""
        return self.left_of(
            np.where(self.of_effort, efforts[..., self.motors], motors[..., self.motors])
        )

    def left_of(self, values: Floats) -> Floats:
        """The same of positions and efforts that each limit is about, (..., K).

        In natural units, and relative to the limits of effort.
        """
        found: Floats = (values - self.ends) / self.inward
        return found


def motor_limit_arrays(description: RobotDescription, units: Floats) -> MotorLimitArrays:
    """The limits of the motors of a robot, whose natural units are (n,)."""
    limits = [motor.limits for motor in description.motors]
    ranges = [((limit.lower, limit.upper), (-limit.effort, limit.effort)) for limit in limits]
    ends = np.array(ranges, np.float64).reshape(len(limits), 2, 2)
    motors, of_effort, upper = np.nonzero(np.isfinite(ends))
    scales = np.where(of_effort, ends[motors, 1, 1], units[motors])
    inward = np.where(upper, -scales, scales)
    arrays = motors, of_effort == 1, upper == 1, ends[motors, of_effort, upper], inward
    return MotorLimitArrays(*map(read_only, arrays))
