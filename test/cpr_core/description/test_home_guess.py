# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Home as it is described: sides that rods are bowed to, and a rough pose."""

import warnings

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, DescriptionWarning, load_robot, solve_home
from cpr_core.description.description_file import read_description, shipped_robots


def test_one_vector_is_the_side_of_all_rods():
    content = shipped_content("rfrfr")
    content["home"] = {"motors": [1.7, 1.4], "bow": [1, 0, 0]}
    robot = load_robot(content)
    content["home"]["bow"] = [[1, 0, 0], [1, 0, 0]]
    for side, same in zip(
        robot.description.home.bow, load_robot(content).description.home.bow, strict=True
    ):
        np.testing.assert_array_equal(side, same)
        assert side[0] > 0.9
    content["home"]["bow"] = [0, 0, 1]
    with pytest.raises(DescriptionError, match=r"home\.bow: expected z = 0"):
        load_robot(content)


def test_one_vector_is_the_side_of_all_rods_in_space():
    content = shipped_content("gough_stewart")
    content["home"]["bow"] = [0, 0, 1]
    with pytest.raises(DescriptionError, match=r"home\.bow: .*across the tangent of leg1"):
        load_robot(content)
    content = shipped_content("three_rfs")
    content["home"] = {"motors": [0.0] * 3, "bow": [0, 0, 1]}
    for side in load_robot(content).description.home.bow:
        np.testing.assert_allclose(side, [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize("size", [1e-7, 1e-3, 3.0])
@pytest.mark.parametrize("side", ["outward", "inward", [2e-7, 0.0, 1e-7]])
def test_sides_of_rods_do_not_depend_on_the_size_of_a_robot(size, side):
    content = shipped_content("rfrfr")
    content["home"]["bow"] = side if isinstance(side, str) else [side[0], side[2], 0.0]
    same = read_description(content).home.bow
    content["rod"]["length"] *= size
    content["rod"]["section"]["radius"] *= size
    for leg in content["legs"]:
        leg["base"]["position"] = [size * number for number in leg["base"]["position"]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)  # of micrometres, or kilometres
        bows = read_description(content).home.bow
    np.testing.assert_allclose(bows, same, atol=1e-9)


@pytest.mark.parametrize("size", [1e-7, 1.0])
def test_there_is_no_outside_in_the_middle_of_the_bases(size):
    content = shipped_content("rfrfr")
    content["rod"]["length"] *= size
    content["rod"]["section"]["radius"] *= size
    for leg, noise in zip(content["legs"], (1e-17, -1e-17), strict=True):
        leg["base"]["position"] = [size * noise, 0.0, 0.0]
    content["home"]["bow"] = "outward"
    with (
        warnings.catch_warnings(),
        pytest.raises(DescriptionError, match=r"home\.bow: expected a side across"),
    ):
        warnings.simplefilter("ignore", DescriptionWarning)
        read_description(content)


def test_a_rough_pose_far_from_home_is_said():
    content = shipped_content("rfrfr")
    content["home"]["platform"] = {"position": [0, 1.2, 0]}
    with warnings.catch_warnings():
        warnings.simplefilter("error", DescriptionWarning)
        _ = solve_home(load_robot(content))
    content["home"]["platform"] = {"position": [0, 3.0, 0]}
    robot = load_robot(content)
    with pytest.warns(
        DescriptionWarning, match=r"home\.platform\.position: .* is 2\.16 m from there"
    ):
        home = solve_home(robot)
    assert home.converged


def test_planar_homes_bend_in_the_plane(file):
    text = shipped_robots()["rfrfr"].read_text()
    with pytest.raises(DescriptionError, match=r"home\.strain\[0\]: a planar robot bends"):
        load_robot(file(text.replace("bow: outward", "strain: [{bending_2: [-2.0]}, {}]")))


def test_strain_at_home_is_that_of_every_leg():
    content = shipped_content("rfrfr")
    content["home"] = {"motors": [1.7, 1.4], "strain": [{"bending_3": [1.0]}]}
    with pytest.raises(DescriptionError, match=r"home\.strain: expected 2 entries, .* got 1"):
        load_robot(content)


def test_a_fed_rod_has_a_length_at_home():
    content = shipped_content("gough_stewart")
    for leg in content["legs"]:
        leg["motor"].pop("limits")
    content["home"]["motors"][2] = 0.0
    with pytest.raises(
        DescriptionError, match=r"home\.motors: expected positive rod lengths, got 0"
    ):
        load_robot(content)


def test_where_a_joint_with_a_motor_is_at_home_its_motor_says():
    content = shipped_content("delta")
    content["home"]["joints"] = {"leg1.joint1": 0.1}
    with pytest.raises(DescriptionError, match=r"motor1 moves it: give home\.motors"):
        load_robot(content)
