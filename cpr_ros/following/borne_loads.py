# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Other loads at the same motors: followed from tick to tick, borne or refused. No ROS here."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from cpr_core import Loads, Robot
from cpr_core.model.assessment import Assessment

from .goals import MotorGoal
from .refused_step import RefusedStep, Step
from .steps import LONGEST_SOLVE, Undecided, attempt
from .supervision import Refusal

__all__ = ["BorneLoads"]

#: A tick that gets less far than this part of the way that is left may take twice as long the next time:
#: near where a branch ends nothing is told in a short time, and the same short time tells it never.
_FAR = 0.1
#: It takes no longer than this [s]; what is not told by then is asked for again, but not all the time.
_LONGEST = 8.0 * LONGEST_SOLVE


@dataclass(frozen=True)
class _Way:
    """A way to other loads, which may take several ticks.

    Attributes:
        current: The equilibrium of the robot all the while.
        loads: Where it leads.
        reached: How far it was followed; of a load that never acts, so nobody else is told.
        time_limit: Of the next tick on it [s].
        bent: Whether it led to other loads first.
    """

    current: Assessment
    loads: Loads
    reached: Assessment
    time_limit: float = LONGEST_SOLVE
    bent: bool = False


class BorneLoads:
    """The equilibrium under the loads of now, at the same motors."""

    def __init__(self, robot: Robot) -> None:
        """Know nothing of any way.

        Args:
            robot: The robot.
        """
        self._robot, self._refused = robot, RefusedStep()
        self._way: _Way | None = None

    def at(
        self, current: Assessment, loads: Loads, now: float
    ) -> tuple[Assessment, Refusal | None]:
        """The equilibrium under the loads of now, and what a supervisor has to be told of it.

        Args:
            current: Current equilibrium, which it remains while other loads are not borne.
            loads: Loads that act now; the object of the equilibrium if they have not changed.
            now: Steady time [s].
        """
        if loads is current.equilibrium.loads:
            self._way = None
            return current, None
        goal = MotorGoal(self._robot, current.equilibrium.motors)
        step = Step(current, loads, goal.destination)
        refusal = self._refused.again(step, now)
        if refusal is not None:
            return current, refusal
        begin, way = time.perf_counter(), self._way_to(current, loads)
        ahead = _ahead(way, goal)
        if isinstance(ahead, Assessment):
            self._way = None
            return ahead, None
        if isinstance(ahead, Undecided):
            refusal = self._undecided(way, ahead)
            told = isinstance(refusal, Undecided)
        else:
            self._way, told = None, not way.bent  # without the bend it may be borne
            refusal = Refusal(ahead.reason, f"the external wrench is not borne: {ahead.text}")
        if told:
            self._refused.take(step, refusal, now, time.perf_counter() - begin)
        return current, refusal

    def _way_to(self, current: Assessment, loads: Loads) -> _Way:
        """The way on: the last one as long as it is not at its end, to other loads if these come."""
        way = self._way
        if way is not None and way.current is current:
            if way.loads is loads:
                return way
            if loads.differences(current.equilibrium.loads):
                return replace(way, loads=loads, bent=True)
        return _Way(current, loads, current)

    def _undecided(self, way: _Way, ahead: Undecided) -> Refusal:
        """What is told of a way that is not at its end; undecided if it is not to be asked for soon."""
        far, most = ahead.fraction >= _FAR, way.time_limit >= _LONGEST
        time_limit = way.time_limit if far else min(_LONGEST, 2.0 * way.time_limit)
        self._way = replace(way, reached=ahead.reached or way.reached, time_limit=time_limit)
        if most and not far:
            return Undecided(ahead.reason, f"the external wrench is not borne: {ahead.text}")
        return Refusal(ahead.reason, f"the external wrench is not borne yet: {ahead.text}")


def _ahead(way: _Way, goal: MotorGoal) -> Assessment | Refusal:
    """Where a way ends, or why it does not, or not yet."""
    ahead = attempt(way.reached, goal, 1.0, way.loads, way.time_limit)
    if isinstance(ahead, Assessment) and ahead.index > way.current.index:
        return Refusal("margin", "the robot buckles")
    return ahead
