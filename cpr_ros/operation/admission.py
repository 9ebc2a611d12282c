# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether a session takes what is asked of it now: setpoints, trajectories, another place."""

from __future__ import annotations

from dataclasses import dataclass

from cpr_msgs.msg import ErrorCode

from cpr_core import Equilibrium
from cpr_core.solving.deadline import Deadline

from ..error_codes import RequestError
from ..following.goals import Goal
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
        awaited: Goal of which somebody waits to hear how it ends, which ticks tell; None: nobody does.
    """

    solver: Solver
    follower: SetpointFollower
    trajectories: Trajectories
    tracking: MotorTracking | None
    commands: MotorCommands
    others: MovedByOthers
    awaited: Goal | None = None

    @property
    def aligned(self) -> bool:
        """Whether the motors have been sent where the node has the robot."""
        return self.commands.aligned_with(self.solver.current.equilibrium.motors)

    @property
    def awaiting(self) -> bool:
        """Whether somebody waits to hear how the goal of now ends."""
        return self.awaited is not None and self.awaited is self.follower.goal

    def occupied(self) -> str:
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

    def check_way(self, solution: Equilibrium, deadline: Deadline) -> None:
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

    def check_where_commanded(self) -> None:
        """Whether the motors are where the node has sent them.

        Raises:
            RequestError: They are not.
        """
        if self.others.in_question:
            raise RequestError(ErrorCode.NOT_READY, self.others.in_question)
