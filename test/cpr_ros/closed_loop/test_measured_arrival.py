# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When the measured platform is where a goal wants it."""

import math

import pytest
from cpr_msgs.action import MoveTo
from helpers.drive import robot
from hypothesis import given
from hypothesis import strategies as st

from cpr_core import InvalidRequest
from cpr_ros.closed_loop.loop_status import Loop, LoopStatus
from cpr_ros.closed_loop.measured_arrival import MeasuredArrival, measured_arrival
from cpr_ros.following.pose_coordinates import PoseCoordinates

THERE = LoopStatus(Loop.CLOSED, "", 0.01, 1e-4, 2e-3, at_setpoint=True)
SIZES = st.floats(0.0, 1.0)


def arrival(name, given=MoveTo.Goal.GIVEN_POSE, **tolerances):
    goal = MoveTo.Goal(given=given, **tolerances)
    return measured_arrival(goal, PoseCoordinates(robot(name)))


@given(SIZES, SIZES, SIZES, SIZES)
def test_both_errors_have_to_be_within_what_is_asked_for(position, rotation, distance, angle):
    wanted = MeasuredArrival(position, rotation)
    measured = THERE._replace(position_error=distance, rotation_error=angle)
    expected = (position == 0.0 or distance <= position) and (rotation == 0.0 or angle <= rotation)
    assert wanted.met(measured) == expected
    assert not wanted.hindrance(measured)


@pytest.mark.parametrize(
    ("changed", "hindrance"),
    [
        ({"loop": Loop.FROZEN, "text": "loop_gain is 0"}, "loop_gain is 0"),
        ({"loop": Loop.OPEN}, "no measured pose has come"),
        ({"at_setpoint": False}, ""),  # it was measured on its way: another picture tells
        ({"position_error": math.nan}, ""),
    ],
)
def test_what_is_not_measured_at_rest_is_not_there(changed, hindrance):
    measured = THERE._replace(**changed)
    assert not MeasuredArrival(1e-3, 0.0).met(measured)
    assert MeasuredArrival(1e-3, 0.0).hindrance(measured) == hindrance
    assert MeasuredArrival(0.0, 0.0).met(measured)
    assert not MeasuredArrival(0.0, 0.0).hindrance(measured)


def test_tolerances_are_those_of_the_goal():
    wanted = arrival("six_rfs", position_tolerance=1e-3, rotation_tolerance=0.01)
    assert wanted == MeasuredArrival(1e-3, 0.01)
    assert arrival("rfrfr", MoveTo.Goal.GIVEN_MOTORS) == MeasuredArrival(0.0, 0.0)


@pytest.mark.parametrize(
    ("name", "goal", "words"),
    [
        ("rfrfr", {"position_tolerance": -1e-3}, "position_tolerance: expected a positive number"),
        ("rfrfr", {"rotation_tolerance": math.inf}, "rotation_tolerance: expected a finite number"),
        ("rfrfr", {"rotation_tolerance": 0.1}, "does not control the rotation"),
        (
            "rfrfr",
            {"given": MoveTo.Goal.GIVEN_MOTORS, "position_tolerance": 1e-3},
            "expected 0 with motors",
        ),
    ],
)
def test_tolerances_of_what_a_goal_does_not_control_are_refused(name, goal, words):
    with pytest.raises(InvalidRequest, match=words):
        arrival(name, **goal)
