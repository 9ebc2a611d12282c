# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Services of the node. Every request gets an answer; one that fails changes nothing."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable
from typing import Any

from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward, SolveInverse
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from cpr_core import CprError, Equilibrium
from cpr_core.kernels.problems import ProblemName
from cpr_core.model.assessment import Assessment

from ..error_codes import active, error_code
from ..messages.analysis import fill_kinemato_statics, fill_prediction, fill_stability
from ..messages.equilibrium_messages import fill_equilibrium, no_equilibrium
from ..messages.frames import Frames
from ..messages.model_error import model_error_message
from ..middleware.waiting_requests import SERVICE_QOS, WaitingRequests
from ..operation.session import Session

__all__ = ["Requests"]


class Requests:
    """Everything the node can be asked."""

    def __init__(
        self,
        node: Node,
        frames: Frames,
        session: Callable[[], Session | None],
        waiting: WaitingRequests,
    ) -> None:
        """Offer the services.

        Args:
            node: The node.
            frames: Names of the frames.
            session: Gives the robot in operation; None while the node is not active.
            waiting: The line of those to solve something, which are answered one at a time.
        """
        self._node, self._frames, self._session = node, frames, session
        for kind, name, fill in (
            (SolveForward, "solve_forward", self._forward),
            (SolveInverse, "solve_inverse", self._inverse),
            (GetKinematoStatics, "get_kinemato_statics", _about(fill_kinemato_statics)),
            (Predict, "predict", _about(fill_prediction)),
            (CheckStability, "check_stability", _about(fill_stability)),
        ):
            waiting.create_service(node, kind, f"~/{name}", self._answering(fill))
        for kind, name, act in ((SetBool, "pause", _pause), (Trigger, "reset", _reset)):
            node.create_service(kind, f"~/{name}", self._answering(act), qos_profile=SERVICE_QOS)

    def _answering(self, fill: Callable[[Session, Any, Any], None]) -> Callable[[Any, Any], Any]:
        """A callback that cannot raise: the client would wait for ever."""

        def callback(request: Any, response: Any) -> Any:
            try:
                session = active(self._session())
                fill(session, request, response)
                code = None
            except Exception as error:
                code = error_code(error)
                if not isinstance(error, CprError):
                    self._node.get_logger().error(traceback.format_exc())
            if hasattr(response, "error_code"):
                if code is None:
                    response.error_code.val = ErrorCode.SUCCESS
                else:
                    response.error_code = code
                    _say_not_found(response)
            elif code is not None:
                response.success, response.message = False, f"{code.val}: {code.message}"
            return response

        return callback

    def _forward(self, session: Session, request: Any, response: Any) -> None:
        solution = session.solver.forward(request)
        held: ProblemName = "motors" if len(request.motors.position) else "efforts"
        self._fill(response, solution, request, held)

    def _inverse(self, session: Session, request: Any, response: Any) -> None:
        solution = session.solver.inverse(request)
        response.objective = solution.equilibrium.objective
        redundant = solution.equilibrium.robot.redundancy
        self._fill(response, solution, request, "motors" if redundant else "pose")

    def _fill(self, response: Any, solution: Assessment, request: Any, held: ProblemName) -> None:
        if request.with_model_error:
            response.model_error = [model_error_message(solution.equilibrium, held)]
        fill_equilibrium(
            response.solution,
            solution.equilibrium,
            self._frames,
            self._node.get_clock().now().to_msg(),
            solution.solve_time,
            eigenvalues=request.with_eigenvalues,
        )


def _say_not_found(response: Any) -> None:
    """Of what was not found: an index 0 would be stable, a margin 0 critical."""
    if hasattr(response, "solution"):
        response.solution = no_equilibrium()
    if hasattr(response, "index"):
        response.index, response.margin = -1, math.nan
        response.inverse_condition_number = math.nan


def _about(
    fill: Callable[[Equilibrium, Any, Any], None],
) -> Callable[[Session, Any, Any], None]:
    """A service that asks about one equilibrium."""
    return lambda session, request, response: fill(
        session.solver.equilibrium_of(request), request, response
    )


def _pause(session: Session, request: SetBool.Request, response: SetBool.Response) -> None:
    response.message = session.orders.pause(request.data)
    response.success = True


def _reset(session: Session, _request: Trigger.Request, response: Trigger.Response) -> None:
    response.message = session.orders.reset()
    response.success = True
