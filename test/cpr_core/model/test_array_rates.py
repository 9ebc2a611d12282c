# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rates of arrays that a robot has from its relatives are its own; where they are not they are found."""

import numpy as np
import pytest
import yaml
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
from cpr_core.description.description_file import shipped_robots
from cpr_core.model import nearby_robots
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


def robots_built(monkeypatch):
    """Lists that grow with every robot beside another: in several parameters, in one."""
    several, single, shifted = [], [], nearby_robots.shifted_together

    def counted(description, changes):
        (several if len(changes) > 1 else single).append(1)
        return shifted(description, changes)

    monkeypatch.setattr(nearby_robots, "shifted_together", counted)
    return several, single


def test_one_robot_tells_the_rates_of_parameters_of_different_legs(monkeypatch):
    robot = load_robot("six_rfs")
    start = solve_home(robot)
    several, single = robots_built(monkeypatch)
    derivatives(start, APART)
    # All offsets ahead, the modulus ahead, all of them behind.
    assert (len(several), len(single)) == (2, 1)


#: Two sets of different legs, places in several legs, what some legs lack, and what needs two sides.
OF_LEGS = {
    "six_rfs": (
        *(f"legs[{leg}].motor.offset" for leg in (4, 0, 3)),
        *(f"legs[{leg}].base.tangent[1]" for leg in (0, 1, 4)),
        "legs[*].tip.position[2]",
        "legs[2].tip.position[0]",
    ),
    "six_rus": (
        *(f"legs[{leg}].base.position[0]" for leg in (5, 2, 3)),
        *(f"legs[{leg}].chain[1].link[1]" for leg in (0, 2)),
        "legs[1].chain[1].mass",
    ),
    "two_rods": (
        "legs[0].base.position[0]",
        "legs[1].base.position[0]",
        "legs[0].base.position[1]",
    ),
    "delta": tuple(f"legs[{leg}].base.position[{axis}]" for axis in (0, 2) for leg in (2, 0)),
}


@pytest.mark.parametrize("name", OF_LEGS)
def test_rates_asked_together_are_those_asked_one_by_one(name):
    robot = with_loads(load_robot(name))
    paths = OF_LEGS[name]
    found = whole(robot, asked(robot, paths))
    expected = np.zeros_like(found)
    for row, path in enumerate(paths):
        alone = whole(robot, asked(Robot(robot.description), [path]))[0]
        expected[row, : len(alone)] = alone
    size = np.abs(expected).max(axis=1, keepdims=True)
    assert np.all(size > 0.0)
    assert_allclose(found / size, expected / size, rtol=0.0, atol=1e-9)


def test_rods_of_different_legs_carry_loads_of_their_own(monkeypatch):
    """What a rod of its own weighs is in the loads, rod by rod."""
    content = yaml.safe_load(shipped_robots()["six_rfs"].read_text())
    for leg in content["legs"][1:4]:
        leg["rod"] = dict(content["rod"])
    robot = load_robot(content | {"gravity": [0.0, 0.0, -9.81]})
    assert robot.default_loads.gravity[2] == -9.81
    paths = [f"legs[{leg}].rod.density" for leg in (1, 2, 3)]
    several, single = robots_built(monkeypatch)
    found = whole(robot, asked(robot, paths))
    assert (len(several), len(single)) == (2, 0)
    assert np.all(np.abs(found).max(axis=1) > 0.0)
    for row, path in enumerate(paths):
        alone = whole(robot, asked(Robot(robot.description), [path]))[0]
        assert_allclose(found[row, : len(alone)], alone, rtol=1e-9, atol=1e-9 * np.abs(alone).max())


def asked(robot, paths):
    return array_rates(robot, robot.default_loads, named_parameters(robot.description, paths))


def test_nothing_but_one_robot_is_built_where_rates_hold(monkeypatch):
    robot = load_robot("six_rfs")
    start = solve_home(robot)
    derivatives(start, APART)
    together, single = robots_built(monkeypatch)
    robot = robot.with_parameters(other_numbers(robot, APART, 1))
    start = continued(start, robot)
    derivatives(start, APART)
    assert (len(together), len(single)) == (1, 0)
    for force in (1.0, 2.0):  # other loads, and again other ones
        loads = robot.default_loads.with_(wrench_world=[0, 0, 0, force, 0, 0])
        derivatives(solve_forward(robot, start.motors, loads=loads), APART)
        assert (len(together), len(single)) == (1, 0)
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
