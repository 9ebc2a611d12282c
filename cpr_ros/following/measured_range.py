# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured motors at the ends of their range, where encoders see them on either side. No ROS here."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpr_core import Robot
from cpr_core.errors import distinct

__all__ = ["BESIDE", "within_range"]

#: How far beyond the end of its range a motor that rests there may be measured [rad, rod lengths].
BESIDE = 1e-3


def within_range(
    robot: Robot, motors: ArrayLike, known: str = "is measured at"
) -> tuple[NDArray[np.float64], str]:
    """Measured motors, those a little beyond the end of their range on it; what is farther, in words.

    Args:
        robot: The robot.
        motors: (n,) [rad or m].
        known: How it is known where they are, in words.

    Returns:
        Motors, (n,), and which of them are farther beyond; empty if none is.
    """
    within, beyond = np.array(motors, float), list[str]()
    for number, motor in robot.limited_motors:
        limits, at = motor.limits, float(within[number])
        end = min(max(at, limits.lower), limits.upper)
        if abs(at - end) <= BESIDE * robot.motor_units[number]:
            within[number] = end
        else:
            told, lower, upper = distinct(at, limits.lower, limits.upper)
            beyond.append(
                f"{motor.name} {known} {told} {motor.unit}, beyond its range [{lower}, {upper}]"
            )
    return within, ", ".join(beyond)
