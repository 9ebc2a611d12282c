# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the robot would be like a step of a motor away, whichever motor that is. No ROS here."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cpr_core.model.assessment import MEASURES, Assessment, Thresholds

from .goals import MotorGoal
from .steps import attempt, change_between
from .supervision import Refusal

__all__ = ["Surroundings"]

Floats = NDArray[np.float64]

#: Factor on the sum of what single motors change of a measure: for motors that move together, and for
#: curvature.
_TOGETHER = 2.0


class Surroundings:
    """The robot a step of one motor away, either way, solved one after the other.

    Measures change little within a step, so what single motors do to them says what they can do
    together: at most the sum, doubled for what is not linear. It is an estimate, for the one step that
    is commanded before it is solved.

    Attributes:
        current: Where the robot is.
    """

    def __init__(self, current: Assessment, steps: Floats) -> None:
        """Know nothing yet.

        Args:
            current: Where the robot is.
            steps: How far every motor may go, (n,) [rad or m].
        """
        self.current = current
        self._ahead = [(number, way) for number, step in enumerate(steps) for way in (step, -step)]
        self._ahead.reverse()
        self._changes = {name: np.zeros(len(steps)) for name in MEASURES}
        self._motions = np.zeros(len(steps))
        self._barred = False

    @property
    def known(self) -> bool:
        """Whether there is nothing more to look at."""
        return self._barred or not self._ahead

    def look(self) -> None:
        """Solve at one more place; where that cannot be, or measures cannot be had, no step is sure."""
        number, way = self._ahead.pop()
        try:
            self._compare(number, way)
        except Exception:  # nobody has asked for it: who goes there is told what is wrong
            self._barred = True

    def _compare(self, number: int, way: float) -> None:
        start = self.current.equilibrium
        motors = start.motors.copy()
        motors[number] += way
        goal = MotorGoal(start.robot, motors)  # within the limits of the motor, as a setpoint is
        found = attempt(self.current, goal, 1.0, start.loads)
        if isinstance(found, Refusal) or found.index != self.current.index:
            self._barred = True
            return
        motion = change_between(start, found.equilibrium)
        self._motions[number] = np.maximum(self._motions[number], motion)
        for name, changes in self._changes.items():
            before, after = self.current.value(name), found.value(name)
            if before != after:  # else perhaps both infinite, where nothing limits it
                changes[number] = np.maximum(changes[number], abs(after - before))  # NaN stays

    def free(self, thresholds: Thresholds, largest_change: float, measures: Iterable[str]) -> bool:
        """Whether all motors may go up to a step anywhere, without being slowed down.

        Args:
            thresholds: Of every measure.
            largest_change: Of a configuration in a step, see :func:`change_between`.
            measures: Those that count.
        """
        if not self.known or self._barred:
            return False
        if _TOGETHER * self._motions.sum() > largest_change:
            return False
        return all(
            self.current.value(name) - _TOGETHER * float(self._changes[name].sum())
            >= max(thresholds[name].warning, thresholds[name].stop)
            for name in measures
        )
