# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Live parameters that cannot be used."""

import math
import re
from dataclasses import astuple

import pytest
from helpers.closed_loop import live

from cpr_ros.settings.node_settings import live_parameters, live_problem
from cpr_ros.settings.parameter_table import PARAMETERS

NUMBERS = [each.name for each in PARAMETERS if each.live and isinstance(each.default, float)]


@pytest.mark.parametrize("name", NUMBERS)
def test_one_that_is_no_number_is_named_as_it_was_set(name):
    """`loop_gain` was called `gain`, and `measured_pose_jump` `jump`."""
    assert live_problem(live()) == ""
    assert re.search(rf"\b{name}\b", live_problem(live(**{name: math.nan})))


def test_every_value_is_that_of_its_own_parameter():
    """None is in another's place: all are told apart by a number of their own."""
    numbered = {name: 1000.0 + place for place, name in enumerate(NUMBERS)}
    found = live_parameters(numbered.__getitem__)
    parts = {**vars(found), **vars(found.settings)}
    for name in ("wrench_timeout", "max_lead", "twist_timeout", "hysteresis", "setpoint_timeout"):
        assert parts[name] == numbered[name]
    assert found.loop.gain == numbered["loop_gain"]
    assert found.felt_wrench.max_speed == numbered["wrench_max_speed"]
    assert found.settings.thresholds["margin"].stop == numbered["margin_stop"]
    values = [
        value
        for part in (found, found.settings, found.loop, found.felt_wrench)
        for value in vars(part).values()
        if isinstance(value, float)
    ]
    values += [level for each in found.settings.thresholds.values() for level in astuple(each)]
    assert set(values) == set(numbered.values())
