# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The motor commands: none is farther than a tick's way from the one before. No ROS here.

Where the motors are measured, none is farther from there either than they may be behind: one that jams
or has no power holds up all the others, which would bend the rods between them, and does not jump far
when it goes on. So does one that is measured beside its way.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

from .motor_ways import largest_way, motor_steps

__all__ = ["MotorCommands"]

Floats = NDArray[np.float64]

#: What rounding may add to a step, relative: more than to that of a goal, which is not cut so.
_SLACK = 1e-5
#: Ahead of its way a motor is where it did not follow before, and is sent back to; not so much farther.
_NOT_BEHIND = 2.0


class MotorCommands:
    """Where the motors are sent, step by step.

    Attributes:
        newest: The last command, or where the motors are known to be, (n,) [rad or m]; None: nothing
            is known, the first command goes anywhere.
        repeatable: Whether it may be sent again: not where others have moved the motors.
        waits: Whether the last step was none: measured motors are too far behind.
        max_lead: Commands are ahead of measured motors by what these do at full speed in so long at most
            [s], or in a tick; 0: by anything.
        tolerance: Motors that are not behind wait if they are measured farther off than this, and than
            `max_lead` allows [rad, rod lengths]; 0: wherever they are.
        beside: Name of a motor that the last step was shortened for, as it is not behind but elsewhere.
    """

    def __init__(
        self, robot: Robot, period: float, max_lead: float = 0.0, tolerance: float = 0.0
    ) -> None:
        """Know nothing yet.

        Args:
            robot: The robot.
            period: Time of a tick [s].
            max_lead: See the attribute [s].
            tolerance: See the attribute [rad, rod lengths].
        """
        self.robot, self.period, self.max_lead = robot, period, max_lead
        self.tolerance, self.beside = tolerance, ""
        self.newest: Floats | None = None
        self.repeatable, self.waits = True, False
        self._speed, self._steps = math.nan, list[float]()
        self._units = robot.motor_units.tolist()

    def place(self, motors: Floats | None, *, repeatable: bool = True) -> None:
        """Take note of where the motors are, (n,): measured, or commanded before."""
        self.repeatable, self.waits = repeatable, False
        self.newest = None if motors is None else np.array(motors, float)

    def aligned_with(self, motors: Floats) -> bool:
        """Whether the last command was to these motors, (n,); holds of any while none is known."""
        # In lists: this is asked whenever anything has come, and numpy takes several times as long.
        return self.newest is None or self.newest.tolist() == motors.tolist()

    def step_to(
        self, motors: Floats, max_speed: float, measured: Floats | None = None
    ) -> Floats | None:
        """The next command on the straight way to motors, (n,); None: measured ones are too far behind.

        Args:
            motors: Where the motors shall be in the end.
            max_speed: Speed no motor exceeds [rad/s, rod lengths/s]; a motor's own limit holds as well.
            measured: Where they are, (n,); None: nobody measures.
        """
        command = np.array(motors, float)
        if self.newest is not None:
            ticks = largest_way(self.newest, command, self._steps_at(max_speed))
            part = 1.0 / ticks if ticks > 1.0 + _SLACK else 1.0
            in_reach = self.part_in_reach(command, max_speed, measured)
            if in_reach < part and in_reach * ticks <= _SLACK:
                self.waits = True
                return None
            part = min(part, in_reach)
            if part < 1.0:
                command = self.newest + part * (command - self.newest)
        self.newest, self.repeatable, self.waits = command, True, False
        return command

    def part_in_reach(self, motors: Floats, max_speed: float, measured: Floats | None) -> float:
        """Part of the straight way to motors that takes none too far from where it was measured.

        None that is too far already goes any farther. Arguments as in :meth:`step_to`.
        """
        self.beside = ""
        if self.newest is None or measured is None or not self.max_lead:
            return 1.0
        part, lead, steps = 1.0, self._lead_in_ticks, self._steps_at(max_speed)
        for name, unit, begin, end, place, step in zip(
            self.robot.motor_names,
            self._units,
            self.newest.tolist(),
            motors.tolist(),
            measured.tolist(),
            steps,
            strict=True,
        ):
            ahead = (begin - place) * math.copysign(1.0, end - begin)
            beside = abs(ahead) if begin == end else -ahead / _NOT_BEHIND
            allowed = (1.0 + 10.0 * _SLACK) * max(lead * step, self.tolerance * unit)
            if beside > allowed and self.tolerance:
                self.beside = name
                return 0.0
            if begin != end:
                part = min(part, (max(lead * step, abs(ahead)) - ahead) / abs(end - begin))
        return 1.0 if part > 1.0 - _SLACK else part

    def in_reach(self, measured: Floats | None, max_speed: float) -> bool:
        """Whether no motor is measured too far from the last command; arguments of :meth:`step_to`."""
        if self.newest is None or measured is None or not self.max_lead:
            return True
        ahead = largest_way(measured, self.newest, self._steps_at(max_speed))
        return ahead <= self._lead_in_ticks * (1.0 + _SLACK)

    @property
    def _lead_in_ticks(self) -> float:
        return max(1.0, self.max_lead / self.period)

    def _steps_at(self, max_speed: float) -> list[float]:
        """How far every motor may go in a tick, (n,)."""
        if max_speed != self._speed:
            steps = motor_steps(self.robot, max_speed, self.period)
            self._speed, self._steps = max_speed, steps.tolist()
        return self._steps
