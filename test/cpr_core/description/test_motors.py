# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What motors can do, as descriptions say it: limits that make no sense are refused by name."""

import math

import pytest
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot
from cpr_core.description.description_file import read_description


def with_limits(name, limits):
    content = shipped_content(name)
    content["legs"][1]["motor"]["limits"] = limits
    return load_robot(content)


@pytest.mark.parametrize(
    ("name", "position", "problem"),
    [
        ("gough_stewart", [-0.1, 1.0], "expected a positive length, got -0.1"),
        ("gough_stewart", [0.0, 1.0], "expected a positive length, got 0"),
        ("rfrfr", [1.0, 1.0], "expected lower below upper"),
        ("rfrfr", [1.0, -1.0], "expected lower below upper"),
    ],
)
def test_position_limits_that_make_no_sense_are_refused(name, position, problem):
    with pytest.raises(DescriptionError, match=problem) as caught:
        with_limits(name, {"position": position})
    assert "legs[1].motor.limits.position" in str(caught.value)


def test_a_name_of_two_motors_is_said_to_be_that_of_a_motor_at_its_leg():
    """It was said to be that of a leg, and after a passive base another leg was named."""
    content = shipped_content("gough_stewart")
    content["legs"][0]["motor"] = {"type": "welded"}
    for number in (1, 3):
        content["legs"][number]["motor"]["name"] = "feed"
    with pytest.raises(
        DescriptionError, match="'feed' is the name of an earlier motor already"
    ) as caught:
        read_description(content)
    assert caught.value.field == "legs[3].motor.name"
    assert "one that moves several legs is written in a chain of each" in caught.value.problem
    content["legs"][4]["name"] = "leg1"
    with pytest.raises(
        DescriptionError, match=r"legs\[4\]\.name: 'leg1' .* an earlier leg already$"
    ):
        read_description(content)


def test_limits_are_those_of_the_motor_they_are_given_for():
    robot = with_limits("rfrfr", {"position": [-1.5, 2.5], "effort": 3.0, "speed": 0.5})
    first, second = (leg.drive.limits for leg in robot.description.legs)
    assert (first.lower, first.upper, first.effort, first.speed) == (
        -float("inf"),
        float("inf"),
        float("inf"),
        float("inf"),
    )
    assert (second.lower, second.upper, second.effort, second.speed) == (-1.5, 2.5, 3.0, 0.5)


def test_a_lower_limit_below_zero_is_fine_where_it_is_no_length():
    robot = with_limits("rfrfr", {"position": [-1.0, 1.0]})
    assert robot.description.legs[1].drive.limits.lower == -1.0


def with_gear(kind, gear):
    """A robot whose first motor is of the short form, or in a chain, with a gear or a screw."""
    content = shipped_content(kind)
    leg = content["legs"][0]
    (leg["chain"][0] if "chain" in leg else leg["motor"]).update(gear)
    return content


@pytest.mark.parametrize("value", [1e308, -1e308, 1e31, 9.9999999e-31, -1e-320])
@pytest.mark.parametrize(
    ("name", "field", "path"),
    [
        ("rfrfr", "ratio", "legs[0].motor.ratio"),
        ("six_rus", "ratio", "legs[0].chain[0].ratio"),
        ("three_prs", "lead", "legs[0].chain[0].lead"),
    ],
)
def test_ratios_and_leads_that_nothing_can_be_computed_with_are_refused(name, field, path, value):
    with pytest.raises(DescriptionError) as caught:
        read_description(with_gear(name, {field: value}))
    text = str(caught.value)
    assert f"{path}: expected a number from 1e-30 to 1e+30" in text
    assert f"got {value}" in text


@pytest.mark.parametrize("value", [1e-30, -1e30, 2.0 * math.pi / 2**32])
def test_ratios_of_any_use_are_not_refused(value):
    content = with_gear("rfrfr", {"ratio": value})
    content["home"]["motors"][0] /= value
    legs = read_description(content).legs
    assert legs[0].chain[0].ratio == value


def test_a_way_per_turn_and_a_ratio_are_not_both_said():
    content = shipped_content("three_prs")
    content["legs"][0]["chain"][0] |= {"lead": 0.005, "ratio": 2.0}
    with pytest.raises(DescriptionError, match="a motor that turns has a lead, one that shifts"):
        load_robot(content)


def test_a_motor_does_not_turn_at_one_joint_and_shift_at_another():
    content = shipped_content("three_prs")
    for leg, gear in zip(content["legs"], ({"lead": 0.5}, {}, {}), strict=True):
        leg["chain"][0].pop("limits", None)
        leg["chain"][0] |= {"motor": "both"} | gear
    content |= {"controlled": ["z"], "home": {"motors": [0.1], "bow": "outward"}}
    with pytest.raises(DescriptionError, match="motor 'both' cannot turn at one joint"):
        load_robot(content)


def test_as_many_coordinates_are_controlled_as_motors_can():
    content = shipped_content("six_rfs")
    content["controlled"] = ["x", "y", "z", "roll", "pitch"]
    with pytest.raises(DescriptionError, match=r"controlled: expected 6 coordinates, .* got 5"):
        load_robot(content)
