# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Chains in other units: joints, links, rods, gears and screws."""

import re
import warnings

import pytest
from helpers.doubts import DEGREES, MILLIMETRES
from helpers.fed_robots import fed, plain_content
from helpers.shipped_steps import CHAINS
from helpers.spoilt_descriptions import put
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, DescriptionWarning, load_robot, solve_home
from cpr_core.description.description_file import read_description


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("chain", 0, "limits"), {"position": [-90, 90]}, rf"limits\.position: -90: {DEGREES}"),
        (("chain", 0, "limits"), {"position": [-1, 90]}, rf"limits\.position: 90: {DEGREES}"),
        (("chain", 0, "offset"), 45, rf"offset: 45: {DEGREES}"),
        (("chain", 2, "rest"), [0, 30], rf"rest: 30: {DEGREES}"),
        (
            ("chain", 0),
            {"joint": "prismatic", "axis": [0, 0, 1], "motor": "motor2", "offset": 50},
            rf"offset: 50: {MILLIMETRES}",
        ),
        (
            ("chain", 2),
            {"joint": "prismatic", "axis": [0, 0, 1], "stiffness": 100.0, "rest": -20},
            rf"rest: -20: {MILLIMETRES}",
        ),
        (("chain", 1, "link"), [23.1, 0, 0], rf"link: 23.1 m, more than .*{MILLIMETRES}"),
        (("chain", 1, "center_of_mass"), [0, 12, 0], rf"center_of_mass: 12 m.*{MILLIMETRES}"),
        (("chain", 3, "rod"), {"length": 53.0}, rf"rod\.length: 53 m: {MILLIMETRES}"),
        (("chain", 3, "rod"), {"density": 4.4}, r"rod\.density: 4.4: looks like g/cm\^3"),
    ],
)
def test_what_looks_like_another_unit_in_a_chain_is_said(path, value, says):
    content = shipped_content("six_rus")
    put(content["legs"][1], path, value)
    with pytest.warns(DescriptionWarning, match=rf"legs\[1\]\.chain\[{path[1]}\]\.{says}"):
        read_description(content)


@pytest.mark.parametrize("own", [{}, {"length": 0.5}])
def test_what_the_rod_of_all_chains_says_is_doubted_once(own):
    """It was told of every rod that takes it from there: seven lines of six legs."""
    content = shipped_content("six_rus")
    content["rod"]["density"] = 7.8
    for leg in content["legs"]:
        put(leg, ("chain", 3, "rod"), own)
    with pytest.warns(DescriptionWarning) as told:
        read_description(content)
    assert [str(each.message).partition(": ")[2] for each in told] == [
        "rod.density: 7.8: looks like g/cm^3, expected kg/m^3"
    ]


def test_a_rod_of_a_chain_that_is_fed_millimetres_is_said():
    content = shipped_content("six_rus")
    content["legs"][0]["chain"][3] = {
        "rod": {"rest_curvature": {}},
        "motor": "feed",
        "limits": {"position": [100, 600]},
    }
    content |= {"controlled": [], "home": {"motors": [0, 0.5, 0, 0, 0, 0, 0], "bow": "outward"}}
    with pytest.warns(
        DescriptionWarning, match=rf"chain\[3\]\.limits\.position: 100: {MILLIMETRES}"
    ):
        read_description(content)


@pytest.mark.parametrize(
    ("path", "value", "field", "says"),
    [
        (
            ("chain", 1, "link"),
            [231.64, 0, 0],
            "chain[1].link",
            f"[231.64, 0.0, 0.0]: {MILLIMETRES}",
        ),
        (("chain", 1, "center_of_mass"), [0, 0, 115], "chain[1].center_of_mass", MILLIMETRES),
        (  # not hidden by a link that is only doubted
            ("chain", 1),
            {"link": [23.1, 0, 0], "mass": 0.1, "center_of_mass": [0, 0, 115]},
            "chain[1].center_of_mass",
            MILLIMETRES,
        ),
        (
            ("chain", 3, "rod"),
            {"young_modulus": 110},
            "chain[3].rod.young_modulus",
            "looks like GPa",
        ),
    ],
)
def test_what_cannot_be_in_a_chain_is_refused(path, value, field, says):
    content = shipped_content("six_rus")
    put(content["legs"][1], path, value)
    with pytest.raises(DescriptionError) as caught:
        read_description(content)
    assert caught.value.field == f"legs[1].{field}"
    assert says in caught.value.problem


@pytest.mark.parametrize("joints", [{"leg2.joint2": [0.1, 45]}, {"leg2.joint2[1]": 45}])
def test_rough_joints_in_degrees_are_said(joints):
    content = shipped_content("six_rus")
    content["home"]["joints"] = joints
    with pytest.warns(DescriptionWarning, match=rf"home\.joints\.leg2\.joint2\[1\]: 45: {DEGREES}"):
        read_description(content)


def said_of(content):
    """What is doubted in a description, without its name."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DescriptionWarning)
        read_description(content)
    return [str(warning.message).partition(": ")[2] for warning in caught]


def test_a_lead_in_millimetres_is_said_and_not_what_follows_from_it():
    """Its limits and home looked like degrees, and nobody named the lead."""
    content = fed(plain_content())
    assert said_of(content) == []
    content["legs"][1]["motor"]["lead"] = -20.0
    assert said_of(content) == [f"legs[1].motor.lead: -20: {MILLIMETRES}?"]
    content = shipped_content("three_prs")
    content["legs"][0]["chain"][0] |= {"lead": 4, "limits": {"position": [-30, 150]}}
    assert said_of(content) == [f"legs[0].chain[0].lead: 4: {MILLIMETRES}?"]


@pytest.mark.parametrize("gear", [{"lead": 0.002}, {"ratio": -0.0003}])
def test_limits_of_a_joint_that_stand_at_a_motor_with_a_gear_are_doubted(gear):
    """A motor in radians with a range or a speed in metres hardly moves."""
    content = shipped_content("three_prs")
    joint, name = content["legs"][0]["chain"][0], next(iter(gear))
    joint |= gear | {"limits": {"position": [-0.1, 0.1], "speed": 0.1}}
    words = (
        rf"legs\[0\]\.chain\[0\]\.limits\.{{}} is .* m{{}} behind the {name}: limits are of the "
    )
    [said] = said_of(content)
    assert re.match(words.format("position: a range of 0.2 .*", ""), said)
    joint["limits"]["position"] = [-1000, 1000]
    [said] = said_of(content)
    assert re.match(words.format("speed: 0.1 .*", "/s"), said)
    joint["limits"]["speed"] = 100.0
    assert said_of(content) == []


@pytest.mark.parametrize("name", CHAINS)
def test_robots_of_chains_are_beyond_doubt(name):
    content = shipped_content(name)
    if content["platform"].get("shape", "body") == "body":
        content["platform"] |= {"mass": 0.3, "inertia": [0.0015, 0.0015, 0.003, 0, 0, 0]}
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        _ = solve_home(load_robot(content))


@pytest.mark.parametrize("written", ["once", "in every chain"])
def test_motors_in_millimetres_are_said_however_rods_are_written(written):
    """Rods of chains may be all there are: what a leg would have without them is much longer."""
    content = shipped_content("three_prs")
    content["home"]["motors"] = [100.0] * 3
    if written == "in every chain":
        for leg in content["legs"]:
            leg["chain"][3] = {"rod": dict(content["rod"])}
        content["rod"] |= {"length": 10.0, "rest_curvature": {}}
    with pytest.warns(DescriptionWarning, match=rf"home\.motors\[0\]: 100: {MILLIMETRES}"):
        read_description(content)
