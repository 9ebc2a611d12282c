# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories: one is followed, one is being solved to replace it. No rclpy here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from cpr_msgs.msg import ErrorCode

from cpr_core import Robot
from cpr_core.errors import distinct
from cpr_core.model.assessment import Assessment

from .measured_motors import MeasuredMotors
from .motion_settings import ON_WAY_TO_MOTORS
from .motor_path import MotorPath
from .motor_ways import motor_steps
from .outcome import Outcome
from .setpoint_following import SetpointFollower
from .supervision import State
from .trajectory_goal import TrajectoryGoal
from .trajectory_motion import Ending, Joining, Motion
from .trajectory_order import TrajectoryOrder, TrajectoryRefused, ordered_path
from .trajectory_plan import TrajectoryPlan
from .trajectory_tolerances import TrajectoryTolerances

__all__ = ["Trajectories"]

#: Longest duration of a trajectory, waiting for its start included [s].
LONGEST = 600.0
#: If nothing moves, solving begins at once, and holds up the node for this time at most [s].
_FIRST_GO = 0.015
#: Part of every tick that solving takes later, while other things go on.
_SHARE = 0.5
#: Time it takes to solve a tick, until that is known [s].
_TICK_WORK = 1e-4
#: A trajectory is joined after this many times as long as solving it is expected to take.
_RESERVE = 1.5
#: How long before it is joined a trajectory with a stamp takes the place of an older one [ticks]:
#: more than the older one goes on in a tick, so that no tick passes the moment by.
_BEFORE_JOINED = 3.0


class Trajectories:
    """Begins and ends trajectories; in between the follower follows them like any goal.

    Attributes:
        running: The one that is followed.
        coming: One that is being solved.
    """

    def __init__(
        self, robot: Robot, follower: SetpointFollower, period: float, measured: MeasuredMotors
    ) -> None:
        """Follow none yet; their tolerances count of measured motors too, where there are any."""
        self._robot, self._follower, self._period = robot, follower, period
        self._measured = measured
        self.running: Motion | None = None
        self.coming: Motion | None = None
        self._tick_work = _TICK_WORK

    @property
    def at_rest(self) -> bool:
        """Whether none is followed and none is being solved."""
        return self.running is None and self.coming is None

    def take(
        self,
        order: TrajectoryOrder,
        current: Assessment,
        now: float,
        on_end: Callable[[Ending], None],
    ) -> Motion:
        """Take an order. A setpoint is forgotten; a trajectory goes on until this one is solved.

        Args:
            order: The order, with points.
            current: Where the robot is.
            now: Steady time [s].
            on_end: Called with its end, once, perhaps before this returns; must not raise.

        Raises:
            TrajectoryRefused: It cannot be followed from here; what is followed goes on.
        """
        left = order.duration + (order.start_in or 0.0)
        if left > LONGEST:
            longest, asked = distinct(LONGEST, left, fewest=6)
            text = f"expected an end within {longest} s from now, got {asked} s"
            raise TrajectoryRefused(order.duration, "points", text)
        self._notice_newer()  # first: it goes on from nothing that has been replaced
        joining = self._joining(order, current, now, self._tick_work / _SHARE)
        if self.coming is not None:
            self._end_coming(_replaced())
        if self.running is None:
            self._follower.drop("a trajectory came")
            joining.plan.advance(_FIRST_GO)
        stamp = None if order.start_in is None else now + order.start_in
        motion = Motion(order, joining, on_end, self._follower.orders, now, stamp)
        self.coming = motion
        self._begin_if_solved(current, now)
        return motion

    def cancel(self, motion: Motion) -> None:
        """End one; the robot holds."""
        cancelled = Ending(ErrorCode.PREEMPTED, "the trajectory was cancelled", motion.time)
        if motion is self.coming:
            self._end_coming(cancelled)
        elif motion is self.running:
            self._end_running(cancelled)

    def stop(self, val: int, reason: str) -> None:
        """End all; the robot holds."""
        if self.coming is not None:
            self._end_coming(Ending(val, reason))
        if self.running is not None:
            self._end_running(Ending(val, reason, self.running.time))

    def before_tick(self, current: Assessment, now: float) -> None:
        """Go on solving, and begin what is solved."""
        self._notice_newer()
        if self.coming is not None and self.coming.cut_off:
            why = "the trajectory it was to go on from has ended"
            self._solve_anew(self.coming, current, now, self._tick_work / _SHARE, why)
        if self.coming is not None:
            self.coming.joining.plan.advance(_SHARE * self._period)
            self._put_off_if_late(current, now)
            self._begin_if_solved(current, now)
        if self.running is not None and self.running.goal is not None:
            self.running.goal.elapse(now)
            self._follower.watchdog.feed(now)

    def after_tick(self, outcome: Outcome, now: float) -> None:
        """End what has come to its end."""
        motion = self.running
        if motion is None or motion.goal is None or self._follower.goal is not motion.goal:
            return
        goal, order, refusal = motion.goal, motion.order, outcome.refusal
        if outcome.state == State.HALTED and refusal is not None:
            text = f"halted at {goal.time:.3f} s: {refusal.text}"
            self._end_running(Ending(ErrorCode.CONTROL_FAILED, text, goal.time, refusal.reason))
            return
        due = goal.due(now)
        current, names = outcome.assessment.equilibrium, self._robot.motor_names
        tolerances = TrajectoryTolerances(names, order, goal.path, self._period)
        seen = self._measured.seen(now)
        if goal.remaining(current) == 0.0 and tolerances.arrived(seen):
            self.running = None
            self._rest_until_joined()
            motion.on_end(Ending(ErrorCode.SUCCESS, "", due))
            return
        broken = tolerances.broken(due, current.motors, seen)
        if broken is not None:
            self._end_running(Ending(ErrorCode.CONTROL_FAILED, broken.text, due, broken.name))

    def _joining(
        self, order: TrajectoryOrder, current: Assessment, now: float, pace: float
    ) -> Joining:
        """What is to be solved for an order.

        Args:
            order: The order, with points.
            current: Where the robot is.
            now: Steady time [s].
            pace: Time it takes to solve a tick, while other things go on [s].

        Raises:
            TrajectoryRefused: It cannot be followed from here.
        """
        before, own_time = self._until_joined(order, current, now, pace)
        settings = self._follower.settings
        try:
            path = ordered_path(self._robot, order, before, settings.max_speed)
        except TrajectoryRefused as refused:
            doubt = order.doubt(self._robot, current.equilibrium.motors)
            raise refused.doubted(doubt) from None
        plan = TrajectoryPlan(path, current, self._period, settings.thresholds, ON_WAY_TO_MOTORS)
        return Joining(plan, own_time, before.end)

    def _put_off_if_late(self, current: Assessment, now: float) -> None:
        """Solve one anew that is not solved when it is due, to be joined later: no tick waits for it."""
        coming = self.coming
        if coming is None or coming.joining.plan.refused is not None:
            return
        if self.running is None and coming.stamp is None:
            return
        joining = coming.joining
        ticks_needed = 0.0 if joining.plan.done else 2.0
        if joining.own_time(now) <= joining.join - ticks_needed * self._period:
            return
        pace = (now - coming.since) / max(1, joining.plan.begun)
        self._solve_anew(coming, current, now, pace, "it was not solved when it was due")

    def _solve_anew(
        self, coming: Motion, current: Assessment, now: float, pace: float, why: str
    ) -> None:
        """Begin to solve it again, from what the robot does now; it ends where that cannot be joined."""
        if coming.stamp is not None:
            coming.order = replace(coming.order, start_in=coming.stamp - now)
        try:
            coming.joining = self._joining(coming.order, current, now, pace)
        except TrajectoryRefused as refused:
            text = f"{why}: {refused}"
            self._end_coming(Ending(refused.val, text, refused.time, refused.measure))
            return
        coming.since, coming.cut_off = now, False

    def _until_joined(
        self, order: TrajectoryOrder, current: Assessment, now: float, pace: float
    ) -> tuple[MotorPath, Callable[[float], float]]:
        """What the motors do until an order can be solved, in its own time; and that time."""
        running = None if self.running is None else self.running.goal
        motors = current.equilibrium.motors
        if running is None and order.start_in is None:
            return MotorPath.rest(0.0, 0.0, motors), lambda _: 0.0
        ticks = order.duration / self._period
        lead = 3.0 * self._period + _RESERVE * ticks * pace
        own = -lead if order.start_in is None else -order.start_in
        join = max(0.0, own + lead)
        if running is None:
            return MotorPath.rest(own, join, motors), lambda later: own + later - now
        # Its time is that of the last tick, since which it has gone on.
        goal, since = running, min(now - running.last_tick, self._period)
        begin = min(running.time + since, running.path.end)
        before = goal.path.part(begin, begin + join - own, own)
        return before, lambda _: own + goal.time - begin

    def _rest_until_joined(self) -> None:
        """Let the time of one with a stamp go on, though what it goes on from has ended."""
        coming = self.coming
        if coming is not None and coming.stamp is not None:
            stamp = coming.stamp  # from now on nothing delays it: what has ended may have been late
            coming.joining = replace(coming.joining, own_time=lambda later: later - stamp)

    def _notice_newer(self) -> None:
        """End what a setpoint, a pause or a return has replaced."""
        newer = "a setpoint, a pause or a return came"
        running = self.running
        if running is not None and self._follower.goal is not running.goal:
            self.running = None
            running.on_end(Ending(ErrorCode.PREEMPTED, newer, running.time))
        coming = self.coming
        if coming is not None and self._follower.orders != coming.after:
            self._end_coming(Ending(ErrorCode.PREEMPTED, f"{newer} before it began"))

    def _begin_if_solved(self, current: Assessment, now: float) -> None:
        coming = self.coming
        if coming is None:
            return
        plan = coming.joining.plan
        if plan.refused is not None:
            doubt = coming.order.doubt(self._robot, current.equilibrium.motors)
            refused = plan.refused.doubted(doubt)
            self._end_coming(Ending(refused.val, str(refused), refused.time, refused.measure))
        elif plan.done and not self._waits(coming, now):
            self._tick_work = 0.5 * (self._tick_work + plan.work / plan.ticks)
            self._begin(coming, current, now)

    def _waits(self, coming: Motion, now: float) -> bool:
        """Whether one with a stamp, solved already, lets the older one go on."""
        older = None if self.running is None else self.running.goal
        if older is None or coming.stamp is None:
            return False
        own, join = coming.joining.own_time(now), coming.joining.join
        ends = own + older.path.end - older.time
        return ends <= join or own < join - _BEFORE_JOINED * self._period

    def _begin(self, coming: Motion, current: Assessment, now: float) -> None:
        path, own = coming.joining.plan.path, coming.joining.own_time(now)
        before = None if self.running is None else self.running.goal
        way = np.abs(path.at(own).positions - current.equilibrium.motors)
        if np.any(way > motor_steps(self._robot, self._follower.settings.max_speed, self._period)):
            text = "the robot was moved while the trajectory was solved"
            self._end_coming(Ending(ErrorCode.PREEMPTED, text))
            return
        last_tick, rests_until = (
            (now, coming.joining.join) if before is None else (before.last_tick, own)
        )
        # One with a stamp is late where the older one was: its tolerances count that.
        coming.goal = TrajectoryGoal(
            path,
            own,
            self._period,
            last_tick,
            rests_until=rests_until,
            began=coming.stamp,
        )
        self._follower.follow(coming.goal, now, ages=False)  # all of it has come already
        replaced, self.running, self.coming = self.running, coming, None
        if replaced is not None:
            replaced.on_end(_replaced(replaced.time))

    def _end_coming(self, ending: Ending) -> None:
        motion, self.coming = self.coming, None
        if motion is not None:
            motion.on_end(ending)

    def _end_running(self, ending: Ending) -> None:
        motion, self.running = self.running, None
        if motion is None:
            return
        try:
            # Else something newer has come since the last tick.
            if self._follower.goal is motion.goal:
                self._follower.drop(ending.message)
                if self.coming is not None:
                    self.coming.after, self.coming.cut_off = self._follower.orders, True
        finally:  # nobody else will tell
            motion.on_end(ending)


def _replaced(time: float = 0.0) -> Ending:
    """The end of one that another took the place of, at its time [s]."""
    return Ending(ErrorCode.PREEMPTED, "a newer trajectory came", time, replaced=True)
