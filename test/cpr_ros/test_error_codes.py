# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Errors of the node arrive as they were raised, wherever that was."""

import pytest
from cpr_msgs.msg import ErrorCode
from helpers.exceptions import assert_travels, example_of, exceptions_of

import cpr_ros
from cpr_ros.error_codes import RequestError
from cpr_ros.following.trajectory_order import TrajectoryRefused

ARGUMENTS = {
    RequestError: (ErrorCode.NOT_READY, "the node is not active"),
    TrajectoryRefused: (1.5, "margin", "margin of 0.02 after 1.5 s", "margin of 0.02"),
}


@pytest.mark.parametrize("kind", exceptions_of(cpr_ros), ids=lambda kind: kind.__name__)
def test_exceptions_are_pickled_and_copied(kind):
    assert_travels(example_of(kind, ARGUMENTS))
