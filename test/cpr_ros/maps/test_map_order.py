# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What travels between the node and the process of a map means the same there."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.map_orders import small_order

from cpr_core import (
    InvalidQuaternion,
    InvalidRequest,
    NoInverseSolution,
    NonFiniteInput,
    TimeLimitExceeded,
    solve_forward,
)
from cpr_ros.error_codes import code_of
from cpr_ros.maps.map_order import MapFailure


def test_an_order_arrives_as_it_was_given():
    order = small_order(Path("/maps/map.nc"), resume=True)
    pushed = order.loads.with_(wrench_world=[0, 0, 0, 0.1, -0.2, 0])
    start = solve_forward(order.start.robot, [2.7, 0.4], loads=pushed)
    order = small_order(order.file, start=start, loads=pushed, objective="least_effort")
    other = pickle.loads(pickle.dumps(order))
    assert other.start.robot.description.text == start.robot.description.text
    np.testing.assert_array_equal(other.start.state, start.state)
    np.testing.assert_array_equal(other.loads.wrench_world, pushed.wrench_world)
    for name in ("tolerance", "threshold", "workers", "file", "resume", "objective"):
        assert getattr(other, name) == getattr(order, name), name
    assert other.grid.axis_names == order.grid.axis_names
    for mine, theirs in zip(order.grid.values, other.grid.values, strict=True):
        np.testing.assert_array_equal(theirs, mine)


@pytest.mark.parametrize(
    ("kind", "argument", "code"),
    [
        (InvalidRequest, "file", ErrorCode.INVALID_FILE),
        (InvalidRequest, "grid", ErrorCode.INVALID_ROBOT_STATE),
        (NonFiniteInput, "threshold", ErrorCode.NON_FINITE_INPUT),
        (InvalidQuaternion, "", ErrorCode.INVALID_QUATERNION),
        (NoInverseSolution, "", ErrorCode.NO_IK_SOLUTION),
        (TimeLimitExceeded, "", ErrorCode.TIMED_OUT),
        (ZeroDivisionError, "", ErrorCode.FAILURE),
    ],
)
def test_a_failure_elsewhere_has_the_code_it_would_have_had_in_the_node(kind, argument, code):
    failure = pickle.loads(pickle.dumps(MapFailure(kind, "as it was told", argument)))
    found = code_of(failure.kind, failure.message, failure.argument)
    assert found.val == code
    assert found.message.endswith("as it was told")
