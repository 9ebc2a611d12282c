# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far a tick goes: slower near thresholds, half of what is refused, no farther than motors follow.

A tick solves at the next motors from the current equilibrium, looks at the measures there, and only then
accepts. What is refused leaves the motors where they are, and the next tick tries half the step. Speed
falls linearly between the warning and the stop threshold of every measure that gets worse; what gets
better is never limited. No ROS here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from cpr_core.model.assessment import MEASURES, Assessment

from .goals import Goal
from .judged_steps import JudgedSteps
from .motor_ways import SLACK
from .steps import falls
from .supervision import Refusal
from .trajectory_goal import TrajectoryGoal

__all__ = ["PacedSteps"]

#: Part of their speed that motors keep just above a stop threshold, so that the halt is reached in
#: finite time.
_CREEP = 0.02
#: Where measured motors are behind, a step ends at this part of what they may be ahead: on the way to
#: a pose they do not go straight.
_INSIDE = 0.98
#: A step that is shortened to less than this part is not taken.
_NOWHERE = 1e-3
#: Smallest part of a step that is tried; when it is refused, the robot is halted.
_SMALLEST_REACH = 1.0 / 64.0


class PacedSteps:
    """Takes steps towards a goal as far as they may go.

    Attributes:
        caution: Factor that speeds do not exceed: less than 1 while something is not seen.
        waits: Whether the last tick went less far, or nowhere, as motors are behind.
        reach: Part of a step that is tried next, less than 1 after one that was refused.
        refusal: Why the robot is halted, if it is.
        worsening: Measures that fell in the last step.
    """

    def __init__(
        self,
        steps: JudgedSteps,
        part_in_reach: Callable[[NDArray[np.float64]], float],
    ) -> None:
        """Have taken none yet.

        Args:
            steps: Where ticks lead, solved and judged.
            part_in_reach: Part of the way to motors, (n,), that they may be sent now.
        """
        self._steps, self._part_in_reach = steps, part_in_reach
        self.caution = 1.0
        self.worsening: frozenset[str] = frozenset(MEASURES)
        self.refusal: Refusal | None
        self.forget()

    def forget(self) -> None:
        """Nothing has been refused, and no motors are behind: there is no goal any more."""
        self.waits, self.reach, self.refusal = False, 1.0, None

    def step(
        self,
        current: Assessment,
        goal: Goal,
        watched: tuple[str, ...],
        now: float,
        *,
        out_of_rest: bool,
    ) -> Assessment:
        """One step towards a goal, or the same equilibrium if it is refused or out of reach.

        Args:
            current: Where the robot is.
            goal: Where it is to go.
            watched: Measures that count.
            now: Steady time [s].
            out_of_rest: As of :meth:`JudgedSteps.aim`.
        """
        within = 1.0
        for _ in range(3):
            factor = within * self.reach * self._speed_scale(current, watched)
            ahead = self._steps.towards(
                current, goal, factor, watched, now, out_of_rest=out_of_rest
            )
            if isinstance(ahead, Refusal):
                if self.reach <= _SMALLEST_REACH:
                    self.refusal = ahead
                self.reach = max(_SMALLEST_REACH, 0.5 * self.reach)
                return current
            self.worsening = frozenset(
                name for name in watched if falls(current.value(name), ahead.value(name))
            )
            part = self._part_in_reach(ahead.equilibrium.motors)
            if part < 1.0:
                self.waits = True
                within *= _INSIDE * part
                if within < _NOWHERE:
                    return current
                continue
            allowed = self._speed_scale(current, watched)
            if self._steps.ticks_between(
                current.equilibrium.motors, ahead.equilibrium.motors
            ) <= allowed * (1.0 + SLACK):
                self.reach = min(1.0, 2.0 * self.reach)
                self.refusal = None
                if isinstance(goal, TrajectoryGoal):
                    goal.accept()
                return ahead
            # It was not known that this way leads to a threshold, or out of reach: again, slower.
        return current

    def _speed_scale(self, current: Assessment, watched: Iterable[str]) -> float:
        """Factor on the speed of a motion that worsens what the last one worsened."""
        thresholds = self._steps.settings.thresholds
        levels = [
            thresholds[name].level(current.value(name))
            for name in self.worsening
            if name in watched
        ]
        known = (level for level in levels if not math.isnan(level))
        return max(_CREEP, min([self.caution, *known]))
