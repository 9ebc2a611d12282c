# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What motors can do, as descriptions say it: limits that make no sense are refused by name."""

import pytest
from helpers.yaml_content import yaml_content

from cpr_core import DescriptionError, load_robot
from cpr_core.description.description_file import shipped_robots


def with_limits(name, limits):
    content = yaml_content(shipped_robots()[name].read_text())
    content["legs"][1]["motor"]["limits"] = limits
    return load_robot(content)


@pytest.mark.parametrize(
    ("name", "position", "problem"),
    [
        ("gough_stewart", [-0.1, 1.0], "expected a positive length, got -0.1"),
        ("gough_stewart", [0.0, 1.0], "expected a positive length, got 0"),
        ("rfrfr", [1.0, 1.0], "expected lower below upper"),
        ("rfrfr", [1.0, -1.0], "expected lower below upper"),
    ],
)
def test_position_limits_that_make_no_sense_are_refused(name, position, problem):
    with pytest.raises(DescriptionError, match=problem) as caught:
        with_limits(name, {"position": position})
    assert "legs[1].motor.limits.position" in str(caught.value)


def test_limits_are_those_of_the_motor_they_are_given_for():
    robot = with_limits("rfrfr", {"position": [-1.5, 2.5], "effort": 3.0, "speed": 0.5})
    first, second = (leg.limits for leg in robot.description.legs)
    assert (first.lower, first.upper, first.effort, first.speed) == (
        -float("inf"), float("inf"), float("inf"), float("inf")
    )  # fmt: skip
    assert (second.lower, second.upper, second.effort, second.speed) == (-1.5, 2.5, 3.0, 0.5)


def test_a_lower_limit_below_zero_is_fine_where_it_is_no_length():
    assert with_limits("rfrfr", {"position": [-1.0, 1.0]}).description.legs[1].limits.lower == -1.0
