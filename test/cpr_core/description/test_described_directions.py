# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Vectors and directions of a description, in space and in the plane."""

import numpy as np
import pytest
from helpers.spoilt_descriptions import ROBOTS, full_content, put, refused, written
from numpy.testing import assert_allclose

from cpr_core.description.description_file import read_description
from cpr_core.errors import DescriptionError

VECTORS = [("gravity",), ("legs", 0, "base", "position"), ("legs", 1, "base", "tangent")]
VECTORS += [("legs", 1, "motor", "axis"), ("legs", 0, "tip", "position")]
VECTORS += [("home", "platform", "position")]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("value", [[], [1.0], [1.0, 0.0], [1.0, 0.0, 0.0, 0.0]], ids=len)
@pytest.mark.parametrize("path", VECTORS, ids=written)
def test_vectors_have_three_entries(name, path, value):
    content = full_content(name)
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
    content = full_content(name)
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
def test_directions_whose_square_overflows_are_read(six_rfs, path):
    put(six_rfs, ("legs", 0, *path), [0.0, 1e200, 0.0])
    leg = read_description(six_rfs).legs[0]
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


IN_PLANE = [("gravity",), ("platform", "center_of_mass"), ("legs", 0, "base", "position")]
IN_PLANE += [("legs", 1, "base", "tangent"), ("legs", 1, "tip", "position")]
IN_PLANE += [("home", "platform", "position")]


@pytest.mark.parametrize("name", ["rfrfr", "planar_body"])
@pytest.mark.parametrize("path", IN_PLANE, ids=written)
def test_planar_robots_stay_in_the_plane(name, path):
    content = full_content(name)
    put(content, path, [1.0, 0.0, 0.01])
    refused(content, written(path), "expected z = 0 in a planar robot", "[1.0, 0.0, 0.01]")


@pytest.mark.parametrize("axis", [[1, 0, 0], [0.0, 0.1, 1.0]])
def test_planar_motors_turn_about_z(rfrfr, axis):
    rfrfr["legs"][1]["motor"]["axis"] = axis
    refused(rfrfr, "legs[1].motor.axis", "expected +-z in a planar robot", str(axis))


def test_planar_platforms_are_not_tilted():
    content = full_content("planar_body")
    content["home"]["platform"]["quaternion_wxyz"] = [0.6, 0.8, 0.0, 0.0]
    with pytest.raises(DescriptionError, match="quaternion_wxyz"):
        read_description(content)


def test_planar_platforms_turn_in_the_plane():
    content = full_content("planar_body")
    content["home"]["platform"]["quaternion_wxyz"] = [0.6, 0.0, 0.0, 0.8]
    rotation = read_description(content).home.platform_rotation
    expected = [[-0.28, -0.96, 0.0], [0.96, -0.28, 0.0], [0.0, 0.0, 1.0]]
    assert_allclose(rotation, expected, rtol=0.0, atol=1e-15)


def test_points_are_planar(six_rfs):
    six_rfs["platform"] = {"shape": "point"}
    refused(six_rfs, "platform.shape", "needs a planar robot")
