# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether measured motors come to where they were sent. No ROS here.

Commands tell where motors are to be. A motor without power, or one that is jammed, gets them and stays
where it is; one with a load is held off them a little, and all of them lag behind.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot
from cpr_core.errors import distinct

from .approach import Approach
from .measured_motors import SeenMotors
from .motor_ways import largest_way

__all__ = ["Elsewhere", "MotorArrival"]

Floats = NDArray[np.float64]


class Elsewhere(NamedTuple):
    """What measurements have against that the motors are where they were sent.

    Attributes:
        why: Which of them are not, or why nobody knows; empty: nothing.
        way: Largest way of a motor that is left [rad, rod lengths]; NaN: nobody knows.
    """

    why: str = ""
    way: float = 0.0


class MotorArrival:
    """Compares motors with their commands, tick by tick.

    Attributes:
        last: What the last look found.
    """

    def __init__(self, robot: Robot) -> None:
        """Have seen nothing yet."""
        self._robot, self._units = robot, robot.motor_units.tolist()
        self._sent: Floats | None = None
        self._approach = Approach()
        self.last = Elsewhere()

    def look(
        self,
        commands: Floats | None,
        seen: SeenMotors,
        tolerance: float,
        now: float,
    ) -> Elsewhere:
        """Compare them.

        Args:
            commands: Where the motors were sent, (n,) [rad or m]; None: nowhere yet.
            seen: Where they are measured.
            tolerance: A motor that is nearer is there [rad, rod lengths]; 0: all are, wherever they are.
            now: Steady time [s].
        """
        if commands is None or not tolerance:
            self.last = Elsewhere()
        elif seen.measured is None:
            self.last = Elsewhere(seen.missing, math.nan) if seen.missing else Elsewhere()
        else:
            self.last = self._compared(commands, seen.measured.motors, tolerance)
        # Commands that a measured pose corrects are never quite still.
        sent = self._sent
        if commands is not None and (
            sent is None or largest_way(sent, commands, self._units) > tolerance
        ):
            self._sent = commands
            self._approach.begin()
        if self.last.why:
            self._approach.take(self.last.way, now)
        else:
            self._approach.begin()
        return self.last

    def waited(self, now: float) -> float:
        """How long they have been elsewhere, and come no nearer, though the commands rest [s]."""
        return max(0.0, now - self._approach.since)

    def _compared(self, commands: Floats, measured: Floats, tolerance: float) -> Elsewhere:
        way = largest_way(commands, measured, self._units)
        if not way > tolerance:
            return Elsewhere()
        told = []
        for number in np.flatnonzero(
            np.abs(commands - measured) > tolerance * self._robot.motor_units
        ):
            motor = self._robot.description.motors[number]
            place, command = distinct(float(measured[number]), float(commands[number]))
            told.append(
                f"{motor.name} is measured at {place} {motor.unit}, its command is {command}"
            )
        away, allowed = distinct(way, tolerance)
        farther = f"{away} (rad or rod lengths) away, more than arrived_tolerance {allowed}"
        return Elsewhere(f"{'; '.join(told)}: {farther}", way)
