# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories from others: actions that say how they end."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from typing import Any

from cpr_msgs.action import FollowTrajectory
from cpr_msgs.msg import ErrorCode
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from ..error_codes import active, error_code
from ..following.motor_path import MotorMotion
from ..following.trajectory_motion import Ending, Motion
from ..following.trajectory_order import TrajectoryRefused
from ..messages.frames import Frames
from ..messages.trajectory_messages import AllowedErrors, trajectory_order
from ..messages.trajectory_points import FeedbackPoints, point_message, seconds_of
from ..middleware.long_action import LongAction
from ..operation.session import Session
from ..process.once_a_second import ONCE_A_SECOND
from .joint_trajectory_action import FollowJointTrajectoryDialect
from .reached import reached

__all__ = ["TrajectoryAction", "trajectory_actions"]

#: Rate of feedback [Hz].
_RATE = 20.0


class _FollowTrajectoryDialect:
    """Goals, feedback and results of ``cpr_msgs/action/FollowTrajectory``."""

    kind, name = FollowTrajectory, "~/follow_trajectory"

    def __init__(self, frames: Frames) -> None:
        """Give poses in these frames."""
        self._frames = frames

    def allowed(self, goal: Any) -> AllowedErrors:
        """What a goal allows."""
        time = seconds_of(goal.goal_time_tolerance)
        return AllowedErrors(goal.path_tolerance, goal.goal_tolerance, time)

    def feedback(self, session: Session, goal: Any, header: Any, points: FeedbackPoints) -> Any:
        """How a trajectory goes on."""
        return FollowTrajectory.Feedback(
            header=header,
            time=seconds_of(points.desired.time_from_start),
            **points._asdict(),
            margin=session.present.outcome.assessment.margin,
            action=int(session.verdict(time.monotonic()).action),
        )

    def result(self, ending: Ending, node: Node, session: Session | None) -> Any:
        """How a trajectory ended, and where the robot is."""
        return FollowTrajectory.Result(
            error_code=ErrorCode(val=ending.val, message=ending.message),
            time=ending.time,
            measure=ending.measure,
            reached=reached(node, session, self._frames),
        )


class TrajectoryAction(LongAction):
    """An action that follows trajectories; the newest counts."""

    def __init__(self, node: Node, session: Callable[[], Session | None], dialect: Any) -> None:
        """Offer the action.

        Args:
            node: The node.
            session: Gives the robot in operation; None while the node is not active.
            dialect: Its messages.
        """
        super().__init__(node, dialect.kind, dialect.name)
        self._session, self._dialect = session, dialect
        self._motions: dict[bytes, tuple[ServerGoalHandle, Motion]] = {}
        self._timer: Any = None

    def _begin(self, handle: ServerGoalHandle) -> None:
        ended = False

        def on_end(ending: Ending) -> None:
            nonlocal ended
            ended = True
            self._motions.pop(_key(handle), None)
            self._end(handle, ending)

        session, goal = active(self._session()), handle.request
        now = self._node.get_clock().now().to_msg()
        order = trajectory_order(session.robot, goal.trajectory, now, self._dialect.allowed(goal))
        motion = session.orders.follow_trajectory(order, time.monotonic(), on_end)
        if motion is not None and not ended:
            self._motions[_key(handle)] = handle, motion
            self._report(True)

    def _refuse(self, handle: ServerGoalHandle, error: Exception) -> None:
        self._end(handle, _ending_of(error))

    def _cancel(self, handle: ServerGoalHandle) -> bool:
        known, session = self._motions.get(_key(handle)), self._session()
        if known is None or session is None:
            return False
        session.trajectories.cancel(known[1])  # the result follows when rclpy has taken note
        return True

    def _report(self, wanted: bool) -> None:
        """Give feedback, or give none."""
        if wanted and self._timer is None:
            clock = Clock(clock_type=ClockType.STEADY_TIME)
            self._timer = self._node.create_timer(1.0 / _RATE, self._look, clock=clock)
        elif not wanted and self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None

    def _look(self) -> None:
        try:
            session = self._session()
            self._report(bool(self._motions))
            for handle, motion in self._motions.values():
                if session is not None and motion.goal is not None:
                    handle.publish_feedback(self._feedback(session, handle, motion))
        except Exception:
            self._node.get_logger().error(traceback.format_exc(), **ONCE_A_SECOND)

    def _feedback(self, session: Session, handle: ServerGoalHandle, motion: Motion) -> Any:
        names, goal = list(handle.request.trajectory.joint_names), motion.goal
        order = [session.robot.motor_names.index(name) for name in names]
        assert goal is not None
        now = time.monotonic()
        measured, due = session.measured.newest(now), goal.due(now)
        velocity = None
        if measured is None:
            motors = session.solver.current.equilibrium.motors[order]
            velocity = session.present.velocity[order]
            reached = goal.time
        else:
            motors = measured.motors[order]
            due = reached = due - measured.age
        wanted = MotorMotion(*(numbers[order] for numbers in goal.path.at(due)))
        slower = None if velocity is None else wanted.velocities - velocity
        points = FeedbackPoints(
            point_message(due, *wanted),
            point_message(reached, motors, velocity),
            point_message(due, wanted.positions - motors, slower),
        )
        stamp = self._node.get_clock().now().to_msg()
        return self._dialect.feedback(session, handle.request, Header(stamp=stamp), points)

    def _end(self, handle: ServerGoalHandle, ending: Ending) -> None:
        """Bring a goal to its end; must not raise."""
        try:
            logger = self._node.get_logger()
            if ending.val == ErrorCode.SUCCESS:
                logger.info(f"trajectory done after {ending.time:.3f} s")
            elif ending.val == ErrorCode.INVALID_MOTION_PLAN:
                logger.warning(f"trajectory refused: {ending.val}: {ending.message}")
            elif ending.replaced or handle.is_cancel_requested:  # as its client wanted it
                logger.info(f"trajectory ended: {ending.val}: {ending.message}")
            else:
                logger.warning(f"trajectory ended: {ending.val}: {ending.message}")
            result = self._dialect.result(ending, self._node, self._session())
            self._finish(handle, ending.val, result)
        except Exception:
            self._node.get_logger().error(traceback.format_exc())


def trajectory_actions(
    node: Node, session: Callable[[], Session | None], frames: Frames
) -> list[TrajectoryAction]:
    """Offer every action whose messages are installed."""
    dialects: list[Any] = [_FollowTrajectoryDialect(frames), FollowJointTrajectoryDialect()]
    return [
        TrajectoryAction(node, session, dialect) for dialect in dialects if dialect.kind is not None
    ]


def _key(handle: ServerGoalHandle) -> bytes:
    """What a goal is known by; handles cannot be keys."""
    return bytes(handle.goal_id.uuid)


def _ending_of(error: Exception) -> Ending:
    """The end of a trajectory that never began."""
    code = error_code(error)
    if isinstance(error, TrajectoryRefused):
        return Ending(code.val, code.message, error.time, error.measure)
    return Ending(code.val, code.message)
