# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far limits are, and what is said where one does not hold: of either sign, at either end."""

import numpy as np
import pytest
from helpers.yaml_content import yaml_content

from cpr_core import MotorLimitExceeded, load_robot, solve_home, solve_inverse
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving.limits import check_limits, grazes, margins


def limited(motor, **limits):
    content = yaml_content(shipped_robots()["rfrfr"].read_text())
    content["legs"][motor]["motor"]["limits"] = limits
    return load_robot(content)


def free_effort(motor):
    robot = load_robot("rfrfr")
    return float(solve_home(robot).efforts[motor])


@pytest.mark.parametrize("motor", [0, 1])
def test_an_effort_counts_whatever_its_sign(motor):
    effort = free_effort(motor)
    assert np.sign(effort) == (1 if motor == 0 else -1)
    found = solve_home(limited(motor, effort=1.25 * abs(effort)))
    np.testing.assert_allclose(margins(found), [0.2])
    check_limits(found)


@pytest.mark.parametrize("motor", [0, 1])
def test_an_effort_beyond_its_limit_is_refused_by_name(motor):
    """At (0, 0.8) the motors hold +-0.70 N m, at home +-0.62 N m."""
    robot = limited(motor, effort=0.66)
    with pytest.raises(MotorLimitExceeded, match=f"motor{motor + 1}: effort") as caught:
        solve_inverse(robot, [0.0, 0.8])
    assert abs(caught.value.value) > 0.66
    assert np.sign(caught.value.value) == np.sign(free_effort(motor))
    assert caught.value.limits == (-0.66, 0.66)


@pytest.mark.parametrize("interval", [[2.5, 4.0], [1.0, 2.7]])
def test_the_nearer_end_of_a_range_counts(interval):
    found = solve_home(limited(0, position=interval))
    nearest = min(found.motors[0] - interval[0], interval[1] - found.motors[0])
    np.testing.assert_allclose(margins(found), [nearest])


@pytest.mark.parametrize(
    ("before", "after", "asked"),
    [
        ([0.3], [0.01], True),  # it goes on as fast: beyond the limit and back in one more step
        ([0.01], [0.3], True),
        ([0.3], [0.25], False),
        ([0.3, 0.3], [0.25, 0.01], True),
        ([1e-5], [1e-6], False),  # the step is short enough
        ([], [], False),
    ],
)
def test_a_limit_may_be_passed_within_a_step_that_changes_its_margin_by_as_much(
    before, after, asked
):
    assert grazes(np.array(before), np.array(after)) == asked


@pytest.mark.parametrize(
    ("value", "limits", "words"),
    [
        (1.5000001, (-1.5, 1.5), "position 1.5000001 rad is outside its limits [-1.5, 1.5]"),
        (0.25, (-785.398, -0.0), "position 0.25 rad is outside its limits [-785.398, 0]"),
    ],
)
def test_a_value_beyond_a_limit_is_told_from_it(value, limits, words):
    """In as many digits as it takes; and zero has no sign."""
    error = MotorLimitExceeded("motor1", "position", value, limits, "rad")
    assert f"motor1: {words}" in str(error)
