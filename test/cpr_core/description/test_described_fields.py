# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Fields of a description: which are known and needed, words and names, and how many belong together."""

import pytest
from helpers.spoilt_descriptions import (
    CONTENTS,
    ROBOTS,
    full_content,
    put,
    refused,
    remove,
    written,
)

from cpr_core.description.description_file import read_description
from cpr_core.errors import DescriptionError

UNKNOWN = [(), ("rod",), ("rod", "section"), ("strain",), ("platform",), ("legs", 1)]
UNKNOWN += [("legs", 0, part) for part in ("base", "motor", "tip")]
UNKNOWN += [("home",), ("home", "platform"), ("home", "strain", 1)]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("path", UNKNOWN, ids=written)
def test_unknown_fields_are_named_with_the_known_ones(name, path):
    content = full_content(name)
    put(content, (*path, "colour"), "red")
    error = refused(content, written(path), "unknown field 'colour'", "expected one of ")
    node = CONTENTS[name]
    for part in path:
        node = node[part]
    assert all(known in error.problem for known in node)


REQUIRED = [("name",), ("space",), ("rod",), ("legs",), ("controlled",), ("home",)]
REQUIRED += [("rod", part) for part in ("length", "section", "young_modulus", "shear_modulus")]
REQUIRED += [("rod", "section", "shape"), ("rod", "section", "radius")]
REQUIRED += [("legs", 1, part) for part in ("base", "motor", "tip")]
REQUIRED += [("legs", 0, "base", "position"), ("legs", 0, "base", "tangent")]
REQUIRED += [
    ("legs", 0, "motor", "axis"),
    ("legs", 1, "tip", "type"),
    ("legs", 1, "tip", "position"),
]
REQUIRED += [("home", "motors")]
REQUIRED += [("home", "platform", "position"), ("legs", 0, "motor", "type")]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("path", REQUIRED, ids=written)
def test_missing_fields_are_named(name, path):
    content = full_content(name)
    remove(content, path)
    refused(content, written(path[:-1]), f"missing field {path[-1]!r}")


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize(
    "path", [("strain",), ("gravity",), ("platform", "mass"), ("rod", "density")]
)
def test_optional_fields_may_be_missing(name, path):
    content = full_content(name)
    remove(content, path)
    assert read_description(content).name == name


@pytest.mark.parametrize(
    ("path", "value", "hint"),
    [
        (("space",), "flat", "planar, spatial"),
        (("strain", "basis"), "fourier", "legendre, chebyshev, monomials"),
        (("rod", "section", "shape"), "square", "circular"),
        (("platform", "shape"), "disc", "point, body"),
        (("legs", 1, "motor", "type"), "stepper", "revolute"),
        (("legs", 0, "tip", "type"), "glue", "spherical, revolute"),
        (("controlled", 1), "height", "x, y, z, angle, orientation"),
    ],
)
def test_names_are_chosen_from_a_list(rfrfr, path, value, hint):
    put(rfrfr, path, value)
    error = refused(rfrfr, written(path), "expected one of ", repr(value))
    for choice in hint.split(", "):
        assert choice in error.problem


def test_a_robot_has_a_leg(rfrfr):
    rfrfr["legs"] = []
    refused(rfrfr, "legs", "expected at least 1 entries", "got 0")


def test_leg_names_are_unique(six_rfs):
    six_rfs["legs"][1]["name"] = six_rfs["legs"][4]["name"] = "left"
    refused(six_rfs, "legs[4].name", "'left'", "earlier")


def test_leg_names_do_not_meet_default_names(six_rfs):
    six_rfs["legs"][3]["name"] = "leg2"
    refused(six_rfs, "legs[3].name", "'leg2'", "earlier")


def test_motor_names_are_unique(six_rfs):
    six_rfs["legs"][0]["motor"]["name"] = six_rfs["legs"][5]["motor"]["name"] = "m"
    refused(six_rfs, "legs[5].motor.name", "'m'", "earlier")


def test_names_are_kept(rfrfr):
    rfrfr["legs"][0]["name"], rfrfr["legs"][1]["motor"]["name"] = "left", "joint_b"
    description = read_description(rfrfr)
    assert [leg.name for leg in description.legs] == ["left", "leg2"]
    assert description.motor_names == ("motor1", "joint_b")


@pytest.mark.parametrize("path", [("name",), ("legs", 0, "name"), ("legs", 0, "motor", "name")])
@pytest.mark.parametrize("value", ["", 7, None])
def test_names_are_texts_with_letters(rfrfr, path, value):
    put(rfrfr, path, value)
    with pytest.raises(DescriptionError) as caught:
        read_description(rfrfr)
    assert caught.value.field == written(path)
    assert repr(value) in str(caught.value)


@pytest.mark.parametrize(
    ("name", "controlled", "hint"),
    [
        ("rfrfr", ["x"], "expected 2 coordinates, as many as motors, got 1"),
        ("planar_body", ["x", "y", "angle"], "expected 2 coordinates, as many as motors, got 3"),
        ("six_rfs", ["x", "y", "z"], "expected 6 coordinates, as many as motors, got 3"),
        ("six_rfs", ["x", "orientation"], "expected 6 coordinates, as many as motors, got 4"),
        ("rfrfr", ["x", "z"], "expected some of x, y, got 'z'"),
        ("rfrfr", ["x", "angle"], "expected some of x, y, got 'angle'"),
        ("planar_body", ["x", "orientation"], "expected some of x, y, angle, got 'orientation'"),
        (
            "six_rfs",
            ["x", "y", "z", "angle"],
            "expected some of x, y, z, orientation, roll, pitch, yaw, got 'angle'",
        ),
        ("rfrfr", ["x", "x"], "expected no entry twice"),
        ("rfrfr", [], "got 0"),
        ("rfrfr", "xy", "expected array, got 'xy'"),
    ],
)
def test_as_many_coordinates_are_controlled_as_there_are_motors(name, controlled, hint):
    content = full_content(name)
    content["controlled"] = controlled
    refused(content, "controlled", hint)


@pytest.mark.parametrize("motors", [[], [2.59], [2.59, 0.55, 0.1]], ids=len)
def test_home_gives_every_motor(rfrfr, motors):
    rfrfr["home"]["motors"] = motors
    refused(rfrfr, "home.motors", "expected 2 numbers, one per motor", f"got {len(motors)}")


@pytest.mark.parametrize("count", [0, 5, 7])
def test_home_gives_the_strain_of_every_leg(six_rfs, count):
    six_rfs["home"]["strain"] = [{"bending_2": [-2.0]}] * count
    refused(six_rfs, "home.strain", "expected 6 entries, one per leg", f"got {count}")


@pytest.mark.parametrize(
    ("quaternion", "hint"),
    [
        ([1.0, 1.0, 0.0, 0.0], "expected unit length, got norm 1.41421"),
        ([0.0, 0.0, 0.0, 0.0], "expected unit length, got norm 0"),
        ([1.0, 0.0, 0.0], "expected exactly 4 entries, got 3"),
    ],
)
def test_home_orientation_is_a_unit_quaternion(six_rfs, quaternion, hint):
    six_rfs["home"]["platform"]["quaternion_wxyz"] = quaternion
    refused(six_rfs, "home.platform.quaternion_wxyz", hint)
