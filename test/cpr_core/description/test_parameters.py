# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of descriptions by their paths: found, and set to something else and back."""

import copy
import pickle

import numpy as np
import pytest
import yaml
from helpers.parameter_kinds import parameter_kinds
from helpers.parameter_robots import SHARED, SIX_RFS, half_moved
from numpy.testing import assert_array_equal

from cpr_core import (
    DescriptionError,
    InvalidRequest,
    UnknownParameter,
    continued,
    derivatives,
    load_robot,
    solve_home,
)
from cpr_core.description.changed_description import between
from cpr_core.description.description_file import shipped_robots

ROBOTS = list(shipped_robots())


def same(first, second):
    """Whether two robots are the same to the kernels."""
    for name, value in first.kernel_arrays._asdict().items():
        other = getattr(second.kernel_arrays, name)
        if isinstance(value, np.ndarray):
            assert value.tobytes() == other.tobytes(), name
        else:
            assert value == other, name


def test_values_are_those_of_the_file():
    robot = load_robot("six_rfs")
    content = yaml.safe_load(SIX_RFS)
    paths = ["rod.length", "rod.density", "legs[3].base.position[1]", "legs[5].tip.position[0]"]
    legs = content["legs"]
    expected = [1.0, 7800.0, legs[3]["base"]["position"][1], legs[5]["tip"]["position"][0]]
    assert_array_equal(robot.parameter_values(paths), expected)
    assert robot.parameter_values("rod.young_modulus") == [2.1e11]


def test_defaults_count_as_written():
    robot = load_robot("six_rus")
    paths = [
        "legs[0].chain[0].offset",
        "legs[0].chain[0].ratio",
        "legs[1].chain[1].center_of_mass[0]",
    ]
    crank = robot.parameter_values("legs[1].chain[1].link[0]")[0]
    assert_array_equal(robot.parameter_values(paths), [0.0, 1.0, 0.5 * crank])
    changed = robot.with_parameters({"platform.center_of_mass[2]": 0.1, paths[1]: 2.0})
    assert_array_equal(changed.description.center_of_mass, [0.0, 0.0, 0.1])
    assert changed.description.legs[0].chain[0].ratio == 2.0


@pytest.mark.parametrize("name", ["rfrfr", "planar_body", "six_rfs", "gough_stewart"])
def test_ratios_of_the_short_form_that_are_not_written_are_one(name):
    """As those of chains; the legs stay what they are, and robots beside them have other ratios."""
    path = "legs[0].motor.ratio"
    robot = load_robot(name)
    assert robot.parameter_values(path) == [1.0]
    assert robot.description.legs[0].elements is None
    richer = load_robot(name, modes=7)
    changed = richer.with_parameters({path: 1.5})
    assert changed.description.legs[0].chain[0].ratio == 1.5
    assert changed.description.legs[0].rods[0].modes == richer.description.legs[0].modes
    same(richer, changed.with_parameters({path: 1.0}))

    home, change = solve_home(robot), 2e-5
    found = derivatives(home, path, of=("pose", "efforts"))
    above, below = (
        continued(home, robot.with_parameters({path: 1.0 + sign * change})) for sign in (1, -1)
    )
    position = (above.platform_position - below.platform_position) / (2.0 * change)
    efforts = (above.efforts - below.efforts) / (2.0 * change)
    np.testing.assert_allclose(found.position.ravel(), position, atol=1e-6)
    np.testing.assert_allclose(found.efforts.ravel(), efforts, rtol=1e-5, atol=1e-6)


def test_a_joint_that_turns_has_no_lead():
    with pytest.raises(UnknownParameter):
        load_robot("six_rfs").parameter_values("legs[0].motor.lead")


@pytest.mark.parametrize("name", ROBOTS)
def test_every_number_can_be_set(name):
    """To what it is: nothing changes, whatever is written out; and to something else and back."""
    robot = load_robot(name)
    paths = parameter_kinds(robot)
    values = dict(zip(paths, robot.parameter_values(paths), strict=True))
    same(robot, robot.with_parameters(values))
    moved = 0
    for path in paths:
        value = values[path]
        try:
            away = robot.with_parameters({path: 1.001 * value if value else 1e-3})
        except DescriptionError:
            continue  # z in the plane, a direction that alone is no more across the other
        assert away.parameter_values(path)[0] != value
        same(robot, away.with_parameters({path: value}))
        moved += 1
    assert moved > 20


@pytest.mark.parametrize("name", ROBOTS)
def test_the_text_loads_and_is_the_same_robot(name):
    robot = load_robot(name)
    force = robot.parameter_values("loads.platform_force[0]")[0] + 0.25
    changed = robot.with_parameters({"rod.length": 0.7, "loads.platform_force[0]": force})
    again = load_robot(changed.description.text)
    same(again, changed)
    assert_array_equal(again.default_loads.wrench_world, changed.default_loads.wrench_world)
    assert again.default_loads.wrench_world[3] == force
    assert load_robot(yaml.safe_load(SIX_RFS)).description.text == ""


def test_a_wildcard_is_every_leg():
    robot = load_robot(SHARED)
    changed = robot.with_parameters(
        {"legs[*].chain[1].link[0]": 0.03, "legs[*].chain[0].offset": 0.1}
    )
    assert [leg.chain[1].offset[0] for leg in changed.description.legs] == [0.03, 0.03]
    assert [leg.chain[0].zero for leg in changed.description.legs] == [0.1, 0.1]
    assert changed.parameter_values("legs[*].chain[*].link[0]") == [0.03]
    with pytest.raises(InvalidRequest, match=r"no single value: -0\.2, 0\.2; name the places"):
        robot.parameter_values("legs[*].base.position[0]")


@pytest.mark.parametrize("legs", ["0,1", "1,0"])
def test_several_legs_are_one_number(legs):
    """As of a motor that moves two legs, whose zero stands in both."""
    robot = load_robot("delta")
    changed = robot.with_parameters({f"legs[{legs}].chain[0].offset": 0.1})
    zeros = [leg.chain[0].zero for leg in changed.description.legs]
    assert zeros == [0.1, 0.1, 0.0, 0.0, 0.0, 0.0]
    assert changed.parameter_values(f"legs[{legs}].chain[0].offset") == [0.1]
    assert changed.parameter_values("legs[2,3,5].chain[*].offset") == [0.0]
    assert robot.parameter_values(f"legs[{legs}].tip.position[2]") == [0.0]
    assert robot.parameter_values("gravity[0,1]") == [0.0]
    with pytest.raises(InvalidRequest, match=r"no single value: 0\.1, 0; name the places"):
        changed.parameter_values("legs[1,2].chain[0].offset")
    with pytest.raises(InvalidRequest, match=r"legs\[1\]\.chain\[0\]\.offset is given two values"):
        robot.with_parameters(
            {f"legs[{legs}].chain[0].offset": 0.1, "legs[1].chain[0].offset": 0.2}
        )


def test_nothing_of_the_first_robot_changes():
    content = yaml.safe_load(SIX_RFS)
    before = copy.deepcopy(content)
    robot = load_robot(content)
    robot.with_parameters({"rod.length": 0.9, "legs[*].tip.position[2]": 0.01})
    assert content == before
    assert robot.parameter_values("rod.length") == [1.0]


@pytest.mark.parametrize(
    ("path", "value", "before", "attributes"),
    [
        ("offset", 0.1, 0.0, {"zero": (0.1, 0.0)}),
        ("offset[0]", 0.1, 0.0, {"zero": (0.1, 0.0)}),
        ("ratio", 1.5, 1.0, {"ratio": (1.5, 1.0)}),
        ("ratio[0]", 1.5, 1.0, {"ratio": (1.5, 1.0)}),
        ("stiffness", 0.3, 0.2, {"stiffness": (0.0, 0.3)}),
        ("stiffness[1]", 0.3, 0.2, {"stiffness": (0.0, 0.3)}),
        ("rest", 0.1, 0.0, {"rest": (0.0, 0.1)}),
        ("rest[1]", 0.1, 0.0, {"rest": (0.0, 0.1)}),
    ],
)
def test_numbers_of_a_universal_joint_are_named_once_or_by_axis(path, value, before, attributes):
    robot, path = half_moved(), f"legs[0].chain[2].{path}"
    assert robot.parameter_values(path) == [before]
    changed = robot.with_parameters({path: value})
    turns = changed.description.legs[0].chain[2:4]
    for name, expected in attributes.items():
        assert tuple(getattr(turn, name) for turn in turns) == expected
    assert turns[1].stiffness == (0.3 if "stiffness" in path else 0.2)
    assert changed.parameter_values(path) == [value]
    middle = between(robot.description, changed.description, 0.5)
    turns = middle.legs[0].chain[2:4]
    for name, expected in attributes.items():
        own = 0 if name in ("zero", "ratio") else 1
        assert getattr(turns[own], name) == pytest.approx(0.5 * (before + expected[own]))


def test_numbers_that_an_axis_of_a_universal_joint_cannot_have_are_unknown():
    robot, joint = half_moved(), "legs[0].chain[2]"
    for path in ("offset[1]", "ratio[1]", "stiffness[0]", "rest[0]"):
        with pytest.raises(UnknownParameter):
            robot.parameter_values(f"{joint}.{path}")
    with pytest.raises(InvalidRequest, match="two values, one of them for both"):
        robot.with_parameters({f"{joint}.ratio": 2.0, f"{joint}.ratio[0]": 3.0})


def test_a_number_that_is_no_python_float_is_one():
    robot = load_robot("six_rfs").with_parameters({"rod.length": np.float32(0.5)})
    assert robot.parameter_values("rod.length") == [0.5]


def test_robots_with_other_numbers_are_pickled():
    robot = load_robot("six_rus").with_parameters({"rod.length": 0.5})
    again = pickle.loads(pickle.dumps(robot))
    assert again.parameter_values("rod.length") == [0.5]
