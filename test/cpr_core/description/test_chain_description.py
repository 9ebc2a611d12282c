# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Chains as descriptions say them: what is read, and what is refused with which words."""

from copy import deepcopy
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
import yaml
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot, solve_home
from cpr_core.description.chain import ChainRod, DescribedJoint, Link, Shift, Turn
from cpr_core.description.chain_joints import CHAIN_JOINTS
from cpr_core.description_part import field, triple

PLANAR = """
base: {position: [0.0, 0.55, 0.0], tangent: [0.0, -1.0, 0.0]}
chain:
- {joint: revolute, axis: [0, 0, 1], motor: motor1, limits: {position: [-1.5, 1.5], effort: 3.0}}
- {link: [0.03, 0, 0]}                    # rigid: where it leads, in the frame (d1 d2 d3) before it
- {rod: {length: 0.6, section: {shape: circular, radius: 0.001},
         young_modulus: 210e9, shear_modulus: 82e9},
   strain: {bending_3: 8}}                # fields left out are those of the robot's `rod`, `strain`
- {link: [0.02, 0, 0], mass: 0.005}
tip: {type: revolute, position: [0.0, 0.1, 0.0]}
"""
SPATIAL = """
base: {position: [0.04, 0.12, 0], tangent: [0, 1, 0], normal: [-1, 0, 0]}
chain:
- {joint: revolute, axis: [0, -1, 0], motor: m1}
- {link: [0.1, 0, 0], mass: 0.02, center_of_mass: [0.05, 0, 0]}     # the crank
- {joint: revolute, axis: [0, 1, 0], stiffness: 0.1, rest: 0.2}     # passive, sprung [N m/rad, rad]
- {joint: revolute, axis: [0, 0, 1]}                                # passive, free
- {rod: {length: 0.4, rest_curvature: {bending_2: [2.0]}}}
tip: {type: spherical, position: [0.03, -0.09, 0]}
"""


def with_leg(name, leg):
    """A robot with another first leg."""
    changed = shipped_content(name)
    changed["legs"][0] = leg
    return changed


def test_a_planar_leg_with_hub_and_end_piece():
    leg = load_robot(with_leg("three_rfr_hubs", yaml.safe_load(PLANAR))).description.legs[0]
    motor, hub, rod, end = leg.chain
    assert (motor.axis, motor.motor, motor.limits.upper, motor.limits.effort) == (
        (0.0, 0.0, 1.0),
        "motor1",
        1.5,
        3.0,
    )
    assert (hub.offset, hub.mass, end.mass, end.center_of_mass) == (
        (0.03, 0.0, 0.0),
        0.0,
        0.005,
        (0.01, 0.0, 0.0),
    )
    assert rod.modes.counts == (0, 0, 8)
    assert rod.rod.section.radius == 0.001


def test_a_leg_of_crank_and_sprung_joint():
    robot = load_robot(with_leg("six_rus", yaml.safe_load(SPATIAL)))
    leg, others = robot.description.legs[0], robot.description.legs[1]
    kinds = [type(element) for element in leg.chain]
    assert kinds == [Turn, Link, Turn, Turn, ChainRod]
    sprung, free, rod = leg.chain[2:]
    assert (sprung.stiffness, sprung.rest, sprung.motor) == (0.1, 0.2, None)
    assert (free.stiffness, free.motor) == (0.0, None)
    # What a rod does not say is the robot's: all but the length and the curvature at rest.
    shared = others.rods[0].rod
    assert (rod.rod.length, rod.rod.section) == (0.4, shared.section)
    assert rod.rod.young_modulus == shared.young_modulus
    assert [list(series) for series in rod.rod.rest_curvature] == [[], [2.0], []]
    assert robot.motor_names == ("m1", *(f"motor{k}" for k in range(2, 7)))


def test_a_frame_is_turned_by_a_link():
    leg = with_leg("six_rus", yaml.safe_load(SPATIAL))
    leg["legs"][0]["chain"][1] |= {"tangent": [0, 0, 2], "normal": [0, 1, 0]}
    link = load_robot(leg).description.legs[0].chain[1]
    np.testing.assert_allclose(link.rotation, [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-15)


def test_strain_of_a_rod_keeps_what_it_does_not_say():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][-1] = {"rod": {}, "strain": {"bending_2": 2}}
    assert load_robot(changed).description.legs[0].rods[0].modes.counts == (3, 2, 5)


def test_limits_and_units_of_motors_that_turn_shift_and_feed():
    changed = shipped_content("six_rus")
    changed["legs"][0]["chain"][0] = {
        "joint": "prismatic",
        "axis": [0, 0, 1],
        "motor": "rail",
        "limits": {"position": [0.0, 0.2]},
    }
    del changed["legs"][1]["chain"][0]["motor"]
    changed["legs"][1]["chain"][-1] = {
        "rod": {"rest_curvature": {}},
        "motor": "feed",
        "limits": {"speed": 0.1},
    }
    changed["home"]["motors"] = [0.0, 0.5, 0.0, 0.0, 0.0, 0.0]
    motors = load_robot(changed).description.motors
    assert [(motor.name, motor.unit, motor.effort_unit) for motor in motors[:3]] == [
        ("rail", "m", "N"),
        ("feed", "m", "N"),
        ("motor3", "rad", "N m"),
    ]
    assert (motors[0].limits.upper, motors[1].limits.speed) == (0.2, 0.1)


def test_a_motor_in_several_joints_is_one():
    changed = shipped_content("six_rus")
    for leg in changed["legs"][3:]:
        leg["chain"][0] |= {"motor": "common", "ratio": -2.0, "offset": 0.1}
    changed |= {"controlled": ["x", "y", "z", "yaw"], "home": {"motors": [0] * 4, "bow": "outward"}}
    robot = load_robot(changed)
    assert robot.motor_names == ("motor1", "motor2", "motor3", "common")
    joints = [leg.chain[0] for leg in robot.description.legs[3:]]
    assert [(joint.ratio, joint.zero) for joint in joints] == [(-2.0, 0.1)] * 3


def test_limits_of_a_shared_motor_are_compared_whichever_joint_has_them_first():
    changed = shipped_content("six_rus")
    for leg in changed["legs"][3:]:
        leg["chain"][0] |= {"motor": "common"}
    changed |= {"controlled": ["x", "y", "z", "yaw"], "home": {"motors": [0] * 4, "bow": "outward"}}
    _, second, third = (leg["chain"][0] for leg in changed["legs"][3:])
    second["limits"] = {"position": [-1.0, 1.0]}
    third["limits"] = {"position": [-1.0, 1.0]}
    assert load_robot(changed).description.motors[3].limits.upper == 1.0
    third["limits"] = {"position": [-0.2, 0.2]}
    with pytest.raises(DescriptionError, match="'common' has other limits") as caught:
        load_robot(changed)
    assert caught.value.field == "legs[5].chain"


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


#: A joint with a motor about its first axis.
HALF_MOVED = {"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]], "motor": ["m", None]}
#: Name of the robot, path of the element changed, what it becomes, field blamed, words of the error.
WRONG = {
    "motor and chain": (
        "six_rus",
        ["legs", 0, "motor"],
        {"type": "welded"},
        "legs[0]",
        "got motor and chain",
    ),
    "nothing known": (
        "six_rus",
        ["legs", 0, "chain", 0],
        {},
        "legs[0].chain[0]",
        "missing field 'joint' (or 'link', 'rod')",
    ),
    "joint and link": (
        "six_rus",
        ["legs", 0, "chain", 1, "joint"],
        "revolute",
        "legs[0].chain[1]",
        "unknown field 'link'",
    ),
    "unknown joint": (
        "six_rus",
        ["legs", 0, "chain", 0, "joint"],
        "ball",
        "legs[0].chain[0].joint",
        "revolute, prismatic, universal",
    ),
    "misspelt": (
        "six_rus",
        ["legs", 0, "chain", 0, "axes"],
        [1, 0, 0],
        "legs[0].chain[0]",
        "unknown field 'axes'",
    ),
    "spring on a motor": (
        "six_rus",
        ["legs", 0, "chain", 0, "stiffness"],
        3.0,
        "legs[0].chain[0].stiffness",
        "a motor holds this joint",
    ),
    "ratio of nothing": (
        "six_rus",
        ["legs", 0, "chain", 0],
        {"joint": "revolute", "axis": [0, -1, 0], "ratio": 2.0},
        "legs[0].chain[0].ratio",
        "no motor",
    ),
    "ratio zero": (
        "six_rus",
        ["legs", 0, "chain", 0, "ratio"],
        0.0,
        "legs[0].chain[0].ratio",
        "other than zero",
    ),
    "limits of nothing": (
        "six_rus",
        ["legs", 0, "chain", 3, "limits"],
        {"speed": 1.0},
        "legs[0].chain[3].limits",
        "no motor feeds this rod",
    ),
    "axis of length zero": (
        "six_rus",
        ["legs", 0, "chain", 0, "axis"],
        [0, 0, 0],
        "legs[0].chain[0].axis",
        "length zero",
    ),
    "axes the same": (
        "six_rus",
        ["legs", 0, "chain", 2, "axes"],
        [[0, 1, 0], [0, -1, 0]],
        "legs[0].chain[2].axes",
        "expected two directions",
    ),
    "one motor for two axes": (
        "six_rus",
        ["legs", 0, "chain", 2, "motor"],
        "both",
        "legs[0].chain[2].motor",
        "expected array",
    ),
    "three springs for two axes": (
        "six_rus",
        ["legs", 0, "chain", 2, "rest"],
        [0.1, 0.2, 0.3],
        "legs[0].chain[2].rest",
        "exactly 2 entries",
    ),
    "a word for a spring": (
        "six_rus",
        ["legs", 0, "chain", 2, "stiffness"],
        "soft",
        "legs[0].chain[2].stiffness",
        "got 'soft' (of its spring",
    ),
    "spring and motor about one axis": (
        "six_rus",
        ["legs", 0, "chain", 2],
        HALF_MOVED | {"stiffness": [0.1, 0]},
        "legs[0].chain[2].stiffness",
        "a motor holds this joint",
    ),
    "offset of a passive axis": (
        "six_rus",
        ["legs", 0, "chain", 2],
        HALF_MOVED | {"offset": [0, 0.1]},
        "legs[0].chain[2].offset",
        "no motor moves this joint",
    ),
    "one spring of two axes with motors": (
        "six_rus",
        ["legs", 0, "chain", 2],
        {"joint": "universal", "axes": [[0, 1, 0], [0, 0, 1]], "motor": ["m", "n"], "rest": 0.1},
        "legs[0].chain[2].rest",
        "a motor holds this joint",
    ),
    "one ratio of two passive axes": (
        "six_rus",
        ["legs", 0, "chain", 2, "ratio"],
        2.0,
        "legs[0].chain[2].ratio",
        "no motor moves this joint",
    ),
    "negative mass": (
        "six_rus",
        ["legs", 0, "chain", 1, "mass"],
        -1.0,
        "legs[0].chain[1].mass",
        "at least 0",
    ),
    "fed and bent at rest": (
        "six_rus",
        ["legs", 0, "chain", 3],
        {"rod": {"rest_curvature": {"bending_2": [1.0, 2.0]}}, "motor": "feed"},
        "legs[0].chain[3].motor",
        "uniform",
    ),
    "turns and shifts": (
        "six_rus",
        ["legs", 0, "chain", 2],
        {"joint": "prismatic", "axis": [1, 0, 0], "motor": "motor2"},
        "legs[1].chain",
        "cannot turn, shift or feed at the same time",
    ),
    "other limits": (
        "six_rus",
        ["legs", 0, "chain", 2],
        {"joint": "revolute", "axis": [1, 0, 0], "motor": "motor1", "limits": {"effort": 1.0}},
        None,
        None,
    ),
    "universal in the plane": (
        "three_rfr_hubs",
        ["legs", 0, "chain", 1],
        {"joint": "universal", "axes": [[1, 0, 0], [0, 1, 0]]},
        "legs[0].chain[1].joint",
        "spatial",
    ),
    "out of the plane": (
        "three_rfr_hubs",
        ["legs", 0, "chain", 1, "link"],
        [0.1, 0.0, 0.1],
        "legs[0].chain[1].link",
        "z = 0",
    ),
    "about x in the plane": (
        "three_rfr_hubs",
        ["legs", 0, "chain", 0, "axis"],
        [1, 0, 0],
        "legs[0].chain[0].axis",
        "expected +-z",
    ),
    "no frame at the base": (
        "six_rus",
        ["legs", 0, "base"],
        {"position": [0, 0, 0], "tangent": [1, 0, 0]},
        "legs[0].base",
        "missing field 'normal'",
    ),
    "strain of home for two rods": (
        "three_rfr_hubs",
        ["legs", 1, "chain", 3],
        {"rod": {}},
        "home.strain",
        "legs of one rod",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(case):
    name, path, value, field, words = WRONG[case]
    changed = deepcopy(shipped_content(name))
    if case == "strain of home for two rods":
        changed["home"] = {"motors": [0, 0, 0], "strain": [{}, {}, {}]}
    part = changed
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    if field is None:  # the first limits count where the other joint has none
        assert load_robot(changed).description.motors[0].limits.effort == 1.0
        part[0]["limits"] = {"effort": 2.0}
        field, words = "legs[0].chain", "other limits"
    with pytest.raises(DescriptionError) as caught:
        load_robot(changed)
    assert caught.value.field == field, caught.value
    assert words in str(caught.value)


def test_a_motor_of_the_short_form_is_no_motor_of_a_chain():
    changed = shipped_content("six_rus")
    short = {
        "base": changed["legs"][0]["base"],
        "motor": {"type": "revolute", "axis": [0, 0, 1], "name": "motor2"},
        "tip": changed["legs"][0]["tip"],
    }
    with pytest.raises(DescriptionError, match=r"motor2.*several joints share"):
        load_robot(with_leg("six_rus", short))


@pytest.mark.parametrize("place", ["robot", "leg", "chain"])
def test_a_stiffness_that_jumps_is_refused_with_advice(place):
    changed, rod = shipped_content("six_rus"), {"at": [0, 0.4, 0.45, 1], "stiffness": [1, 1, 4, 4]}
    if place == "robot":
        changed["rod"]["profile"] = rod
    elif place == "leg":
        changed["legs"][0]["rod"] = changed["rod"] | {"profile": rod}
    else:
        changed["legs"][0]["chain"][-1] = {"rod": {"profile": rod}}
    path = {"robot": "rod", "leg": "legs[0].rod", "chain": "legs[0].chain[3].rod"}[place]
    with pytest.raises(
        DescriptionError, match=r"between 0.4 and 0.45.*two rods in a chain"
    ) as caught:
        load_robot(changed)
    assert caught.value.field == f"{path}.profile.at"


def test_it_is_the_modes_of_the_robot_that_count():
    """Not those of the file where others are asked for, nor those that a tolerance has nobody write."""
    changed = shipped_content("planar_body")
    changed["rod"]["profile"] = {"at": [0, 0.3, 0.35, 1], "stiffness": [1, 1, 0.05, 0.05]}
    changed["strain"] = {"bending_3": 12}
    assert load_robot(changed).description.legs[0].modes.counts[2] == 12
    with pytest.raises(DescriptionError, match="a jump to 3 polynomial modes"):
        load_robot(changed, modes=3)
    changed["strain"] = {"bending_3": 9}
    with pytest.raises(DescriptionError, match="a jump to 9 polynomial modes"):
        load_robot(changed)
    robot = load_robot(changed, modes=12)
    with pytest.raises(DescriptionError, match="a jump to 12"):
        robot.with_parameters({"rod.profile.at[2]": 0.32})
    changed["strain"] = {"tolerance": 2e-3}
    assert load_robot(changed).description.legs[0].modes.counts[2] > 5


@pytest.mark.parametrize("at", [[0.1, 0.2], [0.2, 0.3], [0.3, 0.4]])
def test_rounding_makes_no_jump(at):
    changed = shipped_content("planar_body")
    changed["rod"]["profile"] = {"at": [0, *at, 1], "stiffness": [1, 1, 0.5, 0.5]}
    load_robot(changed, modes=5)


def test_a_stiffness_that_changes_slowly_or_with_knots_is_taken():
    slow, knots = shipped_content("six_rus"), shipped_content("three_rfr_hubs")
    slow["rod"]["profile"] = {"at": [0, 0.4, 0.6, 1], "stiffness": [1, 1, 4, 4]}
    load_robot(slow)
    knots["rod"]["profile"] = {"at": [0, 0.4, 0.45, 1], "stiffness": [1, 1, 4, 4]}
    knots["strain"] = {"basis": "bsplines", "knots": [0.4, 0.42, 0.45]}
    for leg in knots["legs"]:
        leg["chain"][2] = {"rod": {}}
    load_robot(knots)
    del knots["rod"]["profile"]
    knots["legs"][0]["rod"] = knots["rod"]
    assert load_robot(knots).description.legs[0].rods[0].rod.uniform


@pytest.mark.parametrize(
    ("degree", "knots", "width", "taken"),
    [
        (3, [0.5], 0.2, True),
        (3, [0.5], 0.05, False),
        (3, [0.2, 0.4, 0.6, 0.8], 0.1, True),
        (3, [0.2, 0.4, 0.6, 0.8], 1e-6, False),
        (3, [0.49, 0.51], 0.02, False),
        (3, [0.48, 0.49, 0.5, 0.51, 0.52], 0.02, True),
        (1, [0.49, 0.51], 0.02, True),
        (0, [0.5], 1e-6, True),
        (0, [0.3], 1e-6, False),
    ],
)
def test_splines_follow_what_their_knots_let_them(degree, knots, width, taken):
    """They were taken whatever the knots, and up to 20 mm wrong; here by the truth of many knots."""
    changed = shipped_content("rfrfr")
    at = [0, 0.5 - 0.5 * width, 0.5 + 0.5 * width, 1]
    changed["rod"]["profile"] = {"at": at, "stiffness": [1, 1, 0.25, 0.25]}
    changed["strain"] = {"basis": "bsplines", "degree": degree, "knots": knots}
    if not taken:
        with pytest.raises(DescriptionError, match="faster than") as caught:
            load_robot(changed)
        assert caught.value.field == "rod.profile.at"
        return
    home = solve_home(load_robot(changed))
    fine = sorted({*np.linspace(0.05, 0.95, 19), *np.linspace(at[1], at[2], 11)})
    changed["strain"] = {"basis": "bsplines", "degree": 1, "knots": [float(k) for k in fine]}
    true = solve_home(load_robot(changed))
    assert np.linalg.norm(home.platform_position - true.platform_position) < 0.01


@pytest.mark.parametrize("tip", [0.05, 0.02])
def test_splines_follow_a_rod_that_is_soft_at_its_tip(tip):
    """One moment would bend it far there, and a hinge has none."""
    changed = shipped_content("rfrfr")
    changed["rod"]["profile"] = {"at": [0, 1], "stiffness": [1, tip]}
    changed["strain"] = {"basis": "bsplines", "knots": [0.5]}
    home = solve_home(load_robot(changed))
    changed["strain"]["knots"] = [0.5, 0.8, 0.9, 0.95, 0.98]
    true = solve_home(load_robot(changed))
    assert np.linalg.norm(home.platform_position - true.platform_position) < 2e-3


# Joints of one's own: one class and its name.


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


@pytest.mark.parametrize(("named", "blamed"), [(2, 2), (0, 1)])
def test_no_leg_is_called_like_a_rod_of_another(named, blamed):
    """Loads on that rod would act on one of the two, without a word."""
    changed = shipped_content("three_rfr_hubs")
    changed["legs"][1]["chain"] += [{"rod": {}}]
    changed["home"] = {"motors": [0, 0, 0], "bow": "outward"}
    assert "leg2.rod2" in load_robot(changed).rod_names
    changed["legs"][named]["name"] = "leg2.rod2"
    with pytest.raises(DescriptionError, match=r"'leg2\.rod2' is the name of a rod of") as caught:
        load_robot(changed)
    assert caught.value.field == f"legs[{blamed}].name"


def test_a_motor_named_in_two_legs_is_told_where_home_has_a_number_too_many():
    """Its name was copied with its leg: only the numbers of home were said to be wrong."""
    changed = shipped_content("three_rfr_hubs")
    joint = next(element for element in changed["legs"][1]["chain"] if "motor" in element)
    joint["motor"] = "motor1"
    del joint["limits"]
    motors = "motor1 of leg1 and leg2, motor3 of leg3"
    with pytest.raises(DescriptionError) as caught:
        load_robot(changed)
    assert caught.value.field == "home.motors"
    assert caught.value.problem == f"expected 2 numbers, one per motor ({motors}), got 3"
    changed["home"]["motors"].pop()
    changed["controlled"] = ["x", "y"]
    assert load_robot(changed).motor_names == ("motor1", "motor3")


def test_rods_are_needed():
    changed = shipped_content("three_rfr_hubs")
    for leg in changed["legs"]:
        leg["chain"] = [element for element in leg["chain"] if "rod" not in element]
    with pytest.raises(DescriptionError, match="legs: expected a rod in at least one leg"):
        load_robot(changed)
