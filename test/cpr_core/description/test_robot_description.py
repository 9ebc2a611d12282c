# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The shipped robots of the paper: what is read of them, by name, by file and by content."""

import math
from copy import deepcopy

import numpy as np
import pytest
from helpers.spoilt_descriptions import ROBOTS, TEXTS, full_content
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose, assert_array_equal

from cpr_core import DescriptionError, load_robot, solve_home
from cpr_core.description.description_file import read_description, shipped_robots
from cpr_core.lie import rotation_exp


@pytest.mark.parametrize("name", ROBOTS)
def test_shipped_robots_are_found_by_name_by_file_and_by_content(name):
    by_name = read_description(name)
    by_file = read_description(shipped_robots()[name])
    by_text = read_description(str(shipped_robots()[name]))
    by_content = read_description(full_content(name))
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


@pytest.mark.parametrize("name", ["rfrfr", "six_rus", "three_rfr_hubs"])
def test_a_robot_whose_legs_all_have_a_rod_needs_none_for_all(name):
    content = shipped_content(name)
    expected, rod = load_robot(deepcopy(content)), content.pop("rod")
    for leg in content["legs"]:
        leg["rod"] = deepcopy(leg.get("rod", rod))
    assert_array_equal(solve_home(load_robot(content)).state, solve_home(expected).state)
    del content["legs"][1]["rod"]
    with pytest.raises(DescriptionError, match=r"missing field 'rod': legs\[1\] has none"):
        load_robot(content)


def test_a_robot_whose_rods_are_all_described_in_chains_needs_no_other():
    content = shipped_content("three_rfr_hubs")
    expected, rod = load_robot(deepcopy(content)), content.pop("rod")
    chains = [leg["chain"] for leg in content["legs"]]
    rods = [element for chain in chains for element in chain if "rod" in element]
    for element in rods:
        element["rod"] = rod | element["rod"]
    assert_array_equal(solve_home(load_robot(content)).state, solve_home(expected).state)
    chains[0].append({"rod": {}})  # of which nothing is known: not another of the first
    with pytest.raises(DescriptionError, match=r"legs\[0\]\.chain\[.\]\.rod.*: missing field"):
        load_robot(content)
