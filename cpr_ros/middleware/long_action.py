# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An action whose goals take their time, in a node with one thread."""

from __future__ import annotations

import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from cpr_msgs.msg import ErrorCode
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import GoalEvent, ServerGoalHandle
from rclpy.node import Node

from cpr_core import CprError

from .result_clock import ResultClock
from .waiting_requests import SERVICE_QOS

__all__ = ["LongAction"]

#: Results are kept for clients that ask late, by steady time [s]. At every step of a goal rclpy tells
#: the state of all whose results are kept: those of fifteen minutes, its default, hold the node up.
_RESULT_KEPT = 10


class LongAction(ABC):
    """Takes goals, and gives every one of them a result, soon or later.

    None is rejected in the way of ROS, which could give no reason. Nothing that rclpy calls raises: with
    an executor of events that ends the process.
    """

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        """Offer the action.

        Args:
            node: The node.
            kind: Its type.
            name: Its name.
        """
        self._node, self._clock = node, ResultClock(node, _RESULT_KEPT, self._forget)
        self._server = ActionServer(
            self._clock,
            kind,
            name,
            execute_callback=lambda handle: kind.Result(),  # every goal brings its own
            goal_callback=self._take,
            handle_accepted_callback=self._guarded(self._accept),
            cancel_callback=self._guarded(self._answer_cancel, CancelResponse.REJECT),
            goal_service_qos_profile=SERVICE_QOS,
            result_service_qos_profile=SERVICE_QOS,
            cancel_service_qos_profile=SERVICE_QOS,
            result_timeout=_RESULT_KEPT,
        )

    def close(self) -> None:
        """Offer it no longer."""
        self._clock.close()
        self._server.destroy()

    @abstractmethod
    def _begin(self, handle: ServerGoalHandle) -> None:
        """Begin with a goal; what is raised refuses it."""

    @abstractmethod
    def _refuse(self, handle: ServerGoalHandle, error: Exception) -> None:
        """Finish a goal that could not begin."""

    @abstractmethod
    def _cancel(self, handle: ServerGoalHandle) -> bool:
        """Bring a goal to its end soon; whether it was on its way."""

    def _finish(self, handle: ServerGoalHandle, val: int, result: Any) -> None:
        """Bring a goal to its end.

        Args:
            handle: The goal.
            val: Number of cpr_msgs/ErrorCode.
            result: Its result.
        """

        def finished(handle: ServerGoalHandle) -> Any:
            self._clock.ending()
            if val == ErrorCode.SUCCESS:
                handle.succeed()
            elif handle.is_cancel_requested:
                handle.canceled()
            else:
                handle.abort()
            return result

        self._server.notify_execute(handle, self._guarded(finished, result))

    def _take(self, goal: Any) -> GoalResponse:
        self._clock.begin_to_accept()
        return GoalResponse.ACCEPT

    def _forget(self) -> None:
        """Forget results that were kept for long enough.

        The timer of rcl_action comes too late for those that are left: it is set anew with the period of
        before.
        """
        server = self._server
        if server._goal_handles:
            over = server._handle.expire_goals(len(server._goal_handles))
            self._node.executor.create_task(server._execute_expire_goals, over)

    def _accept(self, handle: ServerGoalHandle) -> None:
        self._clock.accepted()
        # Not `handle.execute`: that wants the result in the same breath, and a coroutine that awaits
        # one keeps rclpy's executor spinning at full load.
        handle._update_state(GoalEvent.EXECUTE)
        try:
            self._begin(handle)
        except Exception as error:
            if not isinstance(error, CprError):
                self._node.get_logger().error(traceback.format_exc())
            self._refuse(handle, error)

    def _answer_cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        return CancelResponse.ACCEPT if self._cancel(handle) else CancelResponse.REJECT

    def _guarded(
        self, callback: Callable[[ServerGoalHandle], Any], otherwise: Any = None
    ) -> Callable[[ServerGoalHandle], Any]:
        """A callback that logs what it raises."""

        def guarded(handle: ServerGoalHandle) -> Any:
            try:
                return callback(handle)
            except Exception:
                self._node.get_logger().error(traceback.format_exc())
                return otherwise

        return guarded
