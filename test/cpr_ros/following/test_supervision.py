# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Statuses, actions and hysteresis."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cpr_msgs.msg import StabilityMetrics
from helpers.drive import THRESHOLDS, robot

from cpr_core import solve_forward, solve_home, solve_inverse
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.assessment import (
    MEASURES,
    Assessment,
    Threshold,
    crossed_thresholds,
    thresholds_problem,
)
from cpr_ros.following.supervision import (
    BLIND,
    FIELDS,
    Action,
    Refusal,
    State,
    Status,
    below_warnings,
    next_action,
    slowed_where_unseen,
    verdict,
)
from cpr_ros.settings.parameter_table import PARAMETERS


def at(y):
    return Assessment(solve_inverse(robot("rfrfr"), [0.0, y]))


def judged(y, previous=Action.NONE, **given):
    return verdict(at(y), THRESHOLDS, MEASURES, previous=previous, hysteresis=0.1, **given)


@pytest.mark.parametrize("numbers", [Status, Action, State])
def test_numbers_are_those_of_the_message(numbers):
    text = Path(__file__).parents[3].joinpath("msg_defs/msg/StabilityMetrics.msg").read_text()
    prefix = numbers.__name__.upper()
    constants = {
        name: int(value)
        for name, value in re.findall(rf"^u?int8 {prefix}_(\w+)=(-?\d+)", text, re.M)
    }
    assert constants == {member.name: int(member) for member in numbers}


def test_speed_scale_falls_linearly_between_the_thresholds():
    for y in (0.8, 0.15, 0.1, 0.07, 0.05):
        told = judged(y)
        expected = np.clip((at(y).margin - 0.05) / 0.15, 0.0, 1.0)
        assert told.speed_scale == pytest.approx(expected)
        assert told.nearest == "margin"
    assert judged(0.8).status == Status.NO_WARNING
    assert judged(0.1).status == Status.DECELERATE_FOR_STABILITY
    assert judged(0.04).status == Status.HALT_FOR_STABILITY
    assert [judged(y).action for y in (0.8, 0.1, 0.04)] == [Action.NONE, Action.SLOW, Action.HALT]


def test_the_action_does_not_chatter():
    """A measure that trembles about a threshold changes the action once, not at every tremble."""
    rng = np.random.default_rng(1)
    for threshold, settled in ((0.0, Action.HALT), (1.0, Action.SLOW)):
        action, changes = Action.NONE, 0
        for distance in threshold + 0.04 * rng.standard_normal(2000).clip(-2, 2):
            after = next_action(action, distance, False, hysteresis=0.1)
            changes += after != action
            action = after
        assert 1 <= changes <= 2
        assert action == settled


def test_an_action_is_taken_at_once_and_given_up_beyond_the_hysteresis():
    assert next_action(Action.NONE, -0.01, False, 0.1) == Action.HALT
    assert next_action(Action.HALT, 0.05, False, 0.1) == Action.HALT
    assert next_action(Action.HALT, 0.15, False, 0.1) == Action.SLOW
    assert next_action(Action.SLOW, 1.05, False, 0.1) == Action.SLOW
    assert next_action(Action.SLOW, 1.15, False, 0.1) == Action.NONE
    assert next_action(Action.HALT, 5.0, False, 0.1) == Action.NONE
    assert next_action(Action.NONE, 5.0, True, 0.1) == Action.HALT
    assert next_action(Action.NONE, float("nan"), False, 0.1) == Action.HALT


def test_a_halt_has_scale_zero_until_it_is_given_up():
    told = judged(0.05, previous=Action.HALT)  # just above the stop threshold
    assert 0.0 < told.distance < 0.1
    assert (told.action, told.speed_scale) == (Action.HALT, 0.0)
    assert told.status == Status.HALT_FOR_STABILITY


@pytest.mark.parametrize(
    ("reason", "status"),
    [
        ("margin", Status.HALT_FOR_STABILITY),
        ("forward_singularity", Status.HALT_FOR_SINGULARITY),
        ("inverse_singularity", Status.HALT_FOR_SINGULARITY),
        ("motor_range", Status.JOINT_BOUND),
        ("effort_reserve", Status.JOINT_BOUND),
        ("strain_reserve", Status.STRAIN_BOUND),
        ("not_converged", Status.NOT_CONVERGED),
        ("branch_jump", Status.BRANCH_JUMP),
    ],
)
def test_a_refusal_is_a_halt_with_its_own_status(reason, status):
    told = judged(0.8, refusal=Refusal(reason, "because"))
    assert (told.status, told.text, told.action) == (status, "because", Action.HALT)
    assert told.speed_scale == 0.0


def test_every_measure_has_a_status():
    statuses = {judged(0.8, refusal=Refusal(measure, "because")).status for measure in MEASURES}
    assert statuses == {
        Status.HALT_FOR_STABILITY,
        Status.HALT_FOR_SINGULARITY,
        Status.JOINT_BOUND,
        Status.STRAIN_BOUND,
    }


def test_a_value_and_its_threshold_are_told_apart():
    """They were said to be 0.05 and 0.05."""
    assessment = at(0.05)
    near = THRESHOLDS | {"margin": Threshold(0.9, assessment.margin - 1e-9)}
    told = verdict(assessment, near, MEASURES, previous=Action.HALT, hysteresis=0.1)
    value, limit = re.fullmatch(
        r"margin (\S+) is above margin_stop (\S+) by less than the hysteresis", told.text
    ).groups()
    assert float(value) > float(limit)
    near = THRESHOLDS | {"margin": Threshold(0.9, assessment.margin + 1e-9)}
    told = verdict(assessment, near, MEASURES, previous=Action.NONE, hysteresis=0.1)
    value, limit = re.fullmatch(r"margin (\S+) is below margin_stop (\S+)", told.text).groups()
    assert float(value) < float(limit)


def test_a_warning_just_below_its_stop_is_told_apart_from_it():
    """It was said that 0.3 is not above 0.3."""
    (line,) = crossed_thresholds(THRESHOLDS | {"margin": Threshold(0.29999999, 0.3)})
    assert "margin_warning 0.29999999 is not above margin_stop 0.3:" in line


def test_measures_are_named_as_in_the_message_and_thresholds_as_the_parameters():
    message = StabilityMetrics()
    for measure, path in FIELDS.items():
        value = message
        for field in path.split("."):
            value = getattr(value, field)
        assert f"{measure}_stop" in {parameter.name for parameter in PARAMETERS}


def test_a_stale_setpoint_does_not_hide_a_halt():
    assert judged(0.8, stale=True).status == Status.STALE_COMMAND
    assert judged(0.04, stale=True).status == Status.HALT_FOR_STABILITY


def test_leaving_a_singularity_has_its_own_status():
    thresholds = THRESHOLDS | {"inverse_singularity": Threshold(1.0, 1e-3)}
    given = {"previous": Action.NONE, "hysteresis": 0.1}
    approaching = verdict(at(0.8), thresholds, MEASURES, **given)
    leaving = verdict(at(0.8), thresholds, MEASURES, worsening=["margin"], **given)
    assert approaching.status == Status.DECELERATE_FOR_APPROACHING_SINGULARITY
    assert leaving.status == Status.DECELERATE_FOR_LEAVING_SINGULARITY
    assert leaving.text.startswith(
        "inverse.smallest_singular_value 0.06544 is below inverse_singularity_warning 1"
    )


def test_what_is_below_its_warning_where_a_robot_begins_is_told_with_what_follows():
    """A robot whose every platform setpoint was halted said nothing before."""
    where, read = at(0.8), "; docs/node.md, Thresholds, tells how to choose them"
    tight = {"margin": Threshold(1.0, 0.9), "inverse_singularity": Threshold(0.2, 0.1)}
    slow, halt = below_warnings(where, THRESHOLDS | tight)
    assert slow == (
        f"margin {where.margin:.4g} is below margin_warning 1 here: motions that make it smaller are "
        f"slowed down, and action is SLOW{read}"
    )
    assert halt == (
        "inverse.smallest_singular_value 0.06544 is below inverse_singularity_stop 0.1 here: platform "
        f"setpoints that make it smaller are halted, and action is HALT with every one{read}"
    )
    (told,) = below_warnings(where, THRESHOLDS | tight, tracked=True)
    assert told == f"margin {where.margin:.4g} is below margin_warning 1 here: action is SLOW{read}"
    at_stop = THRESHOLDS | {"margin": Threshold(where.margin, where.margin)}
    (crossed,) = below_warnings(where, at_stop)
    assert f"is at margin_stop {where.margin:.4g} here" in crossed
    assert "are halted" in crossed


@pytest.mark.parametrize("name", shipped_robots())
def test_nothing_is_below_its_warning_at_the_home_of_a_shipped_robot(name):
    assert below_warnings(Assessment(solve_home(robot(name))), THRESHOLDS) == []


def test_under_a_load_without_potential_nothing_is_called_stable():
    home = solve_home(robot("three_rfr_hubs"))
    loads = home.loads.with_(wrench_body=[0, 0, 0, 0.01, 0, 0])
    loaded = Assessment(solve_forward(home.robot, home.motors, loads=loads))
    told = verdict(loaded, THRESHOLDS, MEASURES, previous=Action.NONE, hysteresis=0.1)
    assert told.status == Status.INVALID
    assert "non-conservative" in told.text


def test_thresholds_that_make_no_sense_are_named():
    assert thresholds_problem(THRESHOLDS, MEASURES) == ""
    crossed = THRESHOLDS | {"motor_range": Threshold(0.1, 0.1)}
    assert "motor_range_stop below motor_range_warning" in thresholds_problem(crossed, MEASURES)
    assert "finite" in thresholds_problem(THRESHOLDS | {"margin": Threshold(np.nan, 0.1)}, [])


@pytest.mark.parametrize("warning", [0.3, 0.1])
def test_a_warning_that_is_not_above_its_stop_leaves_the_stop_as_it_is(warning):
    """Thresholds of a file come one by one; whatever their order, a stop halts."""
    threshold = Threshold(warning, 0.3)
    thresholds = THRESHOLDS | {"margin": threshold}
    assert thresholds_problem(thresholds, []) == ""
    (line,) = crossed_thresholds(thresholds)
    assert f"margin_warning {warning:g} is not above margin_stop 0.3" in line
    assert threshold.level(0.3) == 0.0
    assert threshold.level(0.2999) < 0.0
    assert threshold.level(0.3001) > 1.0
    assert np.isnan(threshold.level(np.nan))
    assert threshold.level(np.inf) == np.inf


def test_a_warning_does_not_hide_that_the_robot_is_not_seen():
    """The speed scale stayed that of the warning, and nobody was told."""
    told, why = judged(0.1), "the measured motors are older than measured_timeout 0.5 s"
    assert told.action == Action.SLOW
    for scale in (0.93, 0.1):
        blind = slowed_where_unseen(replace(told, speed_scale=scale), why)
        assert blind.speed_scale == min(scale, BLIND)
        assert blind.text == f"{told.text}; {why}"
        assert (blind.action, blind.status) == (told.action, told.status)
    assert slowed_where_unseen(told, "") is told


def test_a_halt_stays_what_it_is_where_the_robot_is_not_seen():
    told = judged(0.75, refusal=Refusal("margin", "the next equilibrium is unstable"))
    assert told.action == Action.HALT
    assert slowed_where_unseen(told, "the measured motors are too old") is told
