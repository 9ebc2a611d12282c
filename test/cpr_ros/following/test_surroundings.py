# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What may happen within a step of all motors is told by what each does alone."""

import math

import numpy as np
import pytest
from helpers.drive import PERIOD, THRESHOLDS, changed_robot, robot
from helpers.shipped_steps import STEPS

from cpr_core import solve_forward, solve_home
from cpr_core.model.assessment import MEASURES, Assessment, Threshold
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.judged_steps import LARGEST_CHANGE
from cpr_ros.following.motor_ways import motor_steps
from cpr_ros.following.steps import attempt
from cpr_ros.following.supervision import Refusal
from cpr_ros.following.surroundings import Surroundings

NOTHING = {name: Threshold(-math.inf, -math.inf) for name in MEASURES}


def looked_around(current, steps):
    """And how many looks it took."""
    around, looks = Surroundings(current, steps), 0
    while not around.known:
        assert not around.free(
            NOTHING, math.inf, MEASURES
        )  # nothing is sure before everything is known
        around.look()
        looks += 1
    return around, looks


def lowest(around, name):
    """Warning up to which a measure is sure not to fall."""
    value = around.current.value(name)
    if math.isinf(value):
        return value
    low, high = value - 10.0 * abs(value) - 10.0, value
    for _ in range(60):
        middle = 0.5 * (low + high)
        free = around.free(NOTHING | {name: Threshold(middle, -math.inf)}, math.inf, MEASURES)
        low, high = (middle, high) if free else (low, middle)
    return low


@pytest.mark.parametrize("name", sorted(STEPS))
def test_no_measure_falls_further_however_the_motors_step(name):
    loaded = robot(name)
    random = np.random.default_rng(7)
    home = solve_home(loaded)
    for way in (0.0, 1.0):
        found = solve_forward(loaded, home.motors + way * np.array(STEPS[name]))
        current = Assessment(found)
        steps = motor_steps(loaded, 1.0, PERIOD)
        around, looks = looked_around(current, steps)
        assert looks == 2 * len(steps)
        assert around.free(NOTHING, math.inf, MEASURES)
        least = {measure: lowest(around, measure) for measure in MEASURES}
        for _ in range(8):
            step = steps * random.choice([-1.0, 1.0, *random.uniform(-1.0, 1.0, 2)], len(steps))
            goal = MotorGoal(loaded, found.motors + step)
            ahead = attempt(current, goal, 1.0, found.loads)
            assert not isinstance(ahead, Refusal)
            assert ahead.index == current.index
            for measure in MEASURES:
                assert ahead.value(measure) >= least[measure] - 1e-12, measure


def test_a_measure_near_its_warning_leaves_no_step_free():
    loaded = robot("rfrfr")
    current = Assessment(solve_home(loaded))
    around, _ = looked_around(current, motor_steps(loaded, 1.0, PERIOD))
    assert around.free(THRESHOLDS, LARGEST_CHANGE, MEASURES)
    for name in MEASURES:
        value = current.value(name)
        if math.isfinite(value):
            near = Threshold(value - 1e-9, -math.inf)
            assert not around.free(THRESHOLDS | {name: near}, LARGEST_CHANGE, MEASURES), name
            crossed = Threshold(-math.inf, value - 1e-9)
            assert not around.free(THRESHOLDS | {name: crossed}, LARGEST_CHANGE, MEASURES), name
    assert not around.free(THRESHOLDS, 1e-6, MEASURES)


def test_a_motor_at_its_limit_goes_no_further():
    """A setpoint beyond it is taken for the limit, too."""
    motors = solve_home(robot("rfrfr")).motors
    upper = float(motors[0]) + 1e-4

    def limited(content):
        content["legs"][0]["motor"]["limits"] = {"position": [-10.0, upper]}

    loaded = changed_robot("rfrfr", limited)
    current = Assessment(solve_home(loaded))
    around, _ = looked_around(current, motor_steps(loaded, 1.0, PERIOD))
    assert around.free(NOTHING, LARGEST_CHANGE, MEASURES)
    assert not around.free(THRESHOLDS, LARGEST_CHANGE, MEASURES)


def test_where_a_place_nearby_cannot_be_borne_no_step_is_free():
    effort = float(np.abs(solve_home(robot("rfrfr")).efforts).max())

    def limited(content):
        for leg in content["legs"]:
            leg["motor"]["limits"] = {"effort": effort * (1.0 + 1e-5)}

    loaded = changed_robot("rfrfr", limited)
    current = Assessment(solve_home(loaded))
    around, looks = looked_around(current, motor_steps(loaded, 1.0, PERIOD))
    assert looks < 4  # what is known already is enough
    assert not around.free(NOTHING, math.inf, MEASURES)


def test_a_measure_that_is_not_defined_nearby_leaves_no_step_free(monkeypatch):
    loaded = robot("rfrfr")
    current = Assessment(solve_home(loaded))
    defined = Assessment.value

    def undefined(assessment, measure):
        return defined(assessment, measure) if assessment is current else math.nan

    monkeypatch.setattr(Assessment, "value", undefined)
    around, _ = looked_around(current, motor_steps(loaded, 1.0, PERIOD))
    assert not around.free(NOTHING, math.inf, MEASURES)


def test_where_measures_cannot_be_had_no_step_is_free(monkeypatch):
    loaded = robot("rfrfr")
    current = Assessment(solve_home(loaded))
    assert all(current.value(name) is not None for name in MEASURES)  # known here

    def failing(assessment):
        raise ArithmeticError("for a test")

    monkeypatch.setattr(Assessment, "forward_singularity", property(failing))
    around, looks = looked_around(current, motor_steps(loaded, 1.0, PERIOD))
    assert looks == 1
    assert not around.free(NOTHING, math.inf, MEASURES)
