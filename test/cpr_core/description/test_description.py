# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robot descriptions: the shipped ones, and every way to get one wrong."""

import copy
import math
import re

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from cpr_core import solve_home
from cpr_core.description.description_file import read_description, shipped_robots
from cpr_core.description.robot_description import RobotDescription
from cpr_core.errors import CprError, DescriptionError, InvalidRequest
from cpr_core.lie import rotation_exp
from cpr_core.model.robot import Robot
from cpr_core.solving.geometrico_statics import solve_forward
from cpr_core.solving.load_robot import load_robot

ROBOTS = ["rfrfr", "six_rfs"]
TEXTS = {name: path.read_text(encoding="utf-8") for name, path in shipped_robots().items()}


def plain(text):
    """Content of a file, read by plain PyYAML."""
    return yaml.safe_load(text)


CONTENTS = {name: plain(TEXTS[name]) for name in ROBOTS}
#: Everything that may be said of a home.
CONTENTS["rfrfr"]["home"] |= {
    "platform": {"position": [0.0, 0.84, 0]},
    "strain": [{"bending_3": [-2.0, 0.0]}, {"bending_3": [2.0, 0.0]}],
}
CONTENTS["six_rfs"]["home"] |= {
    "platform": {
        "position": [0.036, 0.013, 0.845],
        "quaternion_wxyz": [0.9434, -0.0406, -0.0496, 0.3255],
    },
    "strain": [{"bending_2": [-2.0]} for _ in range(6)],
}
#: A planar robot with a platform that turns.
CONTENTS["planar_body"] = copy.deepcopy(CONTENTS["rfrfr"]) | {"platform": {"shape": "body"}}


@pytest.fixture
def rfrfr():
    return copy.deepcopy(CONTENTS["rfrfr"])


@pytest.fixture
def six_rfs():
    return copy.deepcopy(CONTENTS["six_rfs"])


def content_of(name):
    return copy.deepcopy(CONTENTS[name])


def put(content, path, value):
    """Set what is at a path such as ``("legs", 0, "motor", "axis")``."""
    for part in path[:-1]:
        content = content[part]
    content[path[-1]] = value


def remove(content, path):
    for part in path[:-1]:
        content = content[part]
    del content[path[-1]]


def written(path):
    """A path as messages write it."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def refused(robot, field, *expected):
    """The error of a description, with source, field and hints in its text."""
    with pytest.raises(DescriptionError) as caught:
        read_description(robot)
    error = caught.value
    source = robot["name"] if isinstance(robot, dict) and "name" in robot else str(robot)
    if not isinstance(robot, dict) or "name" in robot:
        assert error.source == source
    assert error.field == field
    assert error.code == "INVALID_DESCRIPTION"
    text = str(error)
    assert text.startswith(f"{error.source}: {field}: " if field else f"{error.source}: ")
    for hint in expected:
        assert hint in text
    return error


@pytest.fixture
def file(tmp_path):
    """Write a file and give its path."""

    def write(content):
        path = tmp_path / "robot.yaml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


# The shipped robots.


@pytest.mark.parametrize("name", ROBOTS)
def test_shipped_robots_are_found_by_name_by_file_and_by_content(name):
    by_name = read_description(name)
    by_file = read_description(shipped_robots()[name])
    by_text = read_description(str(shipped_robots()[name]))
    by_content = read_description(content_of(name))
    assert by_name.text == by_file.text == by_text.text == TEXTS[name]
    assert by_name.source == str(shipped_robots()[name])
    assert by_content.source == name
    for description in (by_name, by_file, by_text, by_content):
        assert description.name == name
        for leg, same in zip(by_name.legs, description.legs, strict=True):
            assert leg.rod.length == same.rod.length
            assert np.array_equal(leg.rod.rigidities, same.rod.rigidities)
            assert leg.rod.mass_per_length == same.rod.mass_per_length
            assert leg.motor == same.motor
            assert leg.joint == same.joint
            assert leg.modes == same.modes
            assert np.array_equal(leg.base_position, same.base_position)
            assert np.array_equal(leg.base_rotation, same.base_rotation)


@pytest.mark.parametrize("name", ROBOTS)
def test_both_robots_have_the_rods_of_the_paper_and_no_loads(name):
    description = read_description(name)
    assert description.gravity.tolist() == [0.0, 0.0, 0.0]
    assert description.platform_mass == 0.0
    for leg in description.legs:
        rod = leg.rod
        assert (rod.length, rod.section.radius, rod.density) == (1.0, 0.001, 7800.0)
        assert (rod.young_modulus, rod.shear_modulus) == (210e9, 82e9)
        bending = math.pi * 0.001**4 / 4.0
        assert_allclose(
            rod.rigidities,
            [82e9 * 2.0 * bending, 210e9 * bending, 210e9 * bending],
            rtol=1e-14,
        )


def test_rfrfr_is_the_planar_robot_of_the_paper():
    description = read_description("rfrfr")
    assert description.planar
    assert description.point_platform
    assert description.controlled == ("x", "y")
    assert description.motor_names == ("motor1", "motor2")
    assert description.home.motors.tolist() == [2.59, 0.55]
    for leg, x in zip(description.legs, (-0.2, 0.2), strict=True):
        assert leg.base_position.tolist() == [x, 0.0, 0.0]
        assert leg.modes.counts == (0, 0, 5)
        assert leg.joint.position == (0.0, 0.0, 0.0)
        assert len(leg.joint.orientation(planar=True)) == 0
        # The motor is the angle of the base tangent from the x axis.
        for angle in (0.0, 0.7, 2.59):
            turned = rotation_exp(angle * np.array(leg.motor.axis)) @ leg.base_rotation
            expected = [math.cos(angle), math.sin(angle), 0.0]
            assert_allclose(turned[:, 0], expected, rtol=0.0, atol=1e-15)


def test_six_rfs_is_the_spatial_robot_of_the_paper():
    description = read_description("six_rfs")
    assert not description.planar
    assert not description.point_platform
    assert description.controlled == ("x", "y", "z", "orientation")
    assert description.motor_names == tuple(f"motor{k}" for k in range(1, 7))
    assert description.home.motors.tolist() == [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]
    vertical = np.array([0.0, 0.0, 1.0])
    for index, leg in enumerate(description.legs):
        g = (0.0, 2.0 * math.pi / 3.0, -2.0 * math.pi / 3.0)[index // 2]
        a = g - math.pi / 3.0 if index % 2 == 0 else g + math.pi / 3.0
        radial = np.array([math.cos(g), math.sin(g), 0.0])
        tip = 0.1 * np.array([math.cos(a), math.sin(a), 0.0])
        assert leg.modes.counts == (0, 5, 5)
        assert_allclose(leg.base_position, 0.25 * radial, rtol=0.0, atol=1e-15)
        assert_allclose(leg.joint.position, tip, rtol=0.0, atol=1e-15)
        assert_allclose(leg.motor.axis, np.cross(vertical, radial), rtol=0.0, atol=1e-15)
        assert len(leg.joint.orientation(planar=False)) == 0
        for q in (0.0, 0.4, 5.86):
            turned = rotation_exp(q * np.array(leg.motor.axis)) @ leg.base_rotation
            tangent = math.cos(q) * radial - math.sin(q) * vertical
            assert_allclose(turned[:, 0], tangent, rtol=0.0, atol=2e-15)


@pytest.mark.parametrize("name", ROBOTS)
def test_base_frames_are_rotations(name):
    for leg in read_description(name).legs:
        frame = leg.base_rotation
        assert_allclose(frame.T @ frame, np.eye(3), rtol=0.0, atol=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_number_of_modes_is_replaced_where_there_are_any(name):
    description = read_description(name).with_modes(8)
    for leg, before in zip(description.legs, read_description(name).legs, strict=True):
        assert leg.modes.counts == tuple(8 if count else 0 for count in before.modes.counts)


@pytest.mark.parametrize("modes", [0, -3])
def test_no_modes_are_refused(modes):
    with pytest.raises(CprError, match=f"modes: expected at least 1, got {modes}"):
        load_robot("rfrfr", modes=modes)


@pytest.mark.parametrize("modes", [True, 4.0, math.nan, "4", [4]])
def test_a_number_of_modes_is_a_whole_number(modes):
    told = re.escape(f"modes: expected a whole number, got {modes!r}")
    with pytest.raises(InvalidRequest, match=told):
        load_robot("rfrfr", modes=modes)


def test_a_number_of_modes_may_come_from_an_array():
    assert (
        load_robot("rfrfr", modes=np.int64(4)).state_size == load_robot("rfrfr", modes=4).state_size
    )


# Numbers.


@pytest.mark.parametrize(
    "number",
    ["210e9", "2.1e11", "2.1e+11", "21E10", "210000000000", "210_000_000_000.0", "+2.1e11"],
)
def test_numbers_are_read_as_people_write_them(file, number):
    text = TEXTS["rfrfr"].replace("210.0e+9", number)
    assert number in text
    path = file(text)
    assert read_description(path).legs[0].rod.young_modulus == 2.1e11


@pytest.mark.parametrize("number", ["1e-3", ".1e-2", "0.001", "1.e-3", "10.0E-4"])
def test_small_numbers_too(file, number):
    path = file(TEXTS["rfrfr"].replace("radius: 0.001", f"radius: {number}"))
    assert read_description(path).legs[0].rod.section.radius == 1e-3


@pytest.mark.parametrize("modes", ["5.0", "5e0"])
def test_a_whole_number_written_as_a_float_counts_modes(file, modes):
    path = file(TEXTS["rfrfr"].replace("bending_3: 5}", f"bending_3: {modes}}}"))
    try:
        robot = Robot(read_description(path))
    except DescriptionError as error:
        assert error.field == "strain.bending_3"  # refusing it would do as well
    else:
        assert robot.arrays.elastic.shape == (1, 5, 5)


# Fields.

UNKNOWN = [(), ("rod",), ("rod", "section"), ("strain",), ("platform",), ("legs", 1)]
UNKNOWN += [("legs", 0, part) for part in ("base", "motor", "tip")]
UNKNOWN += [("home",), ("home", "platform"), ("home", "strain", 1)]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("path", UNKNOWN, ids=written)
def test_unknown_fields_are_named_with_the_known_ones(name, path):
    content = content_of(name)
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
    content = content_of(name)
    remove(content, path)
    refused(content, written(path[:-1]), f"missing field {path[-1]!r}")


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize(
    "path", [("strain",), ("gravity",), ("platform", "mass"), ("rod", "density")]
)
def test_optional_fields_may_be_missing(name, path):
    content = content_of(name)
    remove(content, path)
    assert read_description(content).name == name


NUMBERS = [("rod", "length"), ("rod", "section", "radius"), ("rod", "young_modulus")]
NUMBERS += [("rod", "density"), ("platform", "mass"), ("home", "motors", 1), ("gravity", 0)]
NUMBERS += [("legs", 1, "base", "position", 0), ("legs", 0, "motor", "axis", 2)]
NUMBERS += [("legs", 1, "tip", "position", 1), ("home", "platform", "position", 1)]


@pytest.mark.parametrize("value", ["long", "1 mm", True, None, [], {}, [1.0]], ids=repr)
@pytest.mark.parametrize("path", NUMBERS, ids=written)
def test_what_is_no_number_is_refused(rfrfr, path, value):
    put(rfrfr, path, value)
    refused(rfrfr, written(path), "expected number", repr(value))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("path", NUMBERS, ids=written)
def test_numbers_that_are_not_finite_are_refused(rfrfr, path, value):
    put(rfrfr, path, value)
    refused(rfrfr, written(path), "expected a finite number", str(value))


@pytest.mark.parametrize("word", [".nan", ".inf", "-.inf", "1e400"])
def test_numbers_that_are_not_finite_are_refused_in_files(file, word):
    path = file(TEXTS["rfrfr"].replace("radius: 0.001", f"radius: {word}"))
    refused(path, "rod.section.radius", "expected a finite number")


def test_arrays_that_are_no_numbers_of_yaml_are_refused(rfrfr):
    """Numbers of files for arrays come as arrays without dimensions."""
    for value in (np.array(0.5), np.array([0.5]), np.array("long")):
        rfrfr["rod"]["length"] = value
        with pytest.raises(DescriptionError, match=r"rod\.length: expected number, got array"):
            load_robot(rfrfr)


def test_nan_of_numpy_is_refused_too(rfrfr):
    put(rfrfr, ("rod", "density"), np.float32("nan"))
    with pytest.raises(DescriptionError, match=r"rod\.density"):
        read_description(rfrfr)


@pytest.mark.parametrize("value", [0, 0.0, -1, -0.001])
@pytest.mark.parametrize(
    "path", [p for p in NUMBERS if p[0] == "rod" and p[-1] != "density"], ids=written
)
def test_lengths_and_moduli_are_positive(rfrfr, path, value):
    put(rfrfr, path, value)
    refused(rfrfr, written(path), "expected a number above 0", f"got {value}")


@pytest.mark.parametrize("path", [("rod", "density"), ("platform", "mass")], ids=written)
def test_masses_are_not_negative(rfrfr, path):
    put(rfrfr, path, -1e-3)
    refused(rfrfr, written(path), "expected a number of at least 0", "got -0.001")


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


@pytest.mark.parametrize(
    ("value", "hint"), [(-1, "at least 0"), (41, "at most 40"), (2.5, "integer"), ("5", "integer")]
)
def test_mode_counts_are_small_whole_numbers(rfrfr, value, hint):
    put(rfrfr, ("strain", "bending_3"), value)
    refused(rfrfr, "strain.bending_3", hint, str(value))


@pytest.mark.parametrize("name", ROBOTS)
def test_at_least_one_mode_is_needed(name):
    content = content_of(name)
    content["strain"] = {"torsion": 0, "bending_2": 0, "bending_3": 0}
    refused(content, "strain", "expected at least one mode")


@pytest.mark.parametrize("which", ["torsion", "bending_2"])
def test_planar_robots_bend_in_the_plane(rfrfr, which):
    rfrfr["strain"][which] = 1
    refused(rfrfr, "strain", "bends about d3 only", "bending_3")


VECTORS = [("gravity",), ("legs", 0, "base", "position"), ("legs", 1, "base", "tangent")]
VECTORS += [("legs", 1, "motor", "axis"), ("legs", 0, "tip", "position")]
VECTORS += [("home", "platform", "position")]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("value", [[], [1.0], [1.0, 0.0], [1.0, 0.0, 0.0, 0.0]], ids=len)
@pytest.mark.parametrize("path", VECTORS, ids=written)
def test_vectors_have_three_entries(name, path, value):
    content = content_of(name)
    put(content, path, value)
    refused(content, written(path), "expected exactly 3 entries", f"got {len(value)}")


@pytest.mark.parametrize("value", ["up", 1.0, {"x": 1.0}, None], ids=repr)
@pytest.mark.parametrize("path", VECTORS, ids=written)
def test_vectors_are_lists(six_rfs, path, value):
    put(six_rfs, path, value)
    refused(six_rfs, written(path), "expected array", repr(value))


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("value", [[0, 0, 0], [0.0, 1e-12, 0.0]], ids=repr)
@pytest.mark.parametrize("path", [p for p in VECTORS if p[-1] in ("axis", "tangent")], ids=written)
def test_directions_have_a_length(name, path, value):
    content = content_of(name)
    put(content, path, value)
    refused(content, written(path), "expected a direction", "length zero", str(value))


@pytest.mark.parametrize("scale", [1e-3, 7.0, 1e6])
def test_directions_need_not_be_unit_vectors(six_rfs, scale):
    plain = read_description(six_rfs)
    for leg in six_rfs["legs"]:
        leg["motor"]["axis"] = [scale * x for x in leg["motor"]["axis"]]
        leg["base"]["tangent"] = [scale * x for x in leg["base"]["tangent"]]
    for leg, same in zip(read_description(six_rfs).legs, plain.legs, strict=True):
        assert_allclose(leg.motor.axis, same.motor.axis, rtol=0.0, atol=1e-15)
        assert_allclose(leg.base_rotation, same.base_rotation, rtol=0.0, atol=1e-15)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("path", [("motor", "axis"), ("base", "tangent")], ids=written)
def test_directions_whose_square_overflows_are_read_or_refused(six_rfs, path):
    put(six_rfs, ("legs", 0, *path), [0.0, 1e200, 0.0])
    try:
        leg = read_description(six_rfs).legs[0]
    except DescriptionError as error:
        assert error.field == written(("legs", 0, *path))
    else:
        direction = leg.motor.axis if path[0] == "motor" else leg.base_rotation[:, 0]
        assert_allclose(direction, [0.0, 1.0, 0.0], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("normal", [[0.0, 0.0, 1.0], [0.0, -3.0, 4.0]])
def test_the_normal_is_the_second_base_vector(six_rfs, normal):
    six_rfs["legs"][0]["base"]["normal"] = normal
    frame = read_description(six_rfs).legs[0].base_rotation
    assert_allclose(frame[:, 1], np.array(normal) / np.linalg.norm(normal), rtol=0.0, atol=1e-15)


def test_the_normal_lies_across_the_tangent(six_rfs):
    six_rfs["legs"][0]["base"]["normal"] = [0.1, 0.0, 1.0]
    refused(six_rfs, "legs[0].base.normal", "across the tangent", "[0.1, 0.0, 1.0]")


def test_the_normal_is_not_given_in_the_plane(rfrfr):
    rfrfr["legs"][1]["base"]["normal"] = [0.0, 1.0, 0.0]
    refused(rfrfr, "legs[1].base.normal", "d2 is z x tangent")


# The plane.

IN_PLANE = [("gravity",), ("platform", "center_of_mass"), ("legs", 0, "base", "position")]
IN_PLANE += [("legs", 1, "base", "tangent"), ("legs", 1, "tip", "position")]
IN_PLANE += [("home", "platform", "position")]


@pytest.mark.parametrize("name", ["rfrfr", "planar_body"])
@pytest.mark.parametrize("path", IN_PLANE, ids=written)
def test_planar_robots_stay_in_the_plane(name, path):
    content = content_of(name)
    put(content, path, [1.0, 0.0, 0.01])
    refused(content, written(path), "expected z = 0 in a planar robot", "[1.0, 0.0, 0.01]")


@pytest.mark.parametrize("axis", [[1, 0, 0], [0.0, 0.1, 1.0]])
def test_planar_motors_turn_about_z(rfrfr, axis):
    rfrfr["legs"][1]["motor"]["axis"] = axis
    refused(rfrfr, "legs[1].motor.axis", "expected +-z in a planar robot", str(axis))


def test_planar_platforms_are_not_tilted():
    content = content_of("planar_body")
    content["home"]["platform"]["quaternion_wxyz"] = [0.6, 0.8, 0.0, 0.0]
    with pytest.raises(DescriptionError, match="quaternion_wxyz"):
        read_description(content)


def test_planar_platforms_turn_in_the_plane():
    content = content_of("planar_body")
    content["home"]["platform"]["quaternion_wxyz"] = [0.6, 0.0, 0.0, 0.8]
    rotation = read_description(content).home.platform_rotation
    expected = [[-0.28, -0.96, 0.0], [0.96, -0.28, 0.0], [0.0, 0.0, 1.0]]
    assert_allclose(rotation, expected, rtol=0.0, atol=1e-15)


def test_points_are_planar(six_rfs):
    six_rfs["platform"] = {"shape": "point"}
    refused(six_rfs, "platform.shape", "needs a planar robot")


# Numbers of things that belong together.


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
    content = content_of(name)
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


# Files.


@pytest.mark.parametrize(
    "text", ["name: [1, 2\n: }", "a: b: c", "'open", "\tname: x", "a: 1\n---\n"]
)
def test_what_is_not_yaml_is_refused_with_its_place(file, text):
    refused(file(text), "", "is not valid YAML", "line ")


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("line", ["name: again\n", "gravity: [0, 0, 0]\n"])
def test_fields_given_twice_are_refused_with_their_place(file, name, line):
    number = TEXTS[name].count("\n") + 1
    refused(file(TEXTS[name] + line), "", line.split(":")[0], "given twice", f"line {number}")


def test_fields_given_twice_are_refused_in_depth(file):
    text = TEXTS["rfrfr"].replace("radius: 0.001}", "radius: 0.001, radius: 0.002}")
    refused(file(text), "", "'radius' is given twice", "line ")


@pytest.mark.parametrize("text", ["", "# nothing\n", "null", "[1, 2]", "rfrfr", "3.0", "- a: 1"])
def test_files_without_fields_are_refused(file, text):
    refused(file(text), "", "expected fields and values, got ")


@pytest.mark.parametrize(
    "content",
    [bytes(range(256)), b"\x7fELF\x02\x01\x01\x00", b"\x89PNG\r\n\x1a\n\xff", b"name: \x00"],
)
def test_binary_files_are_refused(file, content):
    error = refused(file(content), "")
    assert "cannot be read" in error.problem or "is not valid YAML" in error.problem


@pytest.mark.parametrize("robot", ["rfrf", "no/such/file.yaml", "cpr_node", "a\0b"])
def test_missing_files_are_refused_with_the_shipped_robots(robot):
    refused(robot, "", "no such file", "rfrfr", "six_rfs")


@pytest.mark.parametrize("robot", ["", " "])
def test_an_empty_name_is_called_one(robot):
    text = f"^description: expected a name, a file or its content, got {robot!r}$"
    with pytest.raises(DescriptionError, match=text):
        read_description(robot)


def test_directories_are_refused(tmp_path):
    refused(tmp_path, "", "file")


def test_names_too_long_for_a_file_are_refused():
    refused("x" * 300, "")


@pytest.mark.parametrize(
    "text",
    [
        "? [1, 2]\n: 3\n",  # a list as key
        "? {a: 1}\n: 3\n",
        "a: &a [*a]\n",  # contains itself
        "name: 2020-13-45\n",  # a date that is none
        "name: 0b_\n",  # a number that is none
        "name: !!int seven\n",
        "name: !!float seven\n",
        "name: !!python/name:os.system\n",
        "name: !unknown x\n",
        "[" * 5000,
        "name: 1" + "0" * 5000 + "\n",  # more digits than Python turns into a number
    ],
    ids=lambda text: text[:24].strip(),
)
def test_strange_yaml_is_a_description_error(file, text):
    refused(file(text), "")


@pytest.mark.parametrize("word", ["210.0e+9", "length: 1.0", "7800", "-0.2"])
def test_whole_numbers_beyond_floats_are_refused(file, word):
    huge = word.rpartition(" ")[0] + " 1" + "0" * 400
    assert word in TEXTS["rfrfr"]
    path = file(TEXTS["rfrfr"].replace(word, huge, 1))
    with pytest.raises(DescriptionError, match=r"robot\.yaml"):
        read_description(path)


# Descriptions that are read but describe nothing that can be built.

EXTREME = [1e-320, 1e-200, 1e-80, 1e80, 1e200, 1e308]


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("value", EXTREME)
@pytest.mark.parametrize(
    "path", [p for p in NUMBERS if p[0] == "rod" and p[-1] != "density"], ids=written
)
def test_extreme_rods_end_in_an_error_of_the_library(rfrfr, path, value):
    put(rfrfr, path, value)
    try:
        home = solve_home(load_robot(rfrfr))
    except CprError as error:
        assert str(error)
    else:
        assert home.converged
        assert np.all(np.isfinite(home.state))


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("basis", ["legendre", "chebyshev", "monomials"])
def test_bases_span_the_same_shapes(name, basis):
    content = content_of(name)
    content["strain"]["basis"] = basis
    motors = np.array(content["home"]["motors"]) + 0.05
    found = solve_forward(load_robot(content), motors)
    expected = solve_forward(load_robot(name), motors)
    assert_allclose(found.platform_position, expected.platform_position, rtol=0.0, atol=1e-8)


# Fuzzing.

FUZZ = settings(deadline=None, derandomize=True, max_examples=300)
#: Reading YAML takes 20 ms.
FUZZ_FILES = settings(
    FUZZ, max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 50),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["x", "y", "orientation", "planar", "spatial", "body", "point", "revolute"]),
    st.builds(list),
    st.builds(dict),
)
#: Values with which many descriptions still load.
moderate = st.one_of(st.floats(0.1, 10.0), st.integers(0, 6), st.sampled_from([-1.0, 0.0, 5.0]))


@st.composite
def mutated(draw, values):
    """A shipped description with one to three nodes deleted or replaced."""
    # Places are drawn evenly: hypothesis itself would take the first of everything much too often.
    chance = draw(st.randoms(use_true_random=True))
    content = content_of(chance.choice(sorted(CONTENTS)))
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        # Downwards branch by branch: legs have by far the most nodes, but are no more than one.
        path, node = (), content
        while isinstance(node, dict | list) and node and (not path or chance.random() < 0.8):
            path = (
                *path,
                chance.choice(list(node) if isinstance(node, dict) else range(len(node))),
            )
            node = node[path[-1]]
        if not path:
            break
        if chance.random() < 0.2:
            remove(content, path)
        else:
            put(content, path, draw(values))
    return content


@given(mutated(scalars))
@FUZZ
def test_mutated_descriptions_are_read_or_refused(content):
    before = copy.deepcopy(content)
    try:
        description = read_description(content)
    except DescriptionError as error:
        assert error.problem
    else:
        assert isinstance(description, RobotDescription)
    assert repr(content) == repr(before)  # repr, as NaN differs from itself


@given(mutated(scalars))
@FUZZ_FILES
def test_mutated_files_are_read_or_refused(tmp_path, content):
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(content, allow_unicode=True), encoding="utf-8")
    try:
        description = read_description(path)
    except DescriptionError as error:
        assert str(path) in str(error)
    else:
        assert isinstance(description, RobotDescription)


@given(st.sampled_from(ROBOTS), st.data())
@FUZZ_FILES
def test_files_with_other_characters_are_read_or_refused(tmp_path, name, data):
    text = TEXTS[name]
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(text) - 1))
        gone = data.draw(st.integers(0, 12))
        new = data.draw(st.text(alphabet="[]{}:,-&*!?|>'\"%@`#~<=\n\t 0159.eEx_ab", max_size=4))
        text = text[:place] + new + text[place + gone :]
    path = tmp_path / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        description = read_description(path)
    except DescriptionError as error:
        assert str(path) in str(error)
    else:
        assert isinstance(description, RobotDescription)


@given(mutated(moderate))
@FUZZ
def test_what_is_read_can_be_built(content):
    try:
        robot = load_robot(content)
    except DescriptionError:
        return
    try:
        arrays = robot.arrays
    except CprError:
        return
    assert np.all(np.isfinite(robot.strain_stiffness))
    assert np.all(arrays.unit > 0.0)
    assert len(robot.multiplier_indices) + len(robot.elastic_indices) == arrays.platform_index
    assert all(len(unknowns) == len(rows) for unknowns, rows in robot.problems.values())
