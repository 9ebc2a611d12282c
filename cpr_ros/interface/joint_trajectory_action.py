# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""``~/follow_joint_trajectory``, where control_msgs is installed; nothing where it is not."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from typing import Any

from cpr_msgs.msg import ErrorCode
from rclpy.node import Node

from cpr_core import InvalidRequest

from ..following.trajectory_motion import Ending
from ..messages.trajectory_messages import AllowedErrors
from ..messages.trajectory_points import FeedbackPoints, seconds_of
from ..operation.session import Session

try:
    from control_msgs.action import FollowJointTrajectory
except ImportError:  # not among the wheels
    FollowJointTrajectory = None

__all__ = ["FollowJointTrajectoryDialect", "joint_error_code", "joint_tolerances"]

_SUCCESSFUL, _INVALID_GOAL, _INVALID_JOINTS, _OLD_STAMP = 0, -1, -2, -3
_PATH_TOLERANCE, _GOAL_TOLERANCE = -4, -5
#: Of what a joint has beside a position; not every version of control_msgs knows them all.
_OTHER_TOLERANCES = ("velocity", "acceleration", "effort")


def joint_error_code(ending: Ending) -> int:
    """Number of ``FollowJointTrajectory.Result``; it has none of its own for a halt."""
    if ending.val == ErrorCode.SUCCESS:
        return _SUCCESSFUL
    if ending.val == ErrorCode.INVALID_ROBOT_STATE:
        return _INVALID_JOINTS
    if ending.measure == "header.stamp":
        return _OLD_STAMP
    if ending.val in (ErrorCode.CONTROL_FAILED, ErrorCode.PREEMPTED):
        at_end = ending.measure in ("goal_time_tolerance", "goal_tolerance")
        return _GOAL_TOLERANCE if at_end else _PATH_TOLERANCE
    return _INVALID_GOAL


def joint_tolerances(field: str, given: Sequence[Any], names: Sequence[str]) -> list[float]:
    """Positions of ``control_msgs/JointTolerance`` in the order of the names; 0: any.

    There 0 is the default, which is any here, and a negative number is any.

    Raises:
        InvalidRequest: A joint that is none of the names or comes twice, or a tolerance of something
            else than its position.
    """
    found: dict[str, float] = {}
    for number, tolerance in enumerate(given):
        if tolerance.name not in names or tolerance.name in found:
            raise InvalidRequest(
                f"{field}[{number}].name",
                f"expected each of {', '.join(names)} once at most, got {tolerance.name!r}",
            )
        if not all(getattr(tolerance, other, 0.0) <= 0.0 for other in _OTHER_TOLERANCES):
            raise InvalidRequest(f"{field}[{number}]", "expected a tolerance of the position only")
        found[tolerance.name] = 0.0 if tolerance.position < 0.0 else tolerance.position
    return [found.get(name, 0.0) for name in names]


class FollowJointTrajectoryDialect:
    """Goals, feedback and results of ``control_msgs/action/FollowJointTrajectory``."""

    kind, name = FollowJointTrajectory, "~/follow_joint_trajectory"

    def allowed(self, goal: Any) -> AllowedErrors:
        """What a goal allows.

        Raises:
            InvalidRequest: Tolerances that are none, or joints of more than one degree of freedom.
        """
        others = goal.multi_dof_trajectory
        if (
            len(others.joint_names)
            or len(others.points)
            or len(goal.component_path_tolerance)
            or len(goal.component_goal_tolerance)
        ):
            raise InvalidRequest(
                "multi_dof_trajectory",
                "expected none, nor tolerances for one: a motor has one degree of freedom",
            )
        names = list(goal.trajectory.joint_names)
        return AllowedErrors(
            joint_tolerances("path_tolerance", goal.path_tolerance, names),
            joint_tolerances("goal_tolerance", goal.goal_tolerance, names),
            max(0.0, seconds_of(goal.goal_time_tolerance)),
        )

    def feedback(self, session: Session, goal: Any, header: Any, points: FeedbackPoints) -> Any:
        """How a trajectory goes on."""
        feedback = FollowJointTrajectory.Feedback(
            header=header,
            joint_names=goal.trajectory.joint_names,
            **points._asdict(),
        )
        if hasattr(feedback, "index"):  # since control_msgs 6.4: the point it comes from
            times = [seconds_of(point.time_from_start) for point in goal.trajectory.points]
            feedback.index = max(0, bisect(times, seconds_of(points.desired.time_from_start)) - 1)
        return feedback

    def result(self, ending: Ending, node: Node, session: Session | None) -> Any:
        """How a trajectory ended."""
        return FollowJointTrajectory.Result(
            error_code=joint_error_code(ending), error_string=ending.message
        )
