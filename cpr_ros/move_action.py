# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Action ``~/move_to``: a setpoint that says when it is reached, or why it is not."""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from cpr_msgs.action import MoveTo
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import GoalEvent, ServerGoalHandle
from rclpy.node import Node

from cpr_core import CprError, InvalidRequest
from cpr_core.model.assessment import Assessment
from cpr_core.validation import checked_number

from .conversions import Frames, fill_equilibrium, pose_from_message
from .error_codes import RequestError, active, error_code
from .goals import Goal, MotorGoal, PoseGoal
from .motor_messages import motor_setpoint
from .session import Session
from .setpoint_following import ARRIVED
from .supervision import State

__all__ = ["MoveAction", "goal_of"]

#: Rate of feedback [Hz].
_FEEDBACK_RATE = 20.0


def goal_of(session: Session, request: MoveTo.Goal, frames: Frames) -> Goal:
    """Where a request sends the robot.

    Raises:
        InvalidRequest: Wrong names or numbers; also ``NonFiniteInput`` and ``InvalidQuaternion``.
        RequestError: An unknown frame, no such ``given``, or motors beyond their range.
    """
    robot = session.robot
    if request.given == MoveTo.Goal.GIVEN_POSE:
        pose = pose_from_message(robot, request.platform, [], frames, "platform.")
        return PoseGoal(robot, pose)
    if request.given != MoveTo.Goal.GIVEN_MOTORS:
        raise InvalidRequest(
            "given", f"expected GIVEN_POSE 0 or GIVEN_MOTORS 1, got {request.given}"
        )
    here = session.solver.current.equilibrium.motors
    motors = motor_setpoint(robot, request.motors, here, "motors.")
    goal = MotorGoal(robot, motors)
    if goal.clipped:  # a setpoint goes as far as it can; who wants a result wants to be there
        raise RequestError(
            ErrorCode.MOTOR_LIMIT,
            f"motors.position: {', '.join(goal.clipped)} would be beyond the range, "
            f"the nearest within it is {goal.motors.tolist()}",
        )
    return goal


@dataclass(frozen=True)
class _Motion:
    """A goal on its way."""

    handle: ServerGoalHandle
    goal: Goal
    patience: float


class MoveAction:
    """The action. Every goal gets a result: rejecting one in the way of ROS could give no reason."""

    def __init__(self, node: Node, frames: Frames, session: Callable[[], Session | None]) -> None:
        """Offer the action.

        Args:
            node: The node.
            frames: Names of the frames.
            session: Gives the robot in operation; None while the node is not active.
        """
        self._node, self._frames, self._session = node, frames, session
        self._motion: _Motion | None = None
        self._halted_since = math.inf
        self._told = -math.inf
        self._server = ActionServer(
            node,
            MoveTo,
            "~/move_to",
            execute_callback=lambda handle: MoveTo.Result(),  # every goal brings its own
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )

    def after_tick(self, session: Session, now: float) -> None:
        """See how far the goal on its way has come; to be called after every tick.

        Args:
            session: The robot in operation.
            now: Steady time [s].
        """
        motion = self._motion
        if motion is None:
            return
        outcome = session.outcome
        if session.follower.goal is not motion.goal:
            self._end(motion, RequestError(ErrorCode.PREEMPTED, _replaced_by(session)))
            return
        equilibrium = outcome.assessment.equilibrium
        remaining = session.follower.corrected(motion.goal).remaining(equilibrium)
        if remaining <= ARRIVED and session.commands.there(equilibrium.motors):
            self._end(motion, None)
            return
        if outcome.state != State.HALTED:
            self._halted_since = math.inf
        else:
            self._halted_since = min(self._halted_since, now)
            if now - self._halted_since >= motion.patience:
                session.follower.drop()
                text = f"halted for {motion.patience:g} s: {outcome.verdict.text}"
                self._end(motion, RequestError(ErrorCode.CONTROL_FAILED, text))
                return
        if now - self._told >= 1.0 / _FEEDBACK_RATE:
            self._told = now
            told = outcome.verdict
            motion.handle.publish_feedback(
                MoveTo.Feedback(
                    remaining=remaining,
                    margin=outcome.assessment.margin,
                    action=int(told.action),
                    speed_scale=told.speed_scale,
                    status_text=told.text,
                )
            )

    def stop(self, reason: str) -> None:
        """End the goal on its way, because the node cannot go on with it."""
        if self._motion is not None:
            self._end(self._motion, RequestError(ErrorCode.NOT_READY, reason))

    def close(self) -> None:
        """Take the action away before the node ends."""
        self._server.destroy()

    def _begin(self, handle: ServerGoalHandle) -> None:
        # As in the action of maps: not `handle.execute`.
        handle._update_state(GoalEvent.EXECUTE)
        session = self._session()
        try:
            session = active(session)
            patience = checked_number("patience", handle.request.patience)
            if patience < 0.0:
                raise InvalidRequest("patience", f"expected a time of at least 0 s, got {patience}")
            goal = goal_of(session, handle.request, self._frames)
            session.follow(goal, time.monotonic(), ages=False)
        except Exception as error:
            if not isinstance(error, CprError):
                self._node.get_logger().error(traceback.format_exc())
            self._finish(handle, None, error)
            return
        if self._motion is not None:
            self._end(self._motion, RequestError(ErrorCode.PREEMPTED, "replaced by another goal"))
        self._motion = _Motion(handle, goal, patience)
        self._halted_since, self._told = math.inf, -math.inf

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        motion, session = self._motion, self._session()
        if motion is None or handle is not motion.handle:
            return CancelResponse.REJECT
        # The next tick finds another goal than this one's: none.
        if session is not None and session.follower.goal is motion.goal:
            session.follower.drop()
        return CancelResponse.ACCEPT

    def _end(self, motion: _Motion, error: Exception | None) -> None:
        """Bring the goal on its way to its end."""
        self._motion = None
        self._finish(motion.handle, motion.goal, error)

    def _finish(self, handle: ServerGoalHandle, goal: Goal | None, error: Exception | None) -> None:
        """Answer a goal: it was reached, or why not."""
        canceled = handle.is_cancel_requested
        if canceled and error is not None:
            error = RequestError(ErrorCode.PREEMPTED, "the motion was cancelled, the robot holds")
        result = self._result(goal, error)

        def finished(handle: ServerGoalHandle) -> MoveTo.Result:
            if error is None:
                handle.succeed()
            elif canceled:
                handle.canceled()
            else:
                handle.abort()
            return result

        if error is not None:
            code = result.error_code
            self._node.get_logger().warning(f"move_to: {code.val}: {code.message}")
        self._server.notify_execute(handle, finished)

    def _result(self, goal: Goal | None, error: Exception | None) -> MoveTo.Result:
        session, result = self._session(), MoveTo.Result(remaining=math.nan)
        if error is None:
            result.error_code.val = ErrorCode.SUCCESS
        else:
            result.error_code = error_code(error)
        result.reached.index_locked = result.reached.index_free = -1  # 0 would be stable
        if session is None:
            return result
        current = session.solver.current
        if goal is not None:
            left = goal.remaining(current.equilibrium)
            result.remaining = left if error is not None else 0.0
        try:
            self._fill(result.reached, current)
        except Exception:  # there is a result, whatever happens
            self._node.get_logger().error(traceback.format_exc())
        return result

    def _fill(self, message: EquilibriumMessage, current: Assessment) -> None:
        fill_equilibrium(
            message,
            current.equilibrium,
            self._frames,
            self._node.get_clock().now().to_msg(),
            current.solve_time,
            eigenvalues=True,
        )


def _replaced_by(session: Session) -> str:
    """What took the place of a goal."""
    if session.follower.paused:
        return "the node was paused"
    if session.follower.returning:
        return "~/reset: the robot goes home"
    if session.follower.goal is None:
        return "the goal was dropped for another motion"
    return "replaced by a newer motion"
