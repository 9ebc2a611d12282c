# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Following setpoints without crossing an instability, a singularity or a limit. No ROS here.

What the robot is told to do, and what it does about it in a tick: bear the wrench that acts, go a step
towards the goal, or stay.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, Loads, Robot, solve_home
from cpr_core.model.assessment import Assessment

from .borne_loads import BorneLoads
from .goals import Goal, MotorGoal, MotorSetpoint, PoseGoal
from .judged_steps import JudgedSteps
from .motion_settings import ON_WAY_TO_MOTORS, ON_WAY_TO_POSES, Settings
from .outcome import Outcome
from .paced_steps import PacedSteps
from .steps import change_between
from .supervision import Action, Refusal, State, Verdict, verdict
from .trajectory_goal import TrajectoryGoal
from .watchdog import Watchdog

__all__ = ["ARRIVED", "OtherMotors", "SetpointFollower"]

Floats = NDArray[np.float64]

#: A goal nearer than this is reached [rad, rod lengths].
ARRIVED = 1e-9


class OtherMotors(NamedTuple):
    """What motors do that a setpoint does not name.

    Attributes:
        positions: Where they go or stay, (n,) [rad or m].
        since: Steady times at which these came, (n,) [s]; -inf: they stay.
        left: Names of those that stop on their way, as their setpoint is too old.
    """

    positions: Floats
    since: Floats
    left: tuple[str, ...]


class SetpointFollower:
    """State machine of setpoint following; docs/node.md draws it.

    Attributes:
        robot: The robot.
        period: Time of a tick [s].
        steps: Where ticks lead, solved and judged.
        pace: How far they go.
        borne_loads: Where the robot is under other loads.
        watchdog: Age of the newest setpoint.
        corrected: Where the robot is sent for a goal: there, or where it then is measured there.
        dropped: Why the last setpoint was forgotten that none replaced.
        forgotten: The same of one that nobody asked to forget; empty: there is none.
        orders: How many setpoints, pauses and returns have come, and how often one was forgotten: it
            tells that something newer has come, also if that is gone already.
    """

    def __init__(
        self,
        robot: Robot,
        period: float,
        settings: Settings,
        corrected: Callable[[Goal], Goal] = lambda goal: goal,
        part_in_reach: Callable[[Floats], float] = lambda motors: 1.0,
    ) -> None:
        """Start idle.

        Args:
            robot: The robot.
            period: Time of a tick [s].
            settings: What may change at any time.
            corrected: See the attribute.
            part_in_reach: As of :class:`PacedSteps`.
        """
        self.robot, self.period = robot, period
        self.steps = JudgedSteps(robot, period, settings)
        self.pace = PacedSteps(self.steps, part_in_reach)
        self.borne_loads = BorneLoads(robot)
        self.watchdog = Watchdog(settings.setpoint_timeout)
        self.corrected = corrected
        self.paused = False
        self.dropped = self.forgotten = ""
        self.orders = 0
        self._goal: Goal | None = None
        self._ages = True
        self._returning, self._under_way, self._stood, self._stirred = False, False, True, True
        self._action = Action.NONE
        self._burdened = False

    @property
    def settings(self) -> Settings:
        """What may change at any time."""
        return self.steps.settings

    @settings.setter
    def settings(self, settings: Settings) -> None:
        self.steps.settings, self._stirred = settings, True
        self.watchdog.timeout = settings.setpoint_timeout

    @property
    def goal(self) -> Goal | None:
        """Where the robot is sent; stays when it is reached."""
        return self._goal

    @property
    def returning(self) -> bool:
        """Whether the robot is on its way home and takes no setpoints."""
        return self._returning and self.pace.refusal is None and not self._burdened

    @property
    def moving(self) -> bool:
        """Whether there is a goal that is not known to be reached, and nothing holds the robot."""
        return self._under_way

    @property
    def at_rest(self) -> bool:
        """Whether another tick would change nothing, as long as the same loads act."""
        return not self._under_way and not self._stirred and not self._burdened

    def stale(self, now: float) -> bool:
        """Whether the setpoint is too old to be followed."""
        return self._ages and not self._returning and self.watchdog.stale(now)

    def other_motors(self, current: Floats, now: float) -> OtherMotors:
        """What motors do that a new setpoint does not name.

        They keep setpoints of their own that are not too old, and stay where they are without: where
        nothing asked for them, where a goal did that ends by this, or where their controller is gone.

        Args:
            current: Where the motors are, (n,) [rad or m].
            now: Steady time [s].
        """
        goal = self._goal
        if not isinstance(goal, MotorSetpoint) or self.stale(now):
            return OtherMotors(current, np.full(len(current), -np.inf), ())
        expired = goal.expired(self.watchdog.timeout, now)
        left = expired & (np.abs(goal.motors - current) > ARRIVED * self.robot.motor_units)
        return OtherMotors(
            np.where(expired, current, goal.motors),
            np.where(expired, -np.inf, goal.since),
            tuple(name for name, gone in zip(self.robot.motor_names, left, strict=True) if gone),
        )

    def arrived(self, current: Equilibrium) -> bool:
        """Whether an equilibrium is where the robot is sent."""
        return self._goal is None or self.corrected(self._goal).remaining(current) <= ARRIVED

    def follow(self, goal: Goal, now: float, *, ages: bool = True) -> None:
        """Take a new setpoint; the newest wins.

        Args:
            goal: Where to go.
            now: Steady time [s].
            ages: Whether it has to come again and again, or becomes stale.
        """
        self.orders += 1
        self._goal, self._ages, self.forgotten = goal, ages, ""
        self._returning, self._under_way, self._stirred = False, True, True
        self.watchdog.feed(now)

    def aim(self, current: Assessment, now: float) -> Floats | None:
        """Where the next tick takes the motors, (n,) [rad or m], if nothing slows them down.

        None: that is not known before it is solved, or they stay where they are.

        Args:
            current: Where the robot is.
            now: Steady time [s].
        """
        if self._goal is None or self.pace.reach < 1.0 or self.paused or self._returning:
            return None
        goal = self.corrected(self._goal)
        if self.stale(now) or goal.remaining(current.equilibrium) <= ARRIVED:
            return None
        return self.steps.aim(current, goal, self.pace.caution, out_of_rest=self._out_of_rest(goal))

    def lose(self, reason: str) -> None:
        """Forget the setpoint though nobody has asked for it; the log is told of one."""
        lost = self._goal is not None
        self.drop(reason)
        if lost:
            self.forgotten = reason

    def drop(self, reason: str = "") -> None:
        """Forget the setpoint and hold; the reason is for who sent it."""
        self.orders += 1
        self.dropped, self.forgotten = reason, ""
        self._goal, self._returning, self._under_way = None, False, False
        self._stirred = True
        self.pace.forget()
        self.watchdog.forget()

    def pause(self, paused: bool) -> None:
        """Hold, and forget the setpoint: nothing moves by itself when the pause ends."""
        if paused:
            self.drop("the node was paused")
        self.paused, self._stirred = paused, True

    def reset(self) -> None:
        """Walk home along the branch."""
        self.drop("~/reset: the robot goes home")
        self._goal = MotorGoal(self.robot, solve_home(self.robot).motors)
        self._returning, self._under_way = True, True

    def tick(self, current: Assessment, loads: Loads, now: float) -> Outcome:
        """Do one tick.

        Args:
            current: Current equilibrium.
            loads: Loads that act now; the object of the equilibrium if they have not changed.
            now: Steady time [s].
        """
        self._stirred = False
        borne, burden = self.borne_loads.at(current, loads, now)
        self._burdened = burden is not None
        goal = None if self._goal is None else self.corrected(self._goal)
        moved, home_missed = borne is not current, False
        state = State.PAUSED if self.paused else State.IDLE
        self._under_way, self.pace.waits, obeyed = False, False, False
        if goal is not None and not self.paused:
            at_goal = goal.remaining(borne.equilibrium) <= ARRIVED
            if at_goal and not (self._returning and burden):
                self.pace.refusal, obeyed = None, burden is None
                self._ages = self._ages and self.stale(now)  # in time: it is held from now on
                if self._returning:
                    home_missed = self._misses_home(borne.equilibrium)
                    self.drop("~/reset: the robot is at home")
            elif self.stale(now):
                state = State.STALE
                self.pace.refusal = None
            else:
                self._under_way = True
                ahead = borne
                if not burden:
                    first = self._out_of_rest(goal)
                    ahead = self.pace.step(borne, goal, self.watched, now, out_of_rest=first)
                waits = isinstance(goal, TrajectoryGoal) and goal.waits
                obeyed = ahead is not borne and not waits
                moved, borne = moved or ahead is not borne, ahead
                state = State.RETURNING if self._returning else State.FOLLOWING
                if burden or self.pace.refusal:
                    state = State.HALTED
        self._stood = not self._under_way
        refusal = burden or self.pace.refusal
        told = self.judge(borne, refusal, stale=state == State.STALE)
        return Outcome(borne, moved, state, told, home_missed, refusal, obeyed)

    def judge(
        self, current: Assessment, refusal: Refusal | None = None, *, stale: bool = False
    ) -> Verdict:
        """What a supervisor is told about an equilibrium now."""
        watched = self.watched
        told = verdict(
            current,
            self.settings.thresholds,
            watched,
            previous=self._action,
            hysteresis=self.settings.hysteresis,
            refusal=refusal,
            worsening=self.pace.worsening,
            stale=stale,
        )
        self._action = told.action
        return told

    @property
    def watched(self) -> tuple[str, ...]:
        """Measures that count now."""
        return ON_WAY_TO_POSES if isinstance(self._goal, PoseGoal) else ON_WAY_TO_MOTORS

    def _out_of_rest(self, goal: Goal) -> bool:
        """Whether a step towards this goal, corrected or not, is the first one towards the setpoint."""
        return self._stood and goal is self._goal

    def _misses_home(self, current: Equilibrium) -> bool:
        """Whether this is another equilibrium than home, though nothing else acts."""
        home = solve_home(self.robot)
        # By their numbers: after a wrench those of the description are other objects.
        same_loads = not current.loads.differences(home.loads)
        return same_loads and change_between(current, home) > 1e-6
