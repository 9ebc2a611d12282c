# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What of control_msgs can be looked at without it: its tolerances and its error codes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from cpr_msgs.msg import ErrorCode
from helpers.drive import robot
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectory

from cpr_core import InvalidRequest, NonFiniteInput
from cpr_ros.following.trajectory_motion import Ending
from cpr_ros.interface.joint_trajectory_action import (
    FollowJointTrajectoryDialect,
    joint_error_code,
    joint_tolerances,
)
from cpr_ros.messages.trajectory_messages import AllowedErrors, trajectory_order


def tolerance(name, position, velocity=0.0, **others):
    """The fields of control_msgs/JointTolerance."""
    parts = {"position": position, "velocity": velocity, "acceleration": 0.0}
    return SimpleNamespace(name=name, **parts | others)


@pytest.mark.parametrize(
    ("ending", "code"),
    [
        (Ending(ErrorCode.SUCCESS), 0),
        (Ending(ErrorCode.INVALID_MOTION_PLAN, measure="margin"), -1),
        (Ending(ErrorCode.NON_FINITE_INPUT), -1),
        (Ending(ErrorCode.INVALID_ROBOT_STATE), -2),
        (Ending(ErrorCode.INVALID_MOTION_PLAN, measure="header.stamp"), -3),
        (Ending(ErrorCode.CONTROL_FAILED, measure="path_tolerance"), -4),
        (Ending(ErrorCode.CONTROL_FAILED, measure="margin"), -4),
        (Ending(ErrorCode.CONTROL_FAILED, measure="goal_time_tolerance"), -5),
    ],
)
def test_every_end_has_a_number_of_theirs(ending, code):
    assert joint_error_code(ending) == code


def test_tolerances_by_name_and_what_is_not_given_is_any():
    names = ["a", "b", "c"]
    given = [tolerance("b", 0.1), tolerance("c", -1.0)]
    assert joint_tolerances("path_tolerance", given, names) == [0.0, 0.1, 0.0]
    for wrong in (
        tolerance("d", 0.1),
        tolerance("a", 0.1, velocity=0.2),
        tolerance("a", 0.1, velocity=math.nan),
        tolerance("a", 0.1, acceleration=0.2),
        tolerance("a", 0.1, effort=0.2),
    ):
        with pytest.raises(InvalidRequest, match=r"path_tolerance\[0\]"):
            joint_tolerances("path_tolerance", [wrong], names)
    with pytest.raises(
        InvalidRequest, match=r"path_tolerance\[1\]\.name: .* once at most, got 'a'"
    ):
        joint_tolerances("path_tolerance", [tolerance("a", 0.1), tolerance("a", 0.2)], names)


@pytest.mark.parametrize("by_name", [True, False])
def test_both_dialects_mean_the_same_by_the_same_numbers(by_name):
    """In motor order, whatever the order of the names; a NaN was any in one of them."""
    made = robot("rfrfr")
    names = list(made.motor_names)[::-1]
    point = JointTrajectoryPoint(positions=[0.55, 2.59], time_from_start=Duration(sec=1))
    message = JointTrajectory(joint_names=names, points=[point])

    def order(first, last, *others):
        path, end = [first, 0.0], [0.0, last]
        if by_name:
            goal = SimpleNamespace(
                trajectory=message,
                path_tolerance=[tolerance(*pair) for pair in zip(names, path, strict=True)],
                goal_tolerance=[tolerance(*pair) for pair in zip(names, end, strict=True)],
                goal_time_tolerance=Duration(sec=-1),
                multi_dof_trajectory=MultiDOFJointTrajectory(joint_names=others),
                component_path_tolerance=[],
                component_goal_tolerance=[],
            )
            given = FollowJointTrajectoryDialect().allowed(goal)
        else:
            given = AllowedErrors(path, end)
        return trajectory_order(made, message, Time(), given)

    found = order(0.1, 0.2)
    np.testing.assert_array_equal(found.path_tolerance, [np.inf, 0.1])
    np.testing.assert_array_equal(found.goal_tolerance, [0.2, np.inf])
    assert found.goal_time_tolerance == np.inf
    with pytest.raises(NonFiniteInput, match="goal_tolerance"):
        order(0.1, math.nan)
    if by_name:
        with pytest.raises(InvalidRequest, match="multi_dof_trajectory: expected none"):
            order(0.1, 0.2, "platform")
