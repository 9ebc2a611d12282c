# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether the robot may be put at a solution that somebody has asked for. No rclpy here."""

from __future__ import annotations

from cpr_msgs.msg import ErrorCode

from cpr_core.model.assessment import Assessment
from cpr_core.solving.deadline import Deadline

from ..error_codes import RequestError
from ..following.straight_way import check_straight_way
from .orders import Orders

__all__ = ["check_applied"]


def check_applied(solution: Assessment, deadline: Deadline, orders: Orders) -> None:
    """Whether the robot may be put at a solution, and the motors may go there from where they are.

    Args:
        solution: The solution.
        deadline: When that has to be known.
        orders: What the robot has been asked to do, and where its motors are sent.

    Raises:
        RequestError: It may not, or that was not found out in time.
    """
    outgoing, occupied = orders.outgoing, _occupied(orders)
    if occupied:
        raise RequestError(ErrorCode.NOT_READY, f"apply: {occupied}")
    if solution.index > 0:
        raise RequestError(
            ErrorCode.UNSTABLE_EQUILIBRIUM,
            f"apply: the solution is unstable with the motors held (index {solution.index}), "
            "so the robot cannot rest there; ask without apply to see it",
        )
    commands, thresholds = outgoing.commands.newest, orders.follower.settings.thresholds
    if outgoing.tracking is None and commands is not None:
        current = outgoing.solver.current
        check_straight_way(current, commands, solution.equilibrium, thresholds, deadline)


def _occupied(orders: Orders) -> str:
    """Why the robot is not put elsewhere now; empty: nothing is against it."""
    if orders.outgoing.in_question:
        return orders.outgoing.in_question
    end_it = "an empty ~/joint_trajectory ends that"
    if orders.follower.moving:
        return f"the robot is on its way; {end_it}"
    if not orders.trajectories.at_rest:
        return f"a trajectory is to be followed; {end_it}"
    if orders.awaiting:
        return f"a goal of ~/move_to waits to be measured where it is; {end_it}"
    if orders.follower.paused and orders.outgoing.aligned:
        return "the node is paused: release it first"  # else motors set off when the pause ends
    return ""  # commands that are on their way go to the new place instead
