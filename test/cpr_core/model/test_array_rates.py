# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rates of arrays that one robot tells of several parameters are those of each; none is built twice."""

import numpy as np
import pytest
import yaml
from helpers.parameter_kinds import with_loads
from numpy.testing import assert_allclose

from cpr_core import (
    DescriptionError,
    Robot,
    derivatives,
    load_robot,
    solve_home,
)
from cpr_core.description.changed_description import named_parameters
from cpr_core.description.description_file import shipped_robots
from cpr_core.model import nearby_robots
from cpr_core.model.array_rates import array_rates

#: Alone in what they change, together in it, and no straight way at all.
APART = ("rod.young_modulus", *(f"legs[{leg}].motor.offset" for leg in range(6)))
TOGETHER = ("rod.young_modulus", "rod.length", "rod.section.radius", "legs[0].tip.position[1]")
BENT = ("legs[1].base.tangent[1]", "rod.section.radius")


def whole(robot, rates):
    """Rates with all that does not change, one row a parameter."""
    count = 1 + max(own.places.max(initial=0) for own in rates)
    rows = np.zeros((len(rates), count))
    for row, own in zip(rows, rates, strict=True):
        row[own.places] = own.rates
    return rows


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


@pytest.mark.parametrize("paths", [APART, TOGETHER, BENT])
def test_no_robots_are_built_again_for_other_loads(monkeypatch, paths):
    robot = with_loads(load_robot("six_rfs"))
    asked(robot, paths)
    built = robots_built(monkeypatch)
    own = robot.default_loads
    for loads in (own.with_(rod_force=[0, 0, 1.0]), own.with_(wrench_body=[0, 0, 0, 1.0, 0, 0])):
        array_rates(robot, loads, named_parameters(robot.description, paths))
    assert built == ([], [])


@pytest.mark.parametrize(("refused", "sides"), [(None, {-1, 1}), (1, {-1}), (-1, {1})])
def test_where_there_are_robots_on_one_side_only_they_tell_a_rate(refused, sides):
    """Of what is no straight line of the number: its square."""
    robot = load_robot("rfrfr")
    (parameter,) = named_parameters(robot.description, "rod.length")

    def beside(robot, changes):
        ((_, change),) = changes
        if np.sign(change) == refused:
            raise DescriptionError("rfrfr", "rod.length", "none there")
        return robot

    near = nearby_robots.nearby(robot, parameter, nearby_robots.CENTRAL, 0.01, beside)
    assert {*np.sign(near.changes)} - {0} == sides
    squares = (parameter.value + np.array(near.changes)) ** 2
    assert squares @ near.weights == pytest.approx(2.0 * parameter.value)
