# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Action ``~/move_to``: a setpoint that says when it is reached, or why it is not."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import PoseStamped
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from cpr_core import InvalidRequest
from cpr_core.validation import checked_number

from ..closed_loop.loop_status import LoopStatus
from ..closed_loop.measured_arrival import MeasuredArrival, measured_arrival
from ..error_codes import RequestError, active, error_code
from ..following.goals import Goal, MotorGoal, PoseGoal
from ..following.motor_arrival import Elsewhere, MotorArrival
from ..following.moved_by_others import SETTLING
from ..following.outcome import Outcome
from ..following.setpoint_following import ARRIVED
from ..following.supervision import State
from ..messages.frames import Frames
from ..messages.motor_messages import motor_setpoint
from ..messages.pose_messages import pose_from_message
from ..middleware.long_action import LongAction
from ..operation.session import Session
from .reached import reached

__all__ = ["MoveAction", "goal_of"]

#: Rate of feedback [Hz].
_FEEDBACK_RATE = 20.0


def goal_of(session: Session, request: MoveTo.Goal, frames: Frames) -> MotorGoal | PoseGoal:
    """Where a request sends the robot.

    Raises:
        InvalidRequest: Wrong names or numbers; also ``NonFiniteInput`` and ``InvalidQuaternion``.
        RequestError: An unknown frame, no such ``given``, or motors beyond their range.
    """
    robot = session.robot
    if request.given == MoveTo.Goal.GIVEN_POSE:
        _check_filled(request)
        pose = pose_from_message(robot, request.platform, [], frames, "platform.")
        return PoseGoal(robot, pose)
    if request.given != MoveTo.Goal.GIVEN_MOTORS:
        raise InvalidRequest(
            "given", f"expected GIVEN_POSE 0 or GIVEN_MOTORS 1, got {request.given}"
        )
    current = session.solver.current.equilibrium
    motors = motor_setpoint(robot, request.motors, current.motors, "motors.")
    goal = MotorGoal(robot, motors)
    if goal.clipped:  # a setpoint goes as far as it can; who wants a result wants to be there
        doubt = goal.doubt(current, session.follower.goal)
        raise RequestError(
            ErrorCode.MOTOR_LIMIT,
            f"motors.position: {', '.join(goal.clipped)} would be beyond the range, "
            f"the nearest within it is {goal.motors.tolist()}" + (f"; {doubt}" if doubt else ""),
        )
    return goal


def _check_filled(request: MoveTo.Goal) -> None:
    """Whether a pose was given: it is what a goal of which nobody has filled anything says it is.

    Raises:
        InvalidRequest: It was not.
    """
    if request.motors.name or request.motors.position:
        raise InvalidRequest(
            "given",
            "expected no motors with GIVEN_POSE, which is 0, the default: or GIVEN_MOTORS, 1",
        )
    if request.platform == PoseStamped():
        raise InvalidRequest(
            "platform",
            "expected a pose, got none: it is as in an empty goal; one to the origin of the base names "
            "its frame too",
        )


@dataclass(frozen=True)
class _Motion:
    """A goal on its way."""

    handle: ServerGoalHandle
    goal: Goal
    patience: float
    measured: MeasuredArrival
    motors: MotorArrival


class MoveAction(LongAction):
    """The action.

    Attributes:
        arrived_tolerance: Measured motors nearer to their commands are there [rad, rod lengths]; 0: all
            are, wherever they are measured.
    """

    def __init__(self, node: Node, frames: Frames, session: Callable[[], Session | None]) -> None:
        """Offer the action.

        Args:
            node: The node.
            frames: Names of the frames.
            session: Gives the robot in operation; None while the node is not active.
        """
        super().__init__(node, MoveTo, "~/move_to")
        self._frames, self._session = frames, session
        self.arrived_tolerance = 0.0
        self._motion: _Motion | None = None
        self._held_up, self._held_up_since = "", 0.0
        self._told = -math.inf

    def after_tick(self, session: Session, now: float) -> None:
        """See how far the goal on its way has come; to be called after every tick.

        Args:
            session: The robot in operation.
            now: Steady time [s].
        """
        motion = self._motion
        if motion is None:
            return
        outcome, before = session.present.outcome, motion.motors.last
        elsewhere = motion.motors.look(
            session.commands.newest, session.measured.seen(now), self.arrived_tolerance, now
        )
        if session.follower.goal is not motion.goal:
            # Where they rest already, the commands begin where they are measured.
            self._end(motion, *_ended_by(session, elsewhere if elsewhere.why else before))
            return
        equilibrium = outcome.assessment.equilibrium
        remaining = session.follower.corrected(motion.goal).remaining(equilibrium)
        sent = session.commands.newest is not None  # else the motors may be anywhere
        aligned = sent and session.commands.aligned_with(equilibrium.motors)
        aligned = aligned and outcome.state != State.ALIGNING
        arrived = remaining <= ARRIVED and aligned and outcome.refusal is None
        measured = session.loop_status(now)
        if arrived and not elsewhere.why and motion.measured.met(measured):
            self._end(motion, None)
            return
        if arrived and elsewhere.why:
            remaining = elsewhere.way
            longest = max(motion.patience, SETTLING)
            if motion.motors.waited(now) >= longest:
                missed = f"the motors were not measured where they were sent for {longest:g} s"
                text = f"{missed}: {elsewhere.why}"
                session.orders.drop(text)
                error = RequestError(ErrorCode.CONTROL_FAILED, text)
                self._end(motion, error, elsewhere.way)
                return
        held_up, why = _hindrance(motion, outcome, measured if arrived else None)
        if held_up != self._held_up:
            self._held_up, self._held_up_since = held_up, now
        if held_up and now - self._held_up_since >= motion.patience:
            text = f"{held_up} for {motion.patience:g} s: {why}"
            session.orders.drop(text)
            self._end(motion, RequestError(ErrorCode.CONTROL_FAILED, text))
            return
        if now - self._told >= 1.0 / _FEEDBACK_RATE:
            self._told = now
            self._feed_back(motion, session, remaining, measured)

    def stop(self, reason: str) -> None:
        """End the goal on its way, because the node cannot go on with it."""
        if self._motion is not None:
            self._end(self._motion, RequestError(ErrorCode.NOT_READY, reason))

    def _begin(self, handle: ServerGoalHandle) -> None:
        session = active(self._session())
        patience = checked_number("patience", handle.request.patience)
        if patience < 0.0:
            raise InvalidRequest("patience", f"expected a time of at least 0 s, got {patience}")
        goal = goal_of(session, handle.request, self._frames)
        measured = measured_arrival(handle.request, session.loop.coordinates)
        session.orders.follow(goal, time.monotonic(), ages=False)
        session.orders.await_end(goal)
        motors = MotorArrival(session.robot)
        replaced, self._motion = self._motion, _Motion(handle, goal, patience, measured, motors)
        self._held_up, self._told = "", -math.inf
        if replaced is not None:
            newer = RequestError(ErrorCode.PREEMPTED, "replaced by another goal")
            self._answer(replaced.handle, replaced.goal, newer)

    def _refuse(self, handle: ServerGoalHandle, error: Exception) -> None:
        self._answer(handle, None, error)

    def _cancel(self, handle: ServerGoalHandle) -> bool:
        motion, session = self._motion, self._session()
        if motion is None or handle is not motion.handle:
            return False
        # The next tick finds another goal than this one's: none.
        if session is not None and session.follower.goal is motion.goal:
            session.orders.drop()
        return True

    @staticmethod
    def _feed_back(
        motion: _Motion, session: Session, remaining: float, measured: LoopStatus
    ) -> None:
        told = session.verdict(time.monotonic())
        motion.handle.publish_feedback(
            MoveTo.Feedback(
                remaining=remaining,
                margin=session.present.outcome.assessment.margin,
                action=int(told.action),
                speed_scale=told.speed_scale,
                status_text=told.text,
                position_error=measured.position_error,
                rotation_error=measured.rotation_error,
            )
        )

    def _end(self, motion: _Motion, error: Exception | None, way: float = 0.0) -> None:
        """Bring the goal on its way to its end; ``way`` is what measured motors have left of it."""
        self._motion, session = None, self._session()
        if session is not None:
            session.orders.answered(motion.goal)
        self._answer(motion.handle, motion.goal, error, way)

    def _answer(
        self,
        handle: ServerGoalHandle,
        goal: Goal | None,
        error: Exception | None,
        way: float = 0.0,
    ) -> None:
        """Answer a goal: it was reached, or why not."""
        if error is not None and handle.is_cancel_requested:
            error = RequestError(ErrorCode.PREEMPTED, "the motion was cancelled, the robot holds")
        code = ErrorCode(val=ErrorCode.SUCCESS) if error is None else error_code(error)
        session = self._session()
        remaining, measured = 0.0 if error is None else math.nan, LoopStatus()
        if session is not None and goal is not None:
            measured = session.loop.status(goal, time.monotonic())
            if error is not None:
                wanted = session.follower.corrected(goal)
                remaining = wanted.remaining(session.solver.current.equilibrium)
                remaining = way if math.isnan(way) else max(remaining, way)
        result = MoveTo.Result(
            error_code=code,
            reached=reached(self._node, session, self._frames),
            remaining=remaining,
            position_error=measured.position_error,
            rotation_error=measured.rotation_error,
        )
        if error is not None:
            said = f"move_to: {code.val}: {code.message}"
            if handle.is_cancel_requested:  # as its client wanted it
                self._node.get_logger().info(said)
            else:
                self._node.get_logger().warning(said)
        self._finish(handle, code.val, result)


def _hindrance(motion: _Motion, outcome: Outcome, measured: LoopStatus | None) -> tuple[str, str]:
    """What keeps a goal from being come nearer to, and why; empty if nothing does.

    Args:
        motion: The goal.
        outcome: Of the last tick.
        measured: Where the platform is measured, if the model is at its target.
    """
    if outcome.refusal is not None:  # also of a robot that rests at its target
        return "halted", outcome.verdict.text
    why = "" if measured is None else motion.measured.hindrance(measured)
    return ("not measured at its target" if why else "", why)


def _ended_by(session: Session, elsewhere: Elsewhere) -> tuple[RequestError, float]:
    """What ended a goal before it was reached, and what measured motors have left of the way."""
    text = session.follower.dropped
    if session.follower.goal is None and text and text == session.orders.left_behind:
        text = f"{text}; {elsewhere.why}" if elsewhere.why else text
        return RequestError(ErrorCode.CONTROL_FAILED, text), elsewhere.way
    return RequestError(ErrorCode.PREEMPTED, _replaced_by(session)), 0.0


def _replaced_by(session: Session) -> str:
    """What took the place of a goal."""
    if session.follower.returning:
        return "~/reset: the robot goes home"
    if session.follower.goal is None:
        return session.follower.dropped
    return "replaced by a newer motion"
