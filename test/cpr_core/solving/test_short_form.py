# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs in the short form are chains, and joints of several turns are several joints."""

from copy import deepcopy

import numpy as np
import pytest
from helpers.chain_robots import as_chains
from helpers.same_equilibria import assert_same
from helpers.shipped_steps import SHORT_FORM
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, kinemato_statics, load_robot, solve_forward, solve_home


@pytest.mark.parametrize("pieces", ["none", "of length zero"])
@pytest.mark.parametrize("name", SHORT_FORM)
def test_the_short_form_is_a_chain_with_links_of_no_length_or_none(name, pieces):
    robot = load_robot(name)
    spelt = load_robot(as_chains(name, links=pieces == "of length zero"))
    home, same = solve_home(robot), solve_home(spelt)
    assert spelt.motor_names == robot.motor_names
    assert_same(same, home)
    moved = home.motors + 0.02 * np.cos(np.arange(robot.motor_count))
    assert_same(solve_forward(spelt, moved), solve_forward(robot, moved))
    np.testing.assert_allclose(
        kinemato_statics(same).jacobian, kinemato_statics(home).jacobian, atol=1e-9
    )
    assert same.spectrum_locked.margin == pytest.approx(home.spectrum_locked.margin, abs=1e-9)


#: Robots in the short form by what their motors do: a name, and what its motors are in place of its own.
OFFSETS = {
    "turn": ("six_rfs", None),
    "turn in the plane": ("planar_body", None),
    "shift": ("gough_stewart", {"type": "prismatic", "axis": [0.3, -0.2, 1.0]}),
    "shift in the plane": ("planar_body", {"type": "prismatic", "axis": [0.6, -0.8, 0.0]}),
}


@pytest.mark.parametrize("kind", OFFSETS)
def test_the_zero_of_a_motor_is_that_of_its_joint(kind):
    """As in a chain with the same offset, and as without offset where the joints are."""
    name, motor = OFFSETS[kind]
    plain = shipped_content(name)
    if motor is not None:
        plain["home"]["motors"] = [0.0] * len(plain["legs"])
        for leg in plain["legs"]:
            leg["motor"] = dict(motor)
    offsets = 0.02 * np.cos(1.0 + np.arange(len(plain["legs"])))
    zeroed = deepcopy(plain)
    for leg, offset in zip(zeroed["legs"], offsets.tolist(), strict=True):
        leg["motor"]["offset"] = offset
    zeroed["home"]["motors"] = (np.array(plain["home"]["motors"]) - offsets).tolist()
    robot, spelt = load_robot(zeroed), load_robot(as_chains(zeroed, links=False))
    assert all(leg.chain[0].zero for leg in spelt.description.legs)
    home = solve_home(robot)
    assert_same(solve_home(spelt), home)
    assert_same(home, solve_home(load_robot(plain)), atol=1e-9)
    np.testing.assert_allclose(home.motors, zeroed["home"]["motors"], atol=1e-15)


@pytest.mark.parametrize("field", ["offset", "ratio", "limits"])
def test_a_base_without_a_motor_has_nothing_of_one(field):
    content = shipped_content("gough_stewart")
    content["legs"][0]["motor"] = {"type": "welded", field: {} if field == "limits" else 0.1}
    with pytest.raises(DescriptionError, match=rf"legs\[0\]\.motor: unknown field '{field}'"):
        load_robot(content)


AXES = [[0.0, 1.0, 0.0], [0.1, 0.0, 1.0]]
#: A universal joint, and the same as two revolute ones.
UNIVERSAL = {
    "passive": ({}, {}, {}),
    "sprung": (
        {"stiffness": [0.2, 0.1], "rest": [0.3, -0.2]},
        {"stiffness": 0.2, "rest": 0.3},
        {"stiffness": 0.1, "rest": -0.2},
    ),
    "first driven": (
        {"motor": ["extra1", None], "ratio": [-0.5, None], "stiffness": [None, 0.2]},
        {"motor": "extra1", "ratio": -0.5},
        {"stiffness": 0.2},
    ),
    "both driven": (
        {"motor": ["extra1", "extra2"], "offset": [0.1, -0.05], "ratio": 2.0},
        {"motor": "extra1", "offset": 0.1, "ratio": 2.0},
        {"motor": "extra2", "offset": -0.05, "ratio": 2.0},
    ),
}


@pytest.mark.parametrize("kind", UNIVERSAL)
def test_a_universal_joint_is_two_revolute_ones(kind):
    universal, *turns = UNIVERSAL[kind]
    with_universal, with_revolutes = shipped_content("six_rus"), shipped_content("six_rus")
    with_universal["legs"][1]["chain"][2] = {"joint": "universal", "axes": AXES} | universal
    with_revolutes["legs"][1]["chain"][2:3] = [
        {"joint": "revolute", "axis": axis} | turn for axis, turn in zip(AXES, turns, strict=True)
    ]
    extra = sum("motor" in turn for turn in turns)
    for changed in (with_universal, with_revolutes):
        changed["controlled"] = [] if extra else ["x", "y", "z", "orientation"]
        changed["home"]["motors"] = [0.0] * 2 + [0.05, 0.02][:extra] + [0.0] * 4
    first, second = load_robot(with_universal), load_robot(with_revolutes)
    assert first.motor_names == second.motor_names and first.motor_count == 6 + extra
    home, same = solve_home(first), solve_home(second)
    assert_same(home, same)
    moved = home.motors + 0.1 * np.cos(np.arange(first.motor_count))
    assert_same(solve_forward(first, moved), solve_forward(second, moved))
