# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of motors as arrays: looked at in every step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.robot_description import RobotDescription

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
    """

    ranged: Integers
    lower: Floats
    upper: Floats
    loaded: Integers
    effort: Floats
    order: Integers


def motor_limit_arrays(description: RobotDescription) -> MotorLimitArrays:
    """The limits of the motors of a robot."""
    limits = [motor.limits for motor in description.motors]
    ranges = np.array([(limit.lower, limit.upper) for limit in limits]).reshape(-1, 2)
    efforts = np.array([limit.effort for limit in limits])
    ranged = np.flatnonzero(np.isfinite(ranges).any(axis=1))
    loaded = np.flatnonzero(np.isfinite(efforts))
    lower, upper = ranges[ranged].T
    order = np.argsort(np.concatenate([ranged, loaded]), kind="stable")
    return MotorLimitArrays(ranged, lower, upper, loaded, efforts[loaded], order)
