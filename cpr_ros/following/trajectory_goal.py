# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A goal that moves: where a trajectory has the motors from tick to tick. No ROS here."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, Loads, solve_forward

from .goals import MotorGoal
from .motor_path import MotorPath

__all__ = ["TrajectoryGoal"]

Floats = NDArray[np.float64]

#: A step makes up for ticks that came late, up to this many of them; what is left is made up later.
_LONGEST = 2.0
#: A longer wait than this between two ticks delays the trajectory [ticks].
_STALL = 4.0


class TrajectoryGoal:
    """A path in time, with a time of its own: it runs slower where the robot has to be slow.

    Attributes:
        path: The path.
        time: Where on it the robot is, in time since the start of the trajectory [s].
        last_tick: Steady time of the last tick [s].
    """

    def __init__(
        self,
        path: MotorPath,
        time: float,
        period: float,
        now: float,
        *,
        rests_until: float = -math.inf,
        began: float | None = None,
    ) -> None:
        """Be somewhere on a path.

        Args:
            path: The path.
            time: Where [s].
            period: Time of a tick [s].
            now: Steady time [s].
            rests_until: Up to when the path rests, in its own time: no wait delays it before [s].
            began: Steady time at which its own time is to be 0 [s]; None: what makes it on time now.
        """
        self.path, self.time = path, time
        self._rests_until = rests_until
        self._period, self.last_tick = period, now
        self._began = now - time if began is None else began
        self._clock, self._elapsed = time, 0.0
        self._proposed = (time, time)

    @property
    def destination(self) -> None:
        """None: it depends on the time, too."""
        return None

    @property
    def waits(self) -> bool:
        """Whether its path rests, until its own time has come."""
        return self.time < self._rests_until

    def elapse(self, now: float) -> None:
        """Take note of the time before a tick."""
        elapsed = max(now - self.last_tick, 0.0)
        waited = min(elapsed, max(0.0, self._rests_until - self.time))
        self.time, self._clock = self.time + waited, self._clock + waited
        self._elapsed = min(elapsed - waited, _STALL * self._period)
        self.last_tick = now

    def due(self, now: float) -> float:
        """Time of the trajectory, had it never been slowed down [s]."""
        return now - self._began

    def remaining(self, start: Equilibrium) -> float:
        """0 at the end, infinite on the way."""
        return 0.0 if self.time >= self.path.end else math.inf

    def solve(
        self, start: Equilibrium, fraction: float, loads: Loads, time_limit: float | None = None
    ) -> Equilibrium:
        """Forward problem at a fraction of the time that is left."""
        motors = self.path.at(self.time + fraction * (self.path.end - self.time)).positions
        return solve_forward(start.robot, motors, start=start, loads=loads, time_limit=time_limit)

    def aim(self, start: Equilibrium, factor: float, limits: Floats) -> MotorGoal:
        """Motors of the next tick; see :meth:`accept`.

        Args:
            start: Where the robot is.
            factor: Factor on its speed.
            limits: How far every motor may go in a tick at full speed, (n,) [rad or m].
        """
        clock = self._clock + factor * self._elapsed
        furthest = min(clock, self.time + factor * _LONGEST * self._period, self.path.end)
        first, last = self.time, furthest

        def motors_at(time: float) -> Floats:
            return self.path.at(time).positions

        def steps_to(time: float) -> float:
            return float((np.abs(motors_at(time) - start.motors) / limits).max(initial=0.0))

        if steps_to(last) > factor:
            for _ in range(12):
                middle = 0.5 * (first + last)
                first, last = (first, middle) if steps_to(middle) > factor else (middle, last)
            furthest = first
        self._proposed = (furthest, min(clock, furthest + _STALL * self._period))
        return MotorGoal(start.robot, motors_at(furthest))

    def accept(self) -> None:
        """The robot is where the last aim was."""
        self.time, self._clock = self._proposed
