# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What of control_msgs can be looked at without it: its tolerances and its error codes."""

from types import SimpleNamespace

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode

from cpr_core import InvalidRequest
from cpr_ros.joint_trajectory_action import joint_error_code, joint_tolerances
from cpr_ros.trajectory_following import Ending


def tolerance(name, position, velocity=0.0):
    """The fields of control_msgs/JointTolerance."""
    return SimpleNamespace(name=name, position=position, velocity=velocity, acceleration=0.0)


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
    given = [tolerance("b", 0.1), tolerance("a", 0.0), tolerance("c", -1.0)]
    np.testing.assert_array_equal(
        joint_tolerances("path_tolerance", given, ["a", "b", "c"]), [np.inf, 0.1, np.inf]
    )
    for wrong in (tolerance("d", 0.1), tolerance("a", 0.1, velocity=0.2)):
        with pytest.raises(InvalidRequest, match=r"path_tolerance\[0\]"):
            joint_tolerances("path_tolerance", [wrong], ["a", "b", "c"])
