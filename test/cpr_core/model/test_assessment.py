# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measures of an equilibrium."""

from typing import get_args

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import load_robot, solve_home
from cpr_core.model.assessment import DEFAULT_THRESHOLDS, MEASURES, Assessment
from cpr_core.solving.events import EventKind


@pytest.mark.parametrize("leg", [0, 1])
def test_a_motor_is_loaded_whichever_way_it_pushes(leg):
    """Both legs of the symmetric robot are bent as much, by one motor forwards and one backwards."""
    content = shipped_content("rfrfr")
    efforts = solve_home(load_robot(content)).efforts
    assert np.sign(efforts).tolist() == [1.0, -1.0]
    limits = {"effort": abs(float(efforts[leg])) / 0.9}
    content["legs"][leg]["motor"] = content["legs"][leg]["motor"] | {"limits": limits}
    reserve = Assessment(solve_home(load_robot(content))).effort_reserve
    assert reserve == pytest.approx(0.1, rel=1e-9)
    assert reserve < DEFAULT_THRESHOLDS["effort_reserve"].warning


@pytest.mark.parametrize(
    ("limits", "reserves"),
    [
        ({"position": [-9.0, 9.0]}, (False, True)),
        ({"effort": 50.0}, (True, False)),
        ({}, (True, True)),
    ],
)
def test_what_has_no_limit_is_infinitely_far_from_it(limits, reserves):
    """Motors with limits of position only had a reserve of effort of 1, which a verdict named."""
    content = shipped_content("rfrfr")
    for leg in content["legs"]:
        leg["motor"]["limits"] = limits
    found = Assessment(solve_home(load_robot(content)))
    infinite = (found.motor_range == np.inf, found.effort_reserve == np.inf)
    assert infinite == reserves


def test_events_of_measures_are_those_of_paths_each_of_one_measure():
    events = [measure.event for measure in MEASURES.values() if measure.event]
    assert set(events) <= set(get_args(EventKind))
    assert len(set(events)) == len(events)


def test_ranges_of_motors_count_in_rod_lengths_where_they_shift():
    home = solve_home(load_robot("gough_stewart"))
    lower, upper = np.transpose(
        [(motor.limits.lower, motor.limits.upper) for motor in home.robot.description.motors]
    )
    left = np.minimum(home.motors - lower, upper - home.motors).min()
    assert Assessment(home).motor_range == pytest.approx(left / home.robot.mean_length)
    assert home.robot.mean_length == pytest.approx(0.45)
