# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot in operation is asked to do: taken, refused, or ended before its time. No rclpy here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from cpr_msgs.msg import ErrorCode

from cpr_core import solve_home
from cpr_core.model.assessment import Assessment

from ..closed_loop.jogging import Jogger, PlatformTwist
from ..closed_loop.pose_loop import PoseLoop
from ..error_codes import RequestError
from ..following.goals import Goal, MotorGoal, PoseGoal
from ..following.setpoint_following import SetpointFollower
from ..following.supervision import State
from ..following.trajectory_following import Trajectories
from ..following.trajectory_motion import Ending, Motion
from ..following.trajectory_order import TrajectoryOrder
from .outgoing import Outgoing
from .present import Present
from .solver import Solver

__all__ = ["Orders"]


@dataclass
class Orders:
    """Takes setpoints, trajectories, twists, pauses and returns, and ends them.

    Attributes:
        solver: Where the robot is.
        present: What it does.
        follower: Follows setpoints.
        trajectories: Timed trajectories, which it follows too.
        jogger: Platform setpoint moved by twists.
        loop: Correction of platform setpoints.
        outgoing: What leaves for the motors.
        left_behind: Why the last goal was forgotten, if its motors did not follow or others moved them.
    """

    solver: Solver
    present: Present
    follower: SetpointFollower
    trajectories: Trajectories
    jogger: Jogger
    loop: PoseLoop
    outgoing: Outgoing
    left_behind: str = field(default="", init=False)
    _awaited: Goal | None = field(default=None, init=False)

    def follow(self, goal: MotorGoal | PoseGoal, now: float, *, ages: bool = True) -> None:
        """Take a setpoint; arguments as in :meth:`SetpointFollower.follow`.

        Raises:
            RequestError: The node takes none now, or its numbers look like another unit.
        """
        self._check_free()
        doubt = goal.doubt(self.solver.current.equilibrium, self.follower.goal)
        if doubt:  # the robot would go as far as it can
            raise RequestError(ErrorCode.INVALID_ROBOT_STATE, doubt)
        self.follower.follow(goal, now, ages=ages)

    def follow_trajectory(
        self, order: TrajectoryOrder, now: float, on_end: Callable[[Ending], None]
    ) -> Motion | None:
        """Take a timed trajectory; one without points is always a stop, and there is none then.

        Args:
            order: The trajectory.
            now: Steady time [s].
            on_end: Called with its end, once, perhaps before this returns; must not raise.

        Raises:
            RequestError: The node takes none now, or it cannot be followed.
        """
        if not len(order.times):
            self._check_moving()
            reason = "an empty trajectory came: hold"
            self.trajectories.stop(ErrorCode.PREEMPTED, reason)
            self.drop(reason)
            on_end(Ending(ErrorCode.SUCCESS))
            return None
        self._check_free()
        if not self.outgoing.aligned:
            raise RequestError(
                ErrorCode.NOT_READY, "the motor commands are on their way to where the robot is"
            )
        return self.trajectories.take(order, self.solver.current, now, on_end)

    def jog(self, twist: PlatformTwist, now: float) -> None:
        """Take a twist: it moves the platform setpoint from where the robot is.

        A twist of zero does not end what others do.

        Raises:
            RequestError: The node takes none now.
            InvalidRequest: A turn that the angles the robot controls do not tell.
        """
        self.jogger.check_told(twist, self.solver.current.equilibrium)
        if not self.jogger.drives(self.follower.goal):
            if twist.rests:
                return
            self.follow(self.jogger.begin(self.solver.current.equilibrium, now), now)
        self.follower.watchdog.feed(now)
        self.jogger.take(twist, now)

    def pause(self, paused: bool) -> str:
        """Pause or release; says what was done.

        Raises:
            RequestError: There is nothing to pause.
        """
        if self.outgoing.tracking is not None:
            raise RequestError(
                ErrorCode.NOT_READY, "the node tracks measured motors, it moves none"
            )
        self.follower.pause(paused)
        if paused:
            self.outgoing.commands.waits = False  # they are held, for nobody
            self.present.be(State.PAUSED)
        elif self.present.outcome.state == State.PAUSED:
            self.present.rest()
        if paused:
            held = self.outgoing.held_on_the_way
            return "paused, the setpoint is forgotten" + (f"; {held}" if held else "")
        way = self.outgoing.on_the_way
        if way:
            speed = self.follower.settings.max_speed
            return f"commands go on, at {speed:g} rad/s or rod lengths/s at most: {way}"
        return "waiting for a setpoint"

    def reset(self) -> str:
        """Go home; says what was done.

        Raises:
            RequestError: The node is paused, or others have moved the motors.
        """
        if self.outgoing.tracking is not None:
            length = self.solver.current.characteristic_length
            self.solver.current = Assessment(solve_home(self.solver.robot), length)
            return "tracking from home again"
        if self.follower.paused:
            raise RequestError(ErrorCode.NOT_READY, "the node is paused: release it first")
        self._check_where_commanded()
        self.follower.reset()
        self.loop.forget()
        self.present.be(State.RETURNING)
        return "walking home along the branch; the stability stream says when it is there"

    def await_end(self, goal: Goal) -> None:
        """Somebody waits to hear how a goal ends, which ticks tell."""
        self._awaited = goal

    def answered(self, goal: Goal) -> None:
        """Who waited for a goal has heard how it ended."""
        if self._awaited is goal:
            self._awaited = None

    @property
    def awaiting(self) -> bool:
        """Whether somebody waits to hear how the goal of now ends."""
        return self._awaited is not None and self._awaited is self.follower.goal

    def drop(self, reason: str = "") -> None:
        """Forget the setpoint and hold; the reason is for who sent it."""
        self.follower.drop(reason)
        self.hold_commands()  # nothing else does

    def lose(self, reason: str) -> None:
        """The same though nobody has asked for it: the log is told."""
        self.follower.lose(reason)
        self.hold_commands()

    def hold_commands(self) -> bool:
        """Pause where commands are on their way to where the node has the robot; whether they were."""
        if self.outgoing.aligned:
            return False
        self.pause(True)
        return True

    def end(self, code: int, reason: str) -> bool:
        """Forget where the robot was to go, whoever sent it there.

        Args:
            code: Number of cpr_msgs/ErrorCode, for who sent a trajectory.
            reason: Why.

        Returns:
            Whether that was a setpoint; who sent a trajectory is told by it.
        """
        self.trajectories.stop(code, reason)
        if self.follower.goal is None:
            return False
        self.follower.lose(reason)
        return True

    def end_if_stopped(self) -> None:
        """Forget where the robot was to go, if others have moved it or it may not go on."""
        stopped = self.outgoing.stopped
        if stopped and self.end(ErrorCode.CONTROL_FAILED, stopped):
            self.left_behind = stopped

    def end_if_not_seen(self, now: float) -> None:
        """Forget where the robot was to go, if commands wait for motors that are measured no more."""
        measured = self.outgoing.measured
        missing = measured.missing(now, with_age=False) or measured.silent(now)
        if not self.outgoing.waits or not missing:
            return
        self.left_behind = (
            f"{self.outgoing.lag()}, and {missing}; with max_lead 0 they go on unseen"
        )
        self.trajectories.stop(ErrorCode.CONTROL_FAILED, self.left_behind)
        self.lose(self.left_behind)

    def _check_free(self) -> None:
        """Whether setpoints and trajectories are taken now.

        Raises:
            RequestError: They are not.
        """
        self._check_moving()
        if self.follower.paused:
            raise RequestError(ErrorCode.NOT_READY, "the node is paused")
        if self.follower.returning:
            raise RequestError(ErrorCode.NOT_READY, "the node is on its way home")
        self._check_where_commanded()

    def _check_moving(self) -> None:
        """Whether it is the node that moves the motors.

        Raises:
            RequestError: It is not.
        """
        if self.outgoing.tracking is not None:
            raise RequestError(
                ErrorCode.NOT_READY, "the node tracks measured motors and takes no setpoints"
            )

    def _check_where_commanded(self) -> None:
        """Whether the motors are where the node has sent them, and may be sent on.

        Raises:
            RequestError: They are not.
        """
        if self.outgoing.in_question:
            raise RequestError(ErrorCode.NOT_READY, self.outgoing.in_question)
