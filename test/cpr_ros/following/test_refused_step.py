# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a refused step is remembered for."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import SETTINGS, robot

from cpr_core import solve_home
from cpr_core.model.assessment import Assessment
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.refused_step import RefusedStep, Step
from cpr_ros.following.steps import Undecided
from cpr_ros.following.supervision import Refusal

REFUSAL = Refusal("margin", "the next equilibrium is unstable with the motors held")


@pytest.fixture
def step():
    home = solve_home(robot("rfrfr"))
    goal = PoseGoal(home.robot, home.pose)
    return Step(Assessment(home), home.loads, goal.destination, 0.25, SETTINGS)


def test_the_same_step_is_refused_again_for_the_same_reason(step):
    refused = RefusedStep()
    assert refused.again(step, 0.0) is None
    refused.take(step, REFUSAL, 0.0, took=0.1)
    same = PoseGoal(step.current.equilibrium.robot, step.current.equilibrium.pose)
    assert refused.again(step._replace(destination=same.destination), 1e9) is REFUSAL


def test_another_one_is_not(step):
    refused = RefusedStep()
    refused.take(step, REFUSAL, 0.0, took=0.1)
    home = step.current.equilibrium
    elsewhere = PoseGoal(home.robot, home.pose + 1e-12)
    motors = MotorGoal(home.robot, home.pose)
    for other in (
        step._replace(current=Assessment(home)),
        step._replace(destination=elsewhere.destination),
        step._replace(destination=motors.destination),
        step._replace(loads=home.loads.with_()),
        step._replace(factor=0.5),
        step._replace(settings=replace(SETTINGS)),
        step._replace(watched=("margin",)),
    ):
        assert refused.again(other, 0.0) is None
    assert refused.again(step, 0.0) is REFUSAL


def test_what_has_no_destination_is_never_the_same(step):
    refused, moving = RefusedStep(), step._replace(destination=None)
    refused.take(moving, REFUSAL, 0.0, took=0.1)
    assert refused.again(moving, 0.0) is None


def test_what_was_not_decided_is_asked_for_again_after_ten_times_as_long(step):
    refused, refusal = (
        RefusedStep(),
        Undecided("not_converged", "no equilibrium is found within 0.1 s"),
    )
    refused.take(step, refusal, 5.0, took=0.1)
    assert refused.again(step, 5.0) is refusal
    assert refused.again(step, 5.99) is refusal
    assert refused.again(step, 6.01) is None


def test_goals_that_ask_for_the_same_have_the_same_destination():
    home = solve_home(robot("rfrfr"))
    asked, others = np.array([2.0, 0.5]), np.array([2.0, 0.6])
    for kind in (MotorGoal, PoseGoal):
        assert kind(home.robot, asked).destination == kind(home.robot, asked.copy()).destination
        assert kind(home.robot, asked).destination != kind(home.robot, others).destination
    assert MotorGoal(home.robot, asked).destination != PoseGoal(home.robot, asked).destination
    goal = PoseGoal(home.robot, asked)
    assert goal.at(others).destination == PoseGoal(home.robot, others).destination
