# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Action ``~/map_workspace``: one map at a time, made in another process."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from typing import Any

from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from cpr_core.workspace import MapSummary

from ..error_codes import RequestError, active, code_of, error_code
from ..middleware.long_action import LongAction
from ..operation.session import Session
from .map_folder import MapFolder
from .map_messages import map_feedback, map_order, map_result
from .map_order import MapFailure
from .map_process import MapProcess

__all__ = ["MapAction"]

#: Rate at which the process is looked at, and the largest rate of feedback [Hz].
_RATE = 10.0


class MapAction(LongAction):
    """The action."""

    def __init__(
        self, node: Node, session: Callable[[], Session | None], folder: MapFolder
    ) -> None:
        """Offer the action.

        Args:
            node: The node.
            session: Gives the robot in operation; None while the node is not active.
            folder: Where maps may be written.
        """
        super().__init__(node, MapWorkspace, "~/map_workspace")
        self._session, self._folder = session, folder
        self._process: MapProcess | None = None
        self._handle: ServerGoalHandle | None = None
        self._timer: Any = None
        self._stopped_by = RequestError(ErrorCode.PREEMPTED, "the map was cancelled")

    def stop(self, reason: str) -> None:
        """End the map that is being made, because the node cannot go on with it."""
        if self._process is not None:
            self._stopped_by = RequestError(ErrorCode.NOT_READY, reason)
            self._process.stop(time.monotonic())

    def close(self) -> None:
        """End the process before the node ends."""
        if self._process is not None:
            self._process.close()
        super().close()

    def _begin(self, handle: ServerGoalHandle) -> None:
        order = self._ordered(handle.request)
        self._process, self._handle = MapProcess(order), handle
        self._stopped_by = RequestError(ErrorCode.PREEMPTED, "the map was cancelled")
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self._node.create_timer(1.0 / _RATE, self._look, clock=clock)
        cells = " x ".join(str(number) for number in order.grid.shape)
        self._node.get_logger().info(f"map of {cells} cells begun: {order.file}")

    def _ordered(self, goal: MapWorkspace.Goal) -> Any:
        session = active(self._session())
        if self._process is not None:
            state = self._process.state
            how_far = f"{state.done} of {state.total} cells are done" if state else "it has begun"
            raise RequestError(
                ErrorCode.NOT_READY,
                f"another map is being made ({how_far}), and there is one at a time: cancel it or "
                "wait for its result",
            )
        return map_order(session.solver, goal, self._folder)

    def _refuse(self, handle: ServerGoalHandle, error: Exception) -> None:
        self._end(handle, map_result(error_code(error), "", None))

    def _cancel(self, handle: ServerGoalHandle) -> bool:
        if self._process is None or handle is not self._handle:
            return False
        self._process.stop(time.monotonic())
        return True

    def _look(self) -> None:
        process, handle = self._process, self._handle
        assert process is not None and handle is not None
        try:
            if process.look(time.monotonic()) and process.state is not None:
                handle.publish_feedback(map_feedback(process.state))
            if not process.ended:
                return
            result = self._result(process)
        except Exception as error:
            self._node.get_logger().error(traceback.format_exc())
            process.close()
            result = map_result(error_code(error), "", None)
        self._node.destroy_timer(self._timer)
        self._process = self._handle = None
        self._end(handle, result)

    def _result(self, process: MapProcess) -> MapWorkspace.Result:
        found = process.result
        written = str(process.order.file) if process.written else ""
        if isinstance(found, MapFailure):
            return map_result(code_of(found.kind, found.message, found.argument), "", None)
        if process.death:
            died = RequestError(
                ErrorCode.FAILURE,
                f"the process that made the map ended with {process.death}; the log may say why",
            )
            return map_result(error_code(died), written, None)
        if isinstance(found, MapSummary) and found.complete:
            return map_result(ErrorCode(val=ErrorCode.SUCCESS), written, found)
        return map_result(error_code(self._stopped_by), written, found)

    def _end(self, handle: ServerGoalHandle, result: MapWorkspace.Result) -> None:
        """Bring a goal to its end."""
        code, logger = result.error_code, self._node.get_logger()
        if code.val == ErrorCode.SUCCESS:
            logger.info(
                f"map done, {result.reached} of {result.cells} cells reached: {result.file}"
            )
        else:
            kept = f"not complete, but kept in {result.file}" if result.file else "none"
            logger.warning(f"map: {kept}: {code.val}: {code.message}")
        self._finish(handle, code.val, result)
