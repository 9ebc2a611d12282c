# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The motor commands, and that none is farther from the one before than a tick's way. No ROS here."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

from .goals import largest_way, motor_steps

__all__ = ["MotorCommands"]

Floats = NDArray[np.float64]

#: What rounding may add to a step, relative.
_SLACK = 1e-5


class MotorCommands:
    """Where the motors are sent, step by step.

    Attributes:
        newest: The last command, or where the motors are known to be, (n,) [rad or m]; None: nothing
            is known, the first command goes anywhere.
        said: Whether it may be said again: not where others have moved the motors.
    """

    def __init__(self, robot: Robot, period: float) -> None:
        """Know nothing yet.

        Args:
            robot: The robot.
            period: Time of a tick [s].
        """
        self.robot, self.period = robot, period
        self.newest: Floats | None = None
        self.said = True
        self._speed, self._steps = math.nan, list[float]()

    def place(self, motors: Floats | None, *, said: bool = True) -> None:
        """Take note of where the motors are, (n,): measured, or commanded before."""
        self.said = said
        self.newest = None if motors is None else np.array(motors, float)

    def aligned_with(self, motors: Floats) -> bool:
        """Whether the last command was to these motors, (n,); holds of any while none is known."""
        # In lists: this is asked whenever anything has come, and numpy takes several times as long.
        return self.newest is None or self.newest.tolist() == motors.tolist()

    def step_to(self, motors: Floats, max_speed: float) -> Floats:
        """The next command on the straight way to motors, (n,).

        Args:
            motors: Where the motors shall be in the end.
            max_speed: Speed no motor exceeds [rad/s, rod lengths/s]; a motor's own limit holds as well.
        """
        command = np.array(motors, float)
        if self.newest is not None:
            if max_speed != self._speed:
                steps = motor_steps(self.robot, max_speed, self.period)
                self._speed, self._steps = max_speed, steps.tolist()
            ticks = largest_way(self.newest, command, self._steps)
            if ticks > 1.0 + _SLACK:
                command = self.newest + (command - self.newest) / ticks
        self.newest, self.said = command, True
        return command
