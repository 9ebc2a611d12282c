# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether a session takes what is asked of it now: setpoints, trajectories, another place."""

from __future__ import annotations

from dataclasses import dataclass, field

from cpr_msgs.msg import ErrorCode

from cpr_core import Equilibrium
from cpr_core.model.assessment import Assessment
from cpr_core.solving.deadline import Deadline

from ..error_codes import RequestError
from ..following.goals import Goal, MotorGoal, PoseGoal
from ..following.motor_commands import MotorCommands
from ..following.motor_tracking import MotorTracking
from ..following.moved_by_others import MovedByOthers
from ..following.setpoint_following import SetpointFollower
from ..following.straight_way import check_straight_way
from ..following.trajectory_following import Trajectories
from .solver import Solver

__all__ = ["Admission"]


@dataclass
class Admission:
    """What a session takes, by what its parts do.

    Attributes:
        solver: Where the robot is believed to be.
        follower: Setpoint following.
        trajectories: Timed trajectories.
        tracking: Tracking of measured motors; None: the node moves the motors.
        commands: Where the motors are sent.
        others: Whether others have moved them.
    """

    solver: Solver
    follower: SetpointFollower
    trajectories: Trajectories
    tracking: MotorTracking | None
    commands: MotorCommands
    others: MovedByOthers
    _awaited: Goal | None = field(default=None, init=False)

    @property
    def aligned(self) -> bool:
        """Whether the motors have been sent where the node has the robot."""
        return self.commands.aligned_with(self.solver.current.equilibrium.motors)

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

    def check_applied(self, solution: Assessment, deadline: Deadline) -> None:
        """Whether the robot may be put at a solution.

        Raises:
            RequestError: It may not, or that was not found out in time.
        """
        occupied = self._occupied()
        if occupied:
            raise RequestError(ErrorCode.NOT_READY, f"apply: {occupied}")
        if solution.index > 0:
            raise RequestError(
                ErrorCode.UNSTABLE_EQUILIBRIUM,
                f"apply: the solution is unstable with the motors held (index {solution.index}), "
                "so the robot cannot rest there; ask without apply to see it",
            )
        self._check_way(solution.equilibrium, deadline)

    def _occupied(self) -> str:
        """Why the robot is not put elsewhere now; empty: nothing is against it."""
        if self.others.in_question:
            return self.others.in_question
        end_it = "an empty ~/joint_trajectory ends that"
        if self.follower.moving:
            return f"the robot is on its way; {end_it}"
        if not self.trajectories.at_rest:
            return f"a trajectory is to be followed; {end_it}"
        if self.awaiting:
            return f"a goal of ~/move_to waits to be measured where it is; {end_it}"
        if self.follower.paused and self.aligned:
            return "the node is paused: release it first"  # else motors set off when the pause ends
        return ""  # commands that are on their way go to the new place instead

    def _check_way(self, solution: Equilibrium, deadline: Deadline) -> None:
        """Whether the motors may go to an equilibrium from where they are.

        Raises:
            RequestError: They may not, or that was not found out in time.
        """
        if self.tracking is None and self.commands.newest is not None:
            check_straight_way(
                self.solver.current,
                self.commands.newest,
                solution,
                self.follower.settings.thresholds,
                deadline,
            )

    def check_moving(self) -> None:
        """Whether it is the node that moves the motors.

        Raises:
            RequestError: It is not.
        """
        if self.tracking is not None:
            raise RequestError(
                ErrorCode.NOT_READY, "the node tracks measured motors and takes no setpoints"
            )

    def check_free(self) -> None:
        """Whether setpoints and trajectories are taken now.

        Raises:
            RequestError: They are not.
        """
        self.check_moving()
        if self.follower.paused:
            raise RequestError(ErrorCode.NOT_READY, "the node is paused")
        if self.follower.returning:
            raise RequestError(ErrorCode.NOT_READY, "the node is on its way home")
        self.check_where_commanded()

    def check_meant(self, goal: MotorGoal | PoseGoal) -> None:
        """Whether the numbers of a setpoint can be meant in radians and metres.

        Raises:
            RequestError: They look like another unit: the robot would go as far as it can.
        """
        doubt = goal.doubt(self.solver.current.equilibrium, self.follower.goal)
        if doubt:
            raise RequestError(ErrorCode.INVALID_ROBOT_STATE, doubt)

    def check_where_commanded(self) -> None:
        """Whether the motors are where the node has sent them.

        Raises:
            RequestError: They are not.
        """
        if self.others.in_question:
            raise RequestError(ErrorCode.NOT_READY, self.others.in_question)
