# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Straight ways to motor positions and platform poses."""

from types import SimpleNamespace

import numpy as np
import pytest
from helpers.drive import robot
from hypothesis import given
from hypothesis import strategies as st

from cpr_core import solve_forward, solve_home
from cpr_core.lie import rotation_log
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.motor_ways import motor_steps


def test_motors_go_straight_and_arrive_exactly():
    home = solve_home(robot("rfrfr"))
    goal = MotorGoal(home.robot, home.motors + [0.02, -0.01])
    assert goal.remaining(home) == pytest.approx(0.02)
    half = goal.solve(home, 0.5, home.loads)
    np.testing.assert_allclose(half.motors, home.motors + [0.01, -0.005], atol=1e-15)
    arrived = goal.solve(half, 1.0, home.loads)
    assert goal.remaining(arrived) == 0.0


def test_a_motor_that_is_not_asked_to_move_stays_to_the_last_bit():
    """Its commands trembled by one bit while another motor went."""
    six = robot("six_rfs")
    start = solve_forward(six, solve_home(six).motors + [0.1, 0.07, 0.03, -0.1, -0.07, 0.01])
    goal = MotorGoal(six, start.motors + [0.5, 0, 0, 0, 0, 0])
    for fraction in np.linspace(0.01, 0.99, 99):
        np.testing.assert_array_equal(goal.at(start, fraction)[1:], start.motors[1:])


def test_a_setpoint_beyond_the_range_is_clipped_and_named():
    planar = robot("planar_body")
    goal = MotorGoal(planar, [-3.0, 0.0, 1.5])
    np.testing.assert_array_equal(goal.motors, [-1.5, 0.0, 1.5])
    assert goal.clipped == (planar.motor_names[0],)


@pytest.mark.parametrize("name", ["rfrfr", "planar_body", "three_rfs", "six_rfs", "gough_stewart"])
def test_the_platform_goes_straight_in_its_controlled_coordinates(name):
    home = solve_home(robot(name))
    change = 0.01 * home.robot.motor_units * np.sin(1.0 + np.arange(home.robot.motor_count))
    away = solve_forward(home.robot, home.motors + change)
    goal = PoseGoal(home.robot, away.pose)
    assert 0.0 < goal.remaining(home) < 0.2
    part = goal.solve(home, 0.25, home.loads)
    assert goal.remaining(part) == pytest.approx(0.75 * goal.remaining(home), rel=1e-6)
    arrived = goal.solve(part, 1.0, home.loads)
    assert goal.remaining(arrived) < 1e-9
    np.testing.assert_allclose(arrived.motors, away.motors, atol=1e-7)


@pytest.mark.parametrize("name", ["rfrfr", "delta", "gough_stewart"])
def test_a_rod_length_of_way_is_one_however_long_rods_are(name):
    home = solve_home(robot(name))
    away = home.pose + home.robot.mean_length * np.eye(len(home.pose))[0]
    assert PoseGoal(home.robot, away).remaining(home) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("name", "place", "height"), [("three_rfs", 0, 739.0), ("rfrfr", 1, 839.0)]
)
def test_millimetres_are_told_by_the_coordinates_a_robot_controls(name, place, height):
    """What it does not control is where it is; and what is near a pose it was sent to is meant."""
    home = solve_home(robot(name))
    far = PoseGoal(home.robot, home.pose + height * np.eye(len(home.pose))[place])
    assert far.doubt(home, None).endswith("looks like millimetres, expected metres")
    assert far.doubt(home, MotorGoal(home.robot, home.motors)) == far.doubt(home, None)
    assert not far.doubt(home, far.at(far.pose - 0.1))
    assert not PoseGoal(home.robot, home.pose + 0.1).doubt(home, far)


def test_degrees_are_told_of_what_was_asked_for_and_not_of_the_range_it_was_taken_into():
    home = solve_home(robot("planar_body"))
    asked = [60.0, 0.0, 0.0]
    assert "motor1 at 60 looks like degrees" in MotorGoal(home.robot, asked).doubt(home, None)
    assert not MotorGoal(home.robot, [6.0, 0.0, 0.0]).doubt(home, None)


def test_what_is_left_is_that_of_another_start_and_of_another_pose():
    home = solve_home(robot("rfrfr"))
    away = solve_forward(home.robot, home.motors + [0.02, -0.01])
    goal = PoseGoal(home.robot, away.pose)
    far = goal.remaining(home)
    assert goal.remaining(away) == 0.0
    assert goal.remaining(home) == far
    goal.pose = home.pose  # as a twist moves it on
    assert goal.remaining(home) == 0.0
    assert goal.at(away.pose).remaining(home) == far
    assert goal.remaining(home) == 0.0


def test_the_orientation_turns_about_one_axis():
    home = solve_home(robot("six_rfs"))
    away = solve_forward(home.robot, home.motors + [0.1, -0.1, 0.05, 0.0, -0.05, 0.1])
    goal = PoseGoal(home.robot, away.pose)
    whole = rotation_log(away.platform_rotation @ home.platform_rotation.T)
    part = goal.solve(home, 0.3, home.loads)
    turned = rotation_log(part.platform_rotation @ home.platform_rotation.T)
    np.testing.assert_allclose(turned, 0.3 * whole, atol=1e-9)


def test_angles_take_the_short_way():
    planar = solve_home(robot("planar_body"))
    pose = planar.pose
    names = list(planar.robot.description.controlled)
    pose[names.index("angle")] += 2.0 * np.pi - 0.05
    assert PoseGoal(planar.robot, pose).remaining(planar) == pytest.approx(0.05)


def test_a_motor_keeps_its_own_speed_limit():
    np.testing.assert_allclose(motor_steps(robot("planar_body"), 5.0, 0.01), 0.02)  # its 2 rad/s
    np.testing.assert_allclose(motor_steps(robot("planar_body"), 1.0, 0.01), 0.01)
    np.testing.assert_allclose(motor_steps(robot("rfrfr"), 0.5, 0.01), 0.005)


places = st.floats(-3.0, 3.0)


@given(begin=places, end=places, stays=places, part=st.floats(0.0, 1.0))
def test_motors_that_stay_are_not_moved_by_rounding(begin, end, stays, part):
    """One at its limit was sent 3e-16 beyond it, which was a halt at the end of its way."""
    rfrfr = robot("rfrfr")
    start = SimpleNamespace(motors=np.array([begin, stays]))
    first, second = MotorGoal(rfrfr, [end, stays]).at(start, part)
    assert second == stays
    assert min(begin, end) <= first <= max(begin, end)


@pytest.mark.parametrize(("beyond", "clipped"), [(3e-10, ()), (1e-8, ("motor1",))])
def test_a_motor_beyond_its_range_by_the_accuracy_of_a_solution_is_at_its_end(beyond, clipped):
    """A pose may have left it there: goals of other motors were refused for it."""
    goal = MotorGoal(robot("three_prs"), [0.25 + beyond, 0.2, 0.2])
    assert goal.motors.tolist() == [0.25, 0.2, 0.2]
    assert goal.clipped == clipped
