# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Estimates from measurement to measurement, and every reason for which there is none."""

from dataclasses import replace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from helpers.branches import stable_elsewhere
from helpers.drive import robot
from numpy.testing import assert_allclose
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cpr_core import InvalidRequest, NonFiniteInput, solve_forward, solve_home
from cpr_core.lie import quaternion_from_rotation, rotation_exp, rotation_from_quaternion
from cpr_ros.following import felt_wrench
from cpr_ros.following.felt_wrench import FeltWrench, WrenchSettings
from cpr_ros.messages.equilibrium_messages import joint_state
from cpr_ros.messages.frames import Frames
from cpr_ros.messages.geometry import wrench_of
from cpr_ros.messages.wrench_messages import measured_efforts, with_wrench, wrench_estimate

SETTINGS = WrenchSettings(
    effort_deviation=0.005,
    effort_deviation_relative=0.01,
    position_deviation=1e-3,
    rotation_deviation=5e-3,
    max_speed=0.5,
    consistency=1e-6,
    timeout=0.5,
)
PERIOD = 0.005


@pytest.fixture(autouse=True)
def _no_hurry(monkeypatch):
    """An estimate is given up after 20 ms, within which a busy machine may not get to it at all."""
    monkeypatch.setattr(felt_wrench, "_LONGEST", 60.0)


class Measured:
    """A robot that is measured, and a clock that goes one period a measurement."""

    def __init__(self, name="six_rfs", **settings):
        self.robot = robot(name)
        self.home = solve_home(self.robot)
        self.felt = FeltWrench(self.robot, replace(SETTINGS, **settings))
        self.now, self.true = 100.0, self.home

    def push(self, wrench, motors=None):
        self.true = solve_forward(
            self.robot,
            self.true.motors if motors is None else motors,
            start=self.true,
            loads=self.robot.default_loads.with_(wrench_world=wrench),
        )

    def take(self, factor=1.0, age=0.0):
        self.now += PERIOD
        efforts = factor * self.true.efforts
        return self.felt.take(self.true.motors, efforts, self.now - age, self.now, self.home)

    def take_pose(self, shift=0.0, age=0.0):
        pose = np.concatenate([self.true.platform_position, self.true.platform_quaternion])
        pose[0] += shift
        self.felt.take_pose(pose, self.now - age)


def test_a_wrench_is_followed_and_nothing_is_said():
    measured = Measured()
    for step in range(20):
        wrench = 0.05 * np.sin(0.1 * step) * np.array([0.2, 0.0, 0.1, 1.0, 0.5, -1.0])
        measured.push(wrench, measured.home.motors + 1e-3 * step)
        found = measured.take()
        assert_allclose(found.wrench_world, wrench, atol=1e-9)
    assert measured.felt.reason(measured.now) == ""
    assert measured.felt.announcement(measured.now) == ("", "")
    assert not measured.felt.with_pose


def test_a_pose_of_the_same_time_is_used():
    measured = Measured()
    measured.take_pose()
    assert measured.take().degrees_of_freedom == 6 and measured.felt.with_pose
    measured.take_pose(age=0.2)
    assert measured.take().degrees_of_freedom == 0 and not measured.felt.with_pose
    without = Measured(position_deviation=0.0)
    without.take_pose()
    assert without.take().degrees_of_freedom == 0


@pytest.mark.parametrize("late", [18, 6])
def test_a_pose_of_a_moving_robot_counts_as_far_as_it_is_of_the_same_place(late):
    """Of 0.09 s before, at 0.2 rad/s, it was a force of 0.127 N, 8 standard deviations, consistent."""
    measured, ways = Measured(), np.clip(np.arange(-20, 80), 0, 40) * 0.2 * PERIOD
    directions, poses, known = np.where(np.arange(6) % 2, -1.0, 1.0), [], []
    for way in ways:  # it stands, moves and stands
        measured.push(np.zeros(6), measured.home.motors + way * directions)
        place = measured.true
        poses.append(np.concatenate([place.platform_position, place.platform_quaternion]))
        time = measured.now + PERIOD  # of the motors
        measured.felt.take_pose(poses[-1 - late :][0], time - late * PERIOD)
        found = measured.take()
        assert found is not None and found.degrees_of_freedom == 6, measured.felt.reason(time)
        known.append(np.sqrt(np.diag(found.covariance)))
        assert np.abs(found.wrench_world / known[-1]).max() < 1.5
    assert (known[40] / known[0]).max() > 1.5
    assert_allclose(known[-1], known[0], rtol=0.1)


def test_what_one_clock_stamps_ahead_is_of_the_same_time():
    """How old it is nobody knows; that both are equally old is known."""
    measured = Measured()
    measured.take_pose(age=-3.0)
    assert measured.take().degrees_of_freedom == 0 and not measured.felt.with_pose
    measured.take_pose(age=-3.0)
    assert measured.take(age=-3.0).degrees_of_freedom == 6 and measured.felt.with_pose
    measured.push(np.zeros(6), measured.home.motors + 0.05)
    for ahead in (2.0, 1.0):  # a clock that is set right: speeds go by when they came
        found = measured.take(age=-ahead)
    assert found is None and "a motor moves at" in measured.felt.reason(measured.now)


def test_height_and_tilt_of_a_camera_above_a_planar_robot_are_left_aside():
    """It is above the plane and hangs askew; the library refuses what is so far out of it."""
    measured = Measured("planar_body")
    measured.push([0.0, 0.0, 0.02, 0.3, -0.2, 0.0])
    measured.take_pose()
    expected = measured.take()
    assert expected is not None and measured.felt.with_pose
    turned = rotation_from_quaternion(measured.true.platform_quaternion) @ rotation_exp([0.1, 0, 0])
    position = measured.true.platform_position + [0.0, 0.0, 0.4]
    pose = np.concatenate([position, quaternion_from_rotation(turned)])
    measured.felt.take_pose(pose, measured.now)
    found = measured.take()
    assert found is not None, measured.felt.reason(measured.now)
    assert measured.felt.with_pose
    assert_allclose(found.wrench_world, expected.wrench_world, atol=1e-9)


def test_a_pose_that_contradicts_the_efforts_silences():
    measured = Measured()
    measured.take_pose()
    assert measured.take() is not None
    measured.take_pose(shift=0.1)
    assert measured.take() is None
    assert "contradict each other: chi-square" in measured.felt.reason(measured.now)
    measured.take_pose()
    assert measured.take() is not None and measured.felt.reason(measured.now) == ""


def test_efforts_in_other_units_silence():
    measured = Measured()
    assert measured.take(1000.0) is None
    assert "N mm?" in measured.felt.reason(measured.now)
    warning, information = measured.felt.announcement(measured.now)
    assert "N mm?" in warning and information == ""
    for _ in range(10):
        assert measured.take(1000.0) is None
        assert measured.felt.announcement(measured.now) == ("", "")
    measured.now += 0.2
    assert measured.take() is not None
    assert measured.felt.announcement(measured.now) == ("", "the wrench is estimated")


def test_what_comes_and_goes_is_told_once():
    """As a motor whose speed trembles around wrench_max_speed makes it, many times a second."""
    measured = Measured()
    told = []
    for step in range(200):
        measured.now += 0.01
        for kind in ("speed", "search")[: step % 3]:
            measured.felt.refuse(kind, f"reason of {kind}")
            told.append(measured.felt.announcement(measured.now))
        assert measured.take() is not None
        told.append(measured.felt.announcement(measured.now))
    warnings = [f"no wrench is estimated: reason of {kind}" for kind in ("speed", "search")]
    assert [news for news in told if any(news)] == [(warning, "") for warning in warnings]
    measured.now += 0.3
    assert measured.take() is not None
    assert measured.felt.announcement(measured.now) == ("", "the wrench is estimated")
    assert measured.felt.announcement(measured.now) == ("", "")
    measured.felt.refuse("speed", "it moves again")
    assert "it moves again" in measured.felt.announcement(measured.now).warning


def test_nothing_is_told_where_nothing_is_felt():
    measured = Measured(effort_deviation=10.0)
    assert measured.take() is None
    assert "nothing of the wrench is felt" in measured.felt.reason(measured.now)


def test_a_fast_robot_is_not_felt():
    measured = Measured()
    assert measured.take() is not None
    for step in range(1, 5):
        measured.push(np.zeros(6), measured.home.motors + 0.01 * step)
        measured.take()
    assert measured.take() is None
    assert "moves at 2 rad/s or rod lengths/s, more than wrench_max_speed 0.5" in (
        measured.felt.reason(measured.now)
    )
    for _ in range(3):
        found = measured.take()
    assert_allclose(found.wrench_world, 0.0, atol=1e-9)


def test_measurements_without_stamps_may_come_at_once():
    """They are of different times, so no speed is read out of them."""
    measured = Measured()
    for step in range(4):
        measured.push(np.zeros(6), measured.home.motors + 1e-3 * step)
        measured.now -= PERIOD - 1e-5
        assert measured.take() is not None


def test_new_parameters_count_at_once():
    measured = Measured()
    measured.take_pose(shift=0.1)
    assert measured.take() is None
    measured.felt.settings = replace(SETTINGS, position_deviation=0.0)
    assert measured.take().degrees_of_freedom == 0
    measured.felt.settings = replace(SETTINGS, position_deviation=0.0, timeout=0.1)
    assert measured.take(age=0.2) is None


def test_old_measurements_are_told():
    measured = Measured()
    assert "have come" in measured.felt.reason(measured.now)
    assert measured.take() is not None
    assert measured.felt.reason(measured.now + 0.4) == ""
    assert "0.6 s old, more than measured_timeout 0.5 s" in measured.felt.reason(measured.now + 0.6)
    assert measured.take(age=0.7) is None
    assert "0.7 s old" in measured.felt.reason(measured.now)


def test_what_is_too_old_or_too_fast_is_told_apart_from_its_limit():
    """Efforts were said to be 0.5 s old, more than 0.5 s."""
    measured = Measured(max_speed=2.0)
    assert measured.take() is not None
    told = measured.felt.reason(measured.now + 0.50001)
    assert told == "the measured efforts are 0.50001 s old, more than measured_timeout 0.5 s"
    for step in range(1, 5):
        measured.push(np.zeros(6), measured.home.motors + 0.0100001 * step)
        measured.take()
    assert measured.take() is None
    told = measured.felt.reason(measured.now)
    assert "moves at 2.00002 rad/s or rod lengths/s, more than wrench_max_speed 2:" in told


def test_a_wrench_that_no_equilibrium_bears_is_looked_for_once_in_a_while():
    measured = Measured()
    bad = np.array([3.0, 3.0, -3.0, 3.0, -3.0, 3.0])
    assert measured.felt.take(measured.home.motors, bad, 1.0, 1.0, measured.home) is None
    told = measured.felt.reason(1.0)
    assert told
    good = measured.home.efforts
    assert measured.felt.take(measured.home.motors, good, 1.01, 1.01, measured.home) is None
    assert measured.felt.reason(1.01) == told
    assert measured.felt.take(measured.home.motors, good, 1.2, 1.2, measured.home) is not None


def test_without_a_timeout_no_measurement_is_too_old():
    measured = Measured(timeout=0.0)
    assert measured.take(age=3600.0) is not None
    assert measured.felt.reason(measured.now) == ""
    assert measured.felt.reason(measured.now + 3600.0) == ""


def test_efforts_have_the_sign_of_joint_states():
    """What the node publishes is what it takes: a robot as it is modelled feels nothing."""
    home = solve_home(robot("six_rfs"))
    message = joint_state(home, Frames("base", "platform"), None or JointState().header.stamp)
    assert_allclose(measured_efforts(home.robot, message), home.efforts)
    felt = FeltWrench(home.robot, SETTINGS)
    efforts = measured_efforts(home.robot, message)
    found = felt.take(np.array(message.position), efforts, 0.0, 0.0, home)
    assert_allclose(found.wrench_world, 0.0, atol=1e-9)


def test_efforts_of_other_joints_are_left_aside_and_missing_ones_are_named():
    home = solve_home(robot("rfrfr"))
    names = ["gripper", "motor2", "motor1"]
    message = JointState(name=names, position=[0.0] * 3, effort=[float("nan"), 2.0, 1.0])
    assert measured_efforts(home.robot, message).tolist() == [1.0, 2.0]
    message.effort = [0.0, float("nan"), 1.0]
    with pytest.raises(NonFiniteInput, match=r"effort: .*finite"):
        measured_efforts(home.robot, message)
    message.effort = [1.0]
    with pytest.raises(InvalidRequest, match="effort: expected 3 numbers, got 1"):
        measured_efforts(home.robot, message)
    message.effort = []
    with pytest.raises(InvalidRequest, match="measured_joint_states has no efforts"):
        measured_efforts(home.robot, message)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["motor1", "gripper"], r"name: expected every motor once .*; missing: motor2"),
        (["motor2", "motor1", "motor2"], r"name: expected every motor once .*; twice: motor2"),
        (["gripper", "wrist"], r"name: expected every motor once .*, got gripper, wrist"),
    ],
)
def test_efforts_of_motors_that_are_missing_or_twice_are_refused(names, said):
    """A missing one was a bare ValueError, and of one named twice the first counted."""
    message = JointState(name=names, effort=[1.0] * len(names))
    with pytest.raises(InvalidRequest, match=said):
        measured_efforts(robot("rfrfr"), message)


def test_the_message_has_forces_first():
    measured = Measured()
    wrench = np.array([0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    measured.push(wrench)
    measured.take_pose(shift=1e-4)
    found, stamp = measured.take(), Time(sec=7, nanosec=8)
    told = wrench_estimate(
        found, Frames("base", "platform"), stamp, with_pose=True, latency=0.03, solve_time=0.02
    )
    told_wrench = wrench_of(told.wrench)
    assert_allclose(told_wrench, found.wrench_world, rtol=0.0)
    assert_allclose(told_wrench, wrench, atol=0.02)
    covariance = np.reshape(told.covariance, (6, 6))
    assert covariance[0, 4] == found.covariance[3, 1]
    assert (told.felt, told.coordinates, len(told.unfelt)) == (6, 6, 0)
    assert told.header == Header(stamp=stamp, frame_id="base")
    assert (told.with_pose, told.latency, told.solve_time) == (True, 0.03, 0.02)
    for name in ("chi_square", "degrees_of_freedom", "consistency", "observability", "words"):
        assert getattr(told, name) == getattr(found, name)
    assert found.degrees_of_freedom == 6 and 0.0 < found.consistency < 1.0


def test_a_push_that_a_message_calls_unfelt_is_not_felt():
    """Three motors feel three of six directions."""
    measured, frames = Measured("three_rfs"), Frames("base", "platform")
    found, home, stamp = measured.take(), measured.home, JointState().header.stamp
    told = wrench_estimate(found, frames, stamp, with_pose=False, latency=0.0, solve_time=0.0)
    assert (told.felt, told.coordinates) == (3, 6)
    assert (told.degrees_of_freedom, told.with_pose) == (0, False)
    push = 1e-4 * home.robot.kernel_arrays.energy_unit / home.robot.mean_length
    message = WrenchStamped()
    for unfelt in np.reshape(told.unfelt, (3, 6)):
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z, torque.x, torque.y, torque.z = (push * unfelt).tolist()
        loads = with_wrench(home.loads, message, frames)
        pushed = solve_forward(home.robot, home.motors, start=home, loads=loads)
        moved = np.abs(pushed.platform_position - home.platform_position).max()
        assert moved > 1e-6 * home.robot.mean_length
        # What is left is of second order in the push.
        felt = np.abs(pushed.efforts - home.efforts).max()
        assert felt < 1e-2 * push * home.robot.mean_length


@pytest.mark.parametrize("name", ["rfrfr", "four_rfr"])
def test_it_is_that_of_the_branch_the_node_has_the_robot_on(name):
    """After a solution of another branch was applied it went on from the last estimate."""
    made = robot(name)
    felt = FeltWrench(made, SETTINGS)
    now = 1.0
    for place in (solve_home(made), stable_elsewhere(made), solve_home(made)):
        for _ in range(3):
            now += 0.02
            found = felt.take(place.motors, place.efforts, now, now, place)
            assert found is not None, felt.reason(now)
            assert_allclose(found.wrench_world, 0.0, atol=1e-6)
            assert_allclose(found.equilibrium.platform_position, place.platform_position, atol=1e-6)
