# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rates of arrays that a robot has from its relatives are its own; where they are not they are found."""

import numpy as np
import pytest
from helpers.parameter_kinds import parameter_kinds, with_loads
from helpers.shipped_steps import STEPS
from numpy.testing import assert_allclose

from cpr_core import (
    CprError,
    Robot,
    continued,
    derivatives,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.changed_description import named_parameters
from cpr_core.model import array_rates as module
from cpr_core.model.array_rates import array_rates

#: Alone in what they change, together in it, and no straight way at all.
APART = ("rod.young_modulus", *(f"legs[{leg}].motor.offset" for leg in range(6)))
TOGETHER = ("rod.young_modulus", "rod.length", "rod.section.radius", "legs[0].tip.position[1]")
BENT = ("legs[1].base.tangent[1]", "rod.section.radius", "gravity[2]", "platform.mass")


def other_numbers(robot, paths, seed):
    values, random = robot.parameter_values(paths), np.random.default_rng(seed)
    change = 0.02 * random.uniform(0.5, 1.0, len(paths))
    numbers = np.where(values == 0.0, change, values * (1.0 + change))
    return dict(zip(paths, numbers.tolist(), strict=True))


def whole(robot, rates):
    """Rates with all that does not change, one row a parameter."""
    count = 1 + max(own.places.max(initial=0) for own in rates)
    rows = np.zeros((len(rates), count))
    for row, own in zip(rows, rates, strict=True):
        row[own.places] = own.rates
    return rows


@pytest.mark.parametrize("paths", [APART, TOGETHER, BENT])
@pytest.mark.parametrize("changed", [APART[:2], TOGETHER[1:3], BENT[:1]])
def test_rates_of_a_changed_robot_are_those_it_finds_alone(paths, changed):
    """Whatever has changed: what is asked for, something else, or both."""
    robot = with_loads(load_robot("six_rfs"))
    array_rates(robot, robot.default_loads, named_parameters(robot.description, paths))
    for seed in range(2):
        relative = robot.with_parameters(other_numbers(robot, changed, seed))
        parameters = named_parameters(relative.description, paths)
        alone = Robot(relative.description)
        found = whole(relative, array_rates(relative, relative.default_loads, parameters))
        expected = whole(alone, array_rates(alone, alone.default_loads, parameters))
        size = np.abs(expected).max(axis=1, keepdims=True)
        assert_allclose(found / size, expected / size, rtol=0.0, atol=1e-9)


def test_nothing_but_one_robot_is_built_where_rates_hold(monkeypatch):
    robot = load_robot("six_rfs")
    start = solve_home(robot)
    derivatives(start, APART)
    single, together = [], []
    one, several = module.shifted, module.shifted_together
    monkeypatch.setattr(module, "shifted", lambda *all: (single.append(1), one(*all))[1])
    monkeypatch.setattr(
        module, "shifted_together", lambda *all: (together.append(1), several(*all))[1]
    )
    robot = robot.with_parameters(other_numbers(robot, APART, 1))
    start = continued(start, robot)
    derivatives(start, APART)
    assert (len(single), len(together)) == (0, 1)
    for force in (1.0, 2.0):  # other loads, and again other ones, which change alike
        loads = robot.default_loads.with_(wrench_world=[0, 0, 0, force, 0, 0])
        derivatives(solve_forward(robot, start.motors, loads=loads), APART)
        assert (len(single), len(together)) == (0, 2)
    derivatives(start, TOGETHER)
    assert len(single) >= len(TOGETHER) - 1


@pytest.mark.parametrize("name", ["six_rus", "three_prs", "two_rods"])
def test_derivatives_on_relatives_are_those_of_robots_without_any(name):
    """Also one parameter after the other, so that each is tried with others than before."""
    robot = with_loads(load_robot(name))
    start = solve_forward(robot, solve_home(robot).motors + np.array(STEPS[name]))
    paths = []
    for path in parameter_kinds(robot)[::3]:
        try:
            derivatives(start, path)
        except CprError as error:
            assert "planar" in str(error), path
            continue
        paths.append(path)
    relative = robot.with_parameters({"rod.length": 1.01 * robot.parameter_values("rod.length")[0]})
    moved = continued(start, relative)
    alone = continued(start, Robot(relative.description))
    for asked in (paths[:2], paths[1:]):
        mine, theirs = derivatives(moved, asked), derivatives(alone, asked)
        for quantity in ("position", "efforts"):
            expected = getattr(theirs, quantity)
            size = 1e-300 + np.abs(expected).max(axis=0)
            away = np.abs(getattr(mine, quantity) - expected) / size
            assert away.max() < 1e-6, (quantity, asked[int(away.max(axis=0).argmax())])
