# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node knows and how it answers requests. No rclpy here: state, and one call per service."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward, SolveInverse

from cpr_core import (
    Equilibrium,
    Loads,
    Robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
)
from cpr_core.model.assessment import Assessment
from cpr_core.solving.deadline import Deadline

from ..error_codes import RequestError
from ..following.setpoint_following import SetpointFollower
from ..messages.equilibrium_messages import equilibrium_from_message
from ..messages.frames import Frames
from ..messages.motor_messages import motors_from_joint_state
from ..messages.pose_messages import pose_from_message
from ..messages.wrench_messages import with_wrench

__all__ = ["Solver"]


class Solver:
    """The robot of the node and its current equilibrium.

    Attributes:
        robot: The robot.
        frames: Names of the frames.
        current: Current equilibrium; replaced by motion, and by a successful request with ``apply``.
        time_limit: Longest time of a request, whatever belongs to it [s].
        clock: Steady time, by which that is measured [s].
    """

    def __init__(
        self,
        robot: Robot,
        frames: Frames,
        follower: SetpointFollower,
        time_limit: float,
        characteristic_length: float | None = None,
        check_applied: Callable[[Assessment, Deadline], None] = lambda solution, deadline: None,
    ) -> None:
        """Start at the home equilibrium.

        Args:
            robot: The robot.
            frames: Names of the frames.
            follower: Forgets its setpoint when a solution is applied.
            time_limit: See the attribute [s].
            characteristic_length: Weighs rotations in singular values [m]; None: the mean rod length.
            check_applied: Raises where the robot may not be put at a solution, or that is not found out
                before the deadline.
        """
        self.robot = robot
        self.frames = frames
        self._follower = follower
        self._length = characteristic_length
        self.time_limit = time_limit
        self.clock: Callable[[], float] = time.perf_counter
        self._check_applied = check_applied
        self.current = self._timed(lambda: solve_home(robot))

    def forward(self, request: SolveForward.Request) -> Assessment:
        """Answer a forward request.

        Raises:
            CprError: The request cannot be met; the node is as it was.
        """
        deadline = Deadline(self.time_limit, self.clock)
        by_effort, values = motors_from_joint_state(self.robot, request.motors)
        start, loads = self.start_and_loads(request)
        solve = solve_forward_by_effort if by_effort else solve_forward
        solution = self._timed(
            lambda: solve(self.robot, values, start=start, loads=loads, time_limit=deadline.left)
        )
        return self._applied(solution, request.apply, deadline)

    def inverse(self, request: SolveInverse.Request) -> Assessment:
        """Answer an inverse request.

        Raises:
            CprError: The request cannot be met; the node is as it was.
        """
        deadline = Deadline(self.time_limit, self.clock)
        pose = pose_from_message(
            self.robot, request.platform, list(request.controlled), self.frames, "platform."
        )
        start, loads = self.start_and_loads(request)
        solution = self._timed(
            lambda: solve_inverse(
                self.robot,
                pose,
                start=start,
                loads=loads,
                time_limit=deadline.left,
                objective=request.objective or None,
            )
        )
        return self._applied(solution, request.apply, deadline)

    def equilibrium_of(
        self, request: GetKinematoStatics.Request | Predict.Request | CheckStability.Request
    ) -> Equilibrium:
        """The equilibrium a question is about.

        Raises:
            CprError: None, or the given one is none.
        """
        if request.at == request.AT_CURRENT:
            return self.current.equilibrium
        if request.at == request.AT_HOME:
            return solve_home(self.robot)
        if request.at == request.AT_GIVEN:
            return self._given("equilibrium", request.equilibrium)
        raise RequestError(
            ErrorCode.INVALID_ROBOT_STATE,
            f"at: expected AT_CURRENT 0, AT_HOME 1 or AT_GIVEN 2, got {request.at}",
        )

    def start_and_loads(
        self, request: SolveForward.Request | SolveInverse.Request | MapWorkspace.Goal
    ) -> tuple[Equilibrium, Loads]:
        """Where a request starts, and the loads in force.

        Raises:
            CprError: There is no such start, or no such wrench.
        """
        if request.start == request.START_CURRENT:
            start = self.current.equilibrium
        elif request.start == request.START_HOME:
            start = solve_home(self.robot)
        elif request.start == request.START_GIVEN:
            start = self._given("start_equilibrium", request.start_equilibrium)
        else:
            raise RequestError(
                ErrorCode.INVALID_ROBOT_STATE,
                f"start: expected START_CURRENT 0, START_HOME 1 or START_GIVEN 2, "
                f"got {request.start}",
            )
        if len(request.wrench):
            return start, with_wrench(start.loads, request.wrench[0], self.frames, "wrench[0].")
        return start, start.loads

    def _given(self, field: str, messages: Sequence[EquilibriumMessage]) -> Equilibrium:
        """The equilibrium of a request that has to bring one."""
        if len(messages) != 1:
            raise RequestError(
                ErrorCode.INVALID_ROBOT_STATE, f"{field}: expected one, got {len(messages)}"
            )
        return equilibrium_from_message(self.robot, messages[0])

    def _applied(self, solution: Assessment, apply: bool, deadline: Deadline) -> Assessment:
        if apply:
            self._check_applied(solution, deadline)
            self._follower.drop("a solution was applied")
            self.current = solution
        return solution

    def _timed(self, solve: Callable[[], Equilibrium]) -> Assessment:
        begin = time.perf_counter()
        equilibrium = solve()
        return Assessment(equilibrium, self._length, time.perf_counter() - begin)
