# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Steps of a robot, solved and judged before they are taken. No ROS here."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, Robot
from cpr_core.errors import distinct
from cpr_core.model.assessment import Assessment

from .goals import Goal, MotorGoal, PoseGoal, whole
from .motion_settings import Settings
from .motor_ways import largest_way, motor_steps
from .pose_steps import PoseSteps, TickWay
from .refused_step import RefusedStep, Step
from .steps import Undecided, attempt, change_between, falls
from .supervision import FIELDS, Refusal
from .trajectory_goal import TrajectoryGoal

__all__ = ["LARGEST_CHANGE", "JudgedSteps"]

Floats = NDArray[np.float64]

#: Largest change in one step of a leg coordinate (in 1/rod length) and of the platform (in radians and
#: rod lengths). A continuous branch changes less if the step is small enough, a jump does not.
LARGEST_CHANGE = 0.5


class JudgedSteps:
    """Where a tick leads towards a goal, or why the robot must not go there.

    Attributes:
        robot: The robot.
        settings: Thresholds and speed that count.
    """

    def __init__(self, robot: Robot, period: float, settings: Settings) -> None:
        """Know nothing of any way.

        Args:
            robot: The robot.
            period: Time of a tick [s].
            settings: Thresholds and speed that count.
        """
        self.robot, self._period = robot, period
        self._pose_steps, self._refused = PoseSteps(robot), RefusedStep()
        self.settings = settings

    @property
    def settings(self) -> Settings:
        """Thresholds and speed that count."""
        return self._settings

    @settings.setter
    def settings(self, settings: Settings) -> None:
        self._settings = settings
        self._motor_steps = motor_steps(self.robot, settings.max_speed, self._period)
        self._tick_way = TickWay(self._motor_steps.tolist(), settings.max_speed * self._period)

    def ticks_between(self, first: Floats, last: Floats) -> float:
        """Ticks at full speed the motors need from one place to another, (n,) each."""
        return largest_way(first, last, self._tick_way.motors)

    def aim(
        self, current: Assessment, goal: Goal, factor: float, *, out_of_rest: bool
    ) -> Floats | None:
        """Where a step takes the motors, (n,) [rad or m]; None: that has to be solved first.

        Args:
            current: Where the robot is.
            goal: Where it is to go.
            factor: Part of their speed that motors and platform may have.
            out_of_rest: Whether the robot stood, and the goal is not corrected from tick to tick: then
                every tick is to end exactly there.
        """
        if isinstance(goal, MotorGoal):
            start = current.equilibrium
            return goal.at(start, self._part_of_way(start, goal, factor))
        if isinstance(goal, PoseGoal) and out_of_rest and not goal.driven:
            return self._pose_steps.first(current, goal, factor, self._tick_way)
        return None

    def towards(
        self,
        current: Assessment,
        goal: Goal,
        factor: float,
        watched: tuple[str, ...],
        now: float,
        *,
        out_of_rest: bool,
    ) -> Assessment | Refusal:
        """Where a step leads, or why it is not taken.

        Args:
            current: Where the robot is.
            goal: Where it is to go.
            factor: Part of their speed that motors and platform may have.
            watched: Measures that count.
            now: Steady time [s].
            out_of_rest: See :meth:`aim`.
        """
        loads = current.equilibrium.loads
        step = Step(current, loads, goal.destination, factor, self.settings, watched)
        refusal = self._refused.again(step, now)
        if refusal is None:
            begin = time.perf_counter()
            ahead = self._solved(current, goal, factor, out_of_rest)
            refusal = (
                ahead if isinstance(ahead, Refusal) else self._crossing(current, ahead, watched)
            )
            if refusal is None:
                return ahead
            self._refused.take(step, refusal, now, time.perf_counter() - begin)
        return refusal

    def _solved(
        self, current: Assessment, goal: Goal, factor: float, out_of_rest: bool
    ) -> Assessment | Refusal:
        """Where the robot is after a tick at a fraction of its speed."""
        start = current.equilibrium
        if isinstance(goal, TrajectoryGoal):
            return attempt(current, goal.aim(start, factor, self._motor_steps), 1.0, start.loads)
        if isinstance(goal, MotorGoal):
            return attempt(current, goal, self._part_of_way(start, goal, factor), start.loads)
        assert isinstance(goal, PoseGoal)
        aim = self.aim(current, goal, factor, out_of_rest=out_of_rest)
        if aim is not None:
            return self._pose_steps.first_step(current, goal, aim, self._tick_way)
        return self._pose_steps.step(current, goal, factor, self._tick_way)

    def _part_of_way(self, start: Equilibrium, goal: MotorGoal, factor: float) -> float:
        """Part of the way to motors that a tick takes at a fraction of their speed."""
        return whole(factor / self.ticks_between(start.motors, goal.motors))

    def _crossing(
        self, current: Assessment, ahead: Assessment, watched: Iterable[str]
    ) -> Refusal | None:
        """Why the robot must not go there, if so; a measure that cannot be had is a reason."""
        try:
            return self._danger(current, ahead, watched)
        except Exception as error:
            text = f"no measures ahead: {type(error).__name__}: {error}"
            return Undecided("not_converged", text)

    def _danger(
        self, current: Assessment, ahead: Assessment, watched: Iterable[str]
    ) -> Refusal | None:
        if change_between(current.equilibrium, ahead.equilibrium) > LARGEST_CHANGE:
            return Refusal("branch_jump", "the next equilibrium is not near this one")
        if ahead.index > 0:  # also where it begins unstable, as a home may be: no robot is there
            return Refusal("margin", "the next equilibrium is unstable with the motors held")
        for name in watched:
            first, last = current.value(name), ahead.value(name)
            stop = self.settings.thresholds[name].stop
            if math.isnan(last):
                return Refusal(name, f"the next {FIELDS[name]} is not defined")
            if last < stop and falls(first, last):
                after, limit, before = distinct(last, stop, first)
                return Refusal(
                    name,
                    f"the next {FIELDS[name]}, {after}, is below {name}_stop {limit}; "
                    f"here it is {before}",
                )
        return None
