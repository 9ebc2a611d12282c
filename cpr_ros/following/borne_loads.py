# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Other loads at the same motors: followed from tick to tick, borne or refused. No ROS here."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cpr_core import Loads, Robot
from cpr_core.model.assessment import Assessment

from .goals import MotorGoal
from .refused_step import RefusedStep, Step
from .steps import Undecided, attempt
from .supervision import Refusal

__all__ = ["BorneLoads", "Snapped"]

#: A tick that follows less than this part of what is left of the way has got nowhere: near the end of
#: a branch the time of a tick is too short to tell whether the loads are borne. A longer tick would
#: tell more, but streams wait for it.
_NOWHERE = 0.01
#: After so many ticks in a row that got nowhere the loads are taken for not borne, and are asked for
#: again only now and then.
_PATIENCE = 4

#: How long it is told that the robot may have snapped [s]: messages are made between ticks, some of
#: them later.
_TOLD = 0.3

_WAY_OUT = "measure the motors, or apply a solution from home"
_TAKEN = "it is taken to be where it was before that wrench, but may have snapped elsewhere"


@dataclass(frozen=True)
class Snapped(Refusal):
    """The robot may have snapped; the equilibrium it is told with is taken for where it is."""


@dataclass(frozen=True)
class _Way:
    """A way to other loads, which may take several ticks.

    Attributes:
        current: The equilibrium of the robot all the while.
        loads: Where it leads.
        reached: How far it was followed; of a load that never acts, so nobody else is told.
        idle: How many ticks in a row have got nowhere on it.
        bent: Whether it led to other loads first.
        back: Why the straight way is refused, if this is one from before the wrench; None: this is it.
    """

    current: Assessment
    loads: Loads
    reached: Assessment
    idle: int = 0
    bent: bool = False
    back: Refusal | None = None


class BorneLoads:
    """The equilibrium under the loads of now, at the same motors.

    The way there is straight, from the last loads that were borne. Where these were a push that ends or
    becomes smaller, the branch may end on that way though it did not on the way here: sheets of
    equilibria lie above each other where the robot buckles, and pushes may lead around their border.
    But by the way it came, every step of it borne and the motors where they are, the robot can go back
    to before the first push without leaving its sheet. A real one may have snapped: that is told.
    """

    def __init__(self, robot: Robot) -> None:
        """Know nothing of any way.

        Args:
            robot: The robot.
        """
        self._robot, self._refused = robot, RefusedStep()
        self._way: _Way | None = None
        # Where the last loads were borne, and where the robot was before the first ones at these motors.
        self._last: Assessment | None = None
        self._before: Assessment | None = None
        self._snapped, self._until = Snapped("branch_jump", ""), -math.inf

    def at(
        self, current: Assessment, loads: Loads, now: float
    ) -> tuple[Assessment, Refusal | None]:
        """The equilibrium under the loads of now, and what a supervisor has to be told of it.

        Args:
            current: Current equilibrium, which it remains while other loads are not borne.
            loads: Loads that act now; the object of the equilibrium if they have not changed.
            now: Steady time [s].
        """
        borne, refusal = self._found(current, loads, now)
        if isinstance(refusal, Snapped):
            self._snapped, self._until = refusal, now + _TOLD
        elif refusal is None and now < self._until:
            refusal = self._snapped
        return borne, refusal

    def _found(
        self, current: Assessment, loads: Loads, now: float
    ) -> tuple[Assessment, Refusal | None]:
        """The same of this tick alone."""
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
        if isinstance(ahead, Refusal) and not isinstance(ahead, Undecided):
            back = self._way_back(way, ahead)
            if back is not None:
                way, ahead = back, _ahead(back, goal)
        if isinstance(ahead, Assessment):
            self._way = None
            self._keep(current, ahead)
            return ahead, None if way.back is None else _gone_back(way, way.back)
        if isinstance(ahead, Undecided):
            refusal = self._undecided(way, ahead)
            told = isinstance(refusal, Undecided)
        else:
            self._way, told = None, not way.bent  # without the bend it may be borne
            refusal = _refused(way, way.back or ahead)
        if told:
            self._refused.take(step, refusal, now, time.perf_counter() - begin)
        return current, refusal

    def _way_to(self, current: Assessment, loads: Loads) -> _Way:
        """The way on: the last one as long as it is not at its end, to other loads if these come."""
        way = self._way
        if way is not None and way.current is current:
            if way.loads is loads:
                return way
            if way.back is None and loads.differences(current.equilibrium.loads):
                return replace(way, loads=loads, bent=True)
        return _Way(current, loads, current)

    def _way_back(self, way: _Way, why: Refusal) -> _Way | None:
        """The way from before the first push, if a smaller one is refused on the straight one."""
        known = self._before if self._last is way.current else None
        if known is None or way.bent or way.back is not None or not _how_less(way):
            return None
        return _Way(way.current, way.loads, known, back=why)

    def _undecided(self, way: _Way, ahead: Undecided) -> Refusal:
        """What is told of a way that is not at its end; undecided if it is not to be asked for soon."""
        idle = way.idle + 1 if ahead.fraction < _NOWHERE else 0
        self._way = replace(way, reached=ahead.reached or way.reached, idle=idle)
        if idle >= _PATIENCE:
            return Undecided(ahead.reason, f"the external wrench is not borne: {ahead.text}")
        return Refusal(ahead.reason, f"the external wrench is not borne yet: {ahead.text}")

    def _keep(self, current: Assessment, ahead: Assessment) -> None:
        """Note what is borne: another push at the same motors, the first one, or none any more."""
        known = self._before if self._last is current else None
        if known is None:
            self._before = current
        elif not ahead.equilibrium.loads.differences(known.equilibrium.loads):
            self._before = ahead
        self._last = ahead


def _ahead(way: _Way, goal: MotorGoal) -> Assessment | Refusal:
    """Where a way ends, or why it does not, or not yet."""
    ahead = attempt(way.reached, goal, 1.0, way.loads)
    if isinstance(ahead, Assessment) and ahead.index > way.current.index:
        return Refusal("margin", "the robot buckles")
    return ahead


def _refused(way: _Way, why: Refusal) -> Refusal:
    """What is told of loads that are not borne."""
    less = _how_less(way)
    if less:
        return Refusal(why.reason, f"{_cannot_rest(less, why)}; {_WAY_OUT}")
    return Refusal(why.reason, f"the external wrench is not borne: {why.text}")


def _gone_back(way: _Way, why: Refusal) -> Snapped:
    """What is told where the robot is taken to be where it was before the push."""
    return Snapped("branch_jump", f"{_cannot_rest(_how_less(way), why)}; {_TAKEN}")


def _cannot_rest(less: str, why: Refusal) -> str:
    return (
        f"the robot cannot rest where the external wrench held it now that it is {less}: {why.text}"
    )


def _how_less(way: _Way) -> str:
    """Whether a push is ``gone`` or ``less`` at the end of a way; empty: neither."""
    robot = way.current.equilibrium.robot
    before, after = _wrenches(way.current.equilibrium.loads), _wrenches(way.loads)
    if np.array_equal(before, after):
        return ""
    if not after.any() or np.array_equal(after, _wrenches(robot.default_loads)):
        return "gone"
    arms = np.repeat([1.0, robot.mean_length], 3)
    return "less" if np.abs(arms * after).max() < np.abs(arms * before).max() else ""


def _wrenches(loads: Loads) -> NDArray[np.float64]:
    """Wrenches on the platform, fixed in space and turning with it, (2, 6) [N m, N]."""
    return np.array([loads.wrench_world, loads.wrench_body])
