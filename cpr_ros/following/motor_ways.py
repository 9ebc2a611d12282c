# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far motors are apart, and how far they may go in a time. No ROS here."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

__all__ = ["SLACK", "largest_way", "motor_steps"]

Floats = NDArray[np.float64]

#: By what part a step, or a speed, may be larger than it should be: that much is rounding.
SLACK = 1e-6


def largest_way(first: Floats, last: Floats, units: list[float]) -> float:
    """Largest way of a motor between two places.

    Args:
        first: (n,) [rad or m].
        last: (n,) [rad or m].
        units: What the way of each motor is counted in, such as radians and rod lengths.
    """
    # Not with numpy, which takes several times as long on so few numbers when it has not run lately.
    ways = zip(first.tolist(), last.tolist(), units, strict=True)
    return max((abs(after - before) / unit for before, after, unit in ways), default=0.0)


def motor_steps(robot: Robot, max_speed: float, period: float) -> Floats:
    """How far every motor may go in a time, (n,) [rad or m].

    Args:
        robot: The robot; a motor with a speed limit keeps it.
        max_speed: Speed no motor exceeds, behind its gear [rad/s, rod lengths/s].
        period: The time, such as that of a tick [s].
    """
    own = [motor.limits.speed for motor in robot.description.motors]
    return period * np.minimum(own, max_speed * robot.motor_units)
