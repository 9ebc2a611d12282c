# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a step leads, and why one is not taken."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS, THRESHOLDS, robot, unstable_robot

from cpr_core import solve_forward, solve_home, solve_inverse
from cpr_core.model.assessment import MEASURES, Assessment, Threshold
from cpr_ros.following import judged_steps
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.judged_steps import JudgedSteps
from cpr_ros.following.motion_settings import ON_WAY_TO_MOTORS
from cpr_ros.following.supervision import Refusal


@pytest.fixture
def home():
    return solve_home(robot("rfrfr"))


@pytest.fixture
def steps(home):
    return JudgedSteps(home.robot, PERIOD, SETTINGS)


def towards(steps, current, goal, factor=1.0, watched=MEASURES, *, out_of_rest=False):
    return steps.towards(current, goal, factor, watched, 0.0, out_of_rest=out_of_rest)


@pytest.mark.parametrize("factor", [1.0, 0.25])
def test_a_step_towards_motors_is_the_solution_where_it_aims(steps, home, factor):
    current, goal = Assessment(home), MotorGoal(home.robot, home.motors + [0.5, -0.2])
    aim = steps.aim(current, goal, factor, out_of_rest=False)
    ahead = towards(steps, current, goal, factor)
    np.testing.assert_array_equal(ahead.equilibrium.motors, aim)
    assert steps.ticks_between(home.motors, aim) == pytest.approx(factor)
    solved = solve_forward(home.robot, aim, start=home)
    np.testing.assert_allclose(ahead.equilibrium.state, solved.state, rtol=0.0, atol=1e-10)


def test_only_the_first_step_towards_a_pose_is_known_before_it_is_solved(steps, home):
    current = Assessment(home)
    goal = PoseGoal(home.robot, home.pose + [0.02, 0.01])
    assert steps.aim(current, goal, 1.0, out_of_rest=False) is None
    first = steps.aim(current, goal, 1.0, out_of_rest=True)
    ahead = towards(steps, current, goal, out_of_rest=True)
    np.testing.assert_array_equal(ahead.equilibrium.motors, first)
    goal.driven = True  # every tick is to end exactly there
    assert steps.aim(current, goal, 1.0, out_of_rest=True) is None


def test_a_step_towards_a_pose_lies_on_the_straight_way(steps, home):
    current, way = Assessment(home), np.array([0.02, 0.01])
    ahead = towards(steps, current, PoseGoal(home.robot, home.pose + way))
    gone = ahead.equilibrium.pose - home.pose
    part = float(gone @ way) / float(way @ way)
    assert 0.0 < part < 1.0
    np.testing.assert_allclose(gone, part * way, rtol=0.0, atol=1e-9)
    exact = solve_inverse(home.robot, home.pose + part * way, start=home)
    np.testing.assert_allclose(ahead.equilibrium.motors, exact.motors, rtol=0.0, atol=1e-9)


def test_a_measure_refuses_a_step_only_if_it_counts_and_falls(steps, home):
    """Out of where it is too small, every way leads that makes it larger."""
    current = Assessment(home)
    ways = [MotorGoal(home.robot, home.motors + way) for way in ([0.3, 0.0], [-0.3, 0.0])]
    ahead = [towards(steps, current, way) for way in ways]
    measure = "inverse_singularity"
    falling = int(ahead[1].value(measure) < ahead[0].value(measure))
    assert (
        ahead[falling].value(measure) < current.value(measure) < ahead[1 - falling].value(measure)
    )
    stop = Threshold(2.0 * current.value(measure), 1.5 * current.value(measure))
    steps.settings = replace(SETTINGS, thresholds=THRESHOLDS | {measure: stop})
    refused = towards(steps, current, ways[falling])
    assert isinstance(refused, Refusal)
    assert refused.reason == measure
    assert f"is below {measure}_stop" in refused.text
    assert isinstance(towards(steps, current, ways[1 - falling]), Assessment)
    assert isinstance(towards(steps, current, ways[falling], watched=ON_WAY_TO_MOTORS), Assessment)


def test_an_equilibrium_that_is_not_near_is_no_step(steps, home, monkeypatch):
    current, goal = Assessment(home), MotorGoal(home.robot, home.motors + 0.1)
    monkeypatch.setattr(judged_steps, "LARGEST_CHANGE", 1e-6)
    assert towards(steps, current, goal).reason == "branch_jump"


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("way", [-0.01, 0.01])
def test_no_motion_begins_at_an_unstable_home(number, way):
    """No robot is there: measures that get better on the way are those of another equilibrium."""
    home = solve_home(unstable_robot())
    assert home.index_locked == 1
    steps, goal = JudgedSteps(home.robot, PERIOD, SETTINGS), home.motors.copy()
    goal[number] += way
    refusal = towards(steps, Assessment(home), MotorGoal(home.robot, goal))
    assert isinstance(refusal, Refusal)
    assert refusal.reason == "margin" and "unstable with the motors held" in refusal.text
