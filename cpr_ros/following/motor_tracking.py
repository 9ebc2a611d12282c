# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Following measured motors: the node watches a robot that somebody else drives. No ROS here."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpr_core import Loads, Robot
from cpr_core.model.assessment import Assessment

from .goals import MotorGoal, whole
from .judged_steps import LARGEST_CHANGE
from .measured_range import within_range
from .outcome import Outcome
from .refused_step import RefusedStep, Step
from .setpoint_following import ARRIVED, SetpointFollower
from .steps import LONGEST_SOLVE, Undecided, attempt, change_between
from .supervision import Refusal, State
from .two_places import TwoPlaces, apart_in_words
from .watchdog import Watchdog

__all__ = ["MotorTracking"]

Floats = NDArray[np.float64]

#: Longest way of a motor in one step [rad, rod lengths]: stability is looked at after each.
LONGEST_WAY = 0.1
#: A tick takes a step for each such time of its period [s], and at least one: motors are kept up with
#: however seldom ticks come.
_STEP_TIME = 0.005
#: Part of a period that these steps may take: streams wait for them.
_SHARE = 0.5
#: Parts of that way that are tried one after the other: where the robot is soft, smaller steps help.
_PARTS = (1.0, 0.25, 0.0625)


class MotorTracking:
    """Keeps the equilibrium at the measured motors.

    Nothing is refused for its margin: the motors are where they are. What the branch of the last
    equilibrium does not explain (a buckled robot, an effort beyond a limit) is lost, until the
    motors come back.

    Attributes:
        watchdog: Age of the newest measurement.
        at_rest: Whether there is nothing to follow until measured motors come.
    """

    def __init__(self, robot: Robot, timeout: float, judge: SetpointFollower) -> None:
        """Track nothing yet.

        Args:
            robot: The robot.
            timeout: Age beyond which measured motors are stale [s]; 0: never.
            judge: Whose thresholds and hysteresis decide what a supervisor is told.
        """
        self.robot, self.watchdog = robot, Watchdog(timeout)
        self._judge = judge
        self._goal: MotorGoal | None = None
        self._taken = -math.inf
        self._told: tuple[float, Floats] | None = None
        self._velocity = np.zeros(robot.motor_count)
        self._beyond = ""
        self._places, self._apart = TwoPlaces(robot), 0.0
        self._refused = RefusedStep()
        self.at_rest = False

    def take(self, motors: ArrayLike, now: float, tolerance: float = 0.0) -> None:
        """Take measured motors; the newest count.

        Args:
            motors: (n,) [rad or m].
            now: Steady time [s].
            tolerance: Motors that are measured there and back by more are in two places, if they would
                also be twice as fast as they may be [rad, rod lengths]; 0: never.
        """
        within, self._beyond = within_range(self.robot, motors)
        goal = MotorGoal(self.robot, within)
        self._apart = 0.0
        if tolerance > 0.0:
            possible = 2.0 * self._judge.settings.max_speed * (now - self._taken)
            self._apart = self._places.take(goal.motors, None, max(tolerance, possible), now)
        self._goal, self._taken = goal, now
        self.watchdog.feed(now)
        self.at_rest = False

    def forget(self) -> None:
        """Be as if no measured motors had ever come."""
        self._goal, self.at_rest = None, False
        self._places, self._apart = TwoPlaces(self.robot), 0.0
        self.watchdog.forget()

    def velocity(self, period: float) -> Floats:
        """How fast the motors were between their last measurements, (n,) [rad/s or m/s].

        Of those that come more often than ticks, between the newest of each; 0 where they are stale.

        Args:
            period: Of ticks [s].
        """
        if self.at_rest or self._goal is None:
            self._told, self._velocity = None, np.zeros(self.robot.motor_count)
        elif self._told is None:
            self._told = self._taken, self._goal.motors
        elif self._taken > self._told[0]:
            since, before = self._told
            self._velocity = (self._goal.motors - before) / max(period, self._taken - since)
            self._told = self._taken, self._goal.motors
        return self._velocity

    def tick(self, current: Assessment, loads: Loads, now: float) -> Outcome:
        """Follow the motors; parameters as in :meth:`SetpointFollower.tick`."""
        self.at_rest = self._goal is None or self.watchdog.stale(now)
        if self._goal is None:
            unknown = Refusal("stale", "no measured motors have come yet")
            return Outcome(current, False, State.IDLE, self._judge.judge(current, unknown))
        if self.at_rest:
            unknown = Refusal("stale", "the measured motors are too old to tell where the robot is")
            return Outcome(current, False, State.STALE, self._judge.judge(current, unknown))
        goal = self._goal
        if self._apart > 0.0:
            refusal = Refusal("stale", apart_in_words(self._apart))
            return Outcome(current, False, State.LOST, self._judge.judge(current, refusal))
        if self._beyond:
            refusal = Refusal("motor_range", self._beyond)
            return Outcome(current, False, State.LOST, self._judge.judge(current, refusal))
        reached, lost = self._walked(current, goal, loads, now)
        state = State.TRACKING if lost is None else State.LOST
        told = self._judge.judge(reached, lost)
        return Outcome(reached, reached is not current, state, told)

    def _walked(
        self, current: Assessment, goal: MotorGoal, loads: Loads, now: float
    ) -> tuple[Assessment, Refusal | None]:
        """How far a tick comes towards the measured motors, and what ends it before; None: nothing."""
        period = self._judge.period
        end = time.perf_counter() + min(_SHARE * period, LONGEST_SOLVE)
        for number in range(max(1, int(period / _STEP_TIME))):
            remaining = goal.remaining(current.equilibrium)
            arrived = remaining <= ARRIVED and loads is current.equilibrium.loads
            if arrived or (number and time.perf_counter() >= end):
                break
            ahead = self._step(current, goal, remaining, loads, now)
            if isinstance(ahead, Refusal):
                return current, ahead
            current = ahead
        return current, None

    def _step(
        self, current: Assessment, goal: MotorGoal, remaining: float, loads: Loads, now: float
    ) -> Assessment | Refusal:
        """A step towards the measured motors, or why there is none; the same is not tried twice."""
        step = Step(current, loads, goal.destination)
        refusal = self._refused.again(step, now)
        if refusal is not None:
            return refusal
        fraction, refusals = whole(LONGEST_WAY / max(remaining, ARRIVED)), list[Refusal]()
        for part in _PARTS:
            ahead = attempt(current, goal, part * fraction, loads, LONGEST_SOLVE / len(_PARTS))
            refusal = ahead if isinstance(ahead, Refusal) else self._contradiction(current, ahead)
            if refusal is None:
                return ahead
            refusals.append(refusal)
        if not any(isinstance(refusal, Undecided) for refusal in refusals):
            self._refused.take(step, refusals[-1], now)
        return refusals[-1]

    def _contradiction(self, current: Assessment, ahead: Assessment) -> Refusal | None:
        """Why a step cannot be what the robot did, if so."""
        if change_between(current.equilibrium, ahead.equilibrium) > LARGEST_CHANGE:
            return Refusal("branch_jump", "the measured motors jump off the branch")
        if ahead.index > current.index:
            return Refusal("margin", "no stable equilibrium is at the measured motors")
        return None
