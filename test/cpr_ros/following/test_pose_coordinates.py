# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Poses and ways between them, in the coordinates a robot controls."""

import numpy as np
import pytest
from helpers.drive import robot
from hypothesis import given, settings
from hypothesis import strategies as st

from cpr_core import kinemato_statics, solve_forward, solve_home
from cpr_ros.following.pose_coordinates import PoseCoordinates, pose_coordinates

NAMES = ["rfrfr", "planar_body", "three_rfs", "six_rfs"]
SPACES = {name: PoseCoordinates(robot(name)) for name in NAMES}
numbers = st.floats(-0.9, 0.9)


def pose(space, values):
    """Any pose, from a way to it; angles are small enough to be unique."""
    return space.moved(space.nowhere, np.array(values[: len(space.way(*2 * [space.nowhere]))]))


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None, max_examples=50)
@given(
    first=st.lists(numbers, min_size=6, max_size=6), last=st.lists(numbers, min_size=6, max_size=6)
)
def test_a_way_leads_from_one_pose_to_the_other(name, first, last):
    space = SPACES[name]
    first, last = pose(space, first), pose(space, last)
    way = space.way(first, last)
    np.testing.assert_allclose(space.way(space.moved(first, way), last), 0.0, atol=1e-12)
    back = space.moved(space.moved(first, way), -way)
    np.testing.assert_allclose(space.way(back, first), 0.0, atol=1e-12)


def test_sizes_are_those_of_what_is_controlled():
    way = np.array([0.3, 0.4])
    assert SPACES["rfrfr"].sizes(way)[0] == pytest.approx(0.5)
    assert np.isnan(SPACES["rfrfr"].sizes(way)[1])
    assert SPACES["three_rfs"].sizes(np.array([-0.2, 0.3, 0.4])) == pytest.approx((0.2, 0.5))
    assert SPACES["three_rfs"].size(np.array([-0.2, 0.0, 0.0])) == pytest.approx(0.25)  # 0.8 m rods
    assert SPACES["six_rfs"].sizes(np.array([0, 3, 0, 0, 0, 4.0])) == pytest.approx((3.0, 4.0))


def test_an_angle_takes_the_short_way():
    space = SPACES["planar_body"]
    way = space.way(np.array([0.0, 0.0, 3.1]), np.array([0.0, 0.0, -3.1]))
    assert way[2] == pytest.approx(2.0 * np.pi - 6.2)


@pytest.mark.parametrize("name", [*NAMES, "gough_stewart"])
def test_motors_by_pose_take_a_way_in_the_order_of_the_axes(name):
    """Two equilibria close to each other: the way between them, and that of their motors."""
    home = solve_home(robot(name))
    tilted = solve_forward(home.robot, home.motors + 0.1 * np.sin(np.arange(len(home.motors))))
    step = 1e-6 * np.cos(np.arange(len(home.motors)))
    before, after = (
        solve_forward(home.robot, tilted.motors + way, start=tilted) for way in (-step, step)
    )
    space = pose_coordinates(home.robot)
    way = space.by_axis(space.way(before.pose, after.pose))
    motors = kinemato_statics(tilted).motors_by_pose @ way
    np.testing.assert_allclose(motors, 2.0 * step, rtol=0.0, atol=1e-11)


def test_the_size_of_a_pose_far_beyond_all_robots_is_finite():
    space = SPACES["rfrfr"]
    assert 1e199 < space.size(space.way(space.nowhere, np.array([1e200, -1e200]))) < np.inf


def test_a_robot_has_one_and_nobody_moves_what_is_nowhere():
    six_rfs = robot("six_rfs")
    assert pose_coordinates(six_rfs) is pose_coordinates(six_rfs)
    with pytest.raises(ValueError, match="read-only"):
        pose_coordinates(six_rfs).nowhere[0] = 1.0


@pytest.mark.parametrize("name", NAMES)
def test_the_velocity_of_a_twist_is_that_of_the_pose(name):
    """Two equilibria close to each other, and the twist between them from the Jacobian."""
    space, home = SPACES[name], solve_home(robot(name))
    tilted = solve_forward(home.robot, home.motors + 0.1 * np.sin(np.arange(len(home.motors))))
    step = 1e-6 * np.cos(np.arange(len(home.motors)))
    ahead = solve_forward(home.robot, tilted.motors + step, start=tilted)
    rotation = tilted.platform_rotation
    body = np.zeros(6)
    body[home.robot.platform_axes] = kinemato_statics(tilted).jacobian @ step
    twist = np.concatenate([rotation @ body[:3], rotation @ body[3:]])
    expected = space.way(tilted.pose, ahead.pose)
    np.testing.assert_allclose(space.velocity(twist, rotation), expected, rtol=0.0, atol=1e-10)
