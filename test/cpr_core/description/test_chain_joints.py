# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Joints of chains: universal ones, whose turns each have their own, and joints of one's own."""

from copy import deepcopy
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot, solve_home
from cpr_core.description.chain import DescribedJoint, Shift, Turn
from cpr_core.description.chain_joints import CHAIN_JOINTS
from cpr_core.description_part import field, triple


def test_a_universal_joint_is_two_turns_each_with_its_own():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][2] |= {
        "motor": [None, "second"],
        "ratio": [None, -2.0],
        "limits": [None, {"position": [-1.0, 1.0]}],
        "stiffness": [0.2, None],
        "rest": [0.1, None],
    }
    changed |= {"controlled": [], "home": {"motors": [0] * 7, "bow": "outward"}}
    axes = changed["legs"][0]["chain"][2]["axes"]
    first, second = load_robot(changed).description.legs[0].chain[2:4]
    assert (first.axis, first.motor, first.stiffness, first.rest) == (
        tuple(axes[0]),
        None,
        0.2,
        0.1,
    )
    assert (second.axis, second.motor, second.ratio, second.stiffness) == (
        tuple(axes[1]),
        "second",
        -2.0,
        0.0,
    )
    assert (second.limits.lower, second.limits.upper) == (-1.0, 1.0)


def test_one_value_is_for_both_turns_of_a_universal_joint():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][2] |= {"stiffness": 0.2, "rest": 0.1}
    for turn in load_robot(changed).description.legs[0].chain[2:4]:
        assert (turn.stiffness, turn.rest) == (0.2, 0.1)
    del changed["legs"][0]["chain"][2]["stiffness"], changed["legs"][0]["chain"][2]["rest"]
    limits = {"position": [-1.0, 1.0]}
    changed["legs"][0]["chain"][2] |= {"motor": ["a", "b"], "limits": limits, "offset": 0.3}
    changed |= {"controlled": [], "home": {"motors": [0] * 8, "bow": "outward"}}
    robot = load_robot(changed)
    assert robot.motor_names[:3] == ("motor1", "a", "b")
    for turn in robot.description.legs[0].chain[2:4]:
        assert (turn.limits.lower, turn.zero) == (-1.0, 0.3)


@pytest.mark.parametrize("turned", [0, 1])
def test_one_value_is_for_the_turn_of_a_universal_joint_that_can_have_it(turned):
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][2] |= {
        "motor": ["m", None] if turned == 0 else [None, "m"],
        "ratio": -2.0,
        "offset": 0.3,
        "limits": {"position": [-1.0, 1.0]},
        "stiffness": 0.2,
        "rest": 0.1,
    }
    changed |= {"controlled": [], "home": {"motors": [0] * 7, "bow": "outward"}}
    turns = load_robot(changed).description.legs[0].chain[2:4]
    moved, passive = turns[turned], turns[1 - turned]
    assert (moved.ratio, moved.zero, moved.limits.lower) == (-2.0, 0.3, -1.0)
    assert (moved.stiffness, moved.rest) == (0.0, 0.0)
    assert (passive.stiffness, passive.rest, passive.ratio, passive.zero) == (0.2, 0.1, 1.0, 0.0)


@dataclass(frozen=True)
class Leaning(Turn):
    """Turns about an axis across d1 that leans from d2 towards d3."""

    fields: ClassVar = {"lean": {"type": "number", "description": "[rad]"}, **Turn.fields}
    required = ("lean",)

    @classmethod
    def _axis(cls, part):
        return np.array([0.0, np.cos(part.number("lean")), np.sin(part.number("lean"))])


class Cylindrical(DescribedJoint):
    """Turns about an axis and shifts along it, sprung."""

    fields: ClassVar = {"axis": field("axis", "of both"), "stiffness": field("positive", "of both")}
    required = ("axis", "stiffness")

    @classmethod
    def elements(cls, part, name):
        axis, stiffness = triple(part.direction("axis")), part.number("stiffness")
        return tuple(
            kind(axis, stiffness=stiffness, name=f"{name}[{number}]")
            for number, kind in enumerate((Turn, Shift))
        )


OWN = {
    "leaning": (
        [{"joint": "leaning", "lean": 0.3, "stiffness": 0.2, "rest": 0.1}],
        [
            {"joint": "revolute", "axis": [0, float(np.cos(0.3)), float(np.sin(0.3))]}
            | {"stiffness": 0.2, "rest": 0.1}
        ],
    ),
    "cylindrical": (
        [{"joint": "cylindrical", "axis": [1, 2, 0], "stiffness": 50.0}],
        [
            {"joint": kind, "axis": [1, 2, 0], "stiffness": 50.0}
            for kind in ("revolute", "prismatic")
        ],
    ),
}


@pytest.mark.parametrize("kind", OWN)
def test_a_joint_of_ones_own_is_one_class(kind, monkeypatch):
    monkeypatch.setitem(CHAIN_JOINTS, "leaning", Leaning)
    monkeypatch.setitem(CHAIN_JOINTS, "cylindrical", Cylindrical)
    homes = []
    for chain in OWN[kind]:
        changed = shipped_content("six_rus")
        for leg in changed["legs"]:
            leg["chain"][3:3] = deepcopy(chain)
        homes.append(solve_home(load_robot(changed)))
    np.testing.assert_allclose(homes[0].state, homes[1].state, atol=1e-12)
    misspelt = shipped_content("six_rus")
    misspelt["legs"][0]["chain"].insert(3, OWN[kind][0][0] | {"bend": 1})
    with pytest.raises(DescriptionError, match="unknown field 'bend'"):
        load_robot(misspelt)
