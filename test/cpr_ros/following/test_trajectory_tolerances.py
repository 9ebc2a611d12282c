# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Tolerances of trajectories: of commands, and of motors that are measured."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cpr_ros.following.measured_motors import MeasuredMotors, MotorMeasurement, SeenMotors
from cpr_ros.following.motor_path import MotorPath
from cpr_ros.following.moved_by_others import SETTLING
from cpr_ros.following.trajectory_order import TrajectoryOrder
from cpr_ros.following.trajectory_tolerances import TrajectoryTolerances

NAMES = ("motor1", "motor2")
PERIOD = 0.005
POINTS = np.array([[0.0, 0.0], [1.0, -0.5]])
PATH = MotorPath.through([0.0, 2.0], POINTS, np.zeros((2, 2)))
FREE = np.full(2, np.inf)


def order(path_tolerance=FREE, goal_tolerance=FREE, goal_time_tolerance=np.inf):
    given_tolerances = np.array(path_tolerance), np.array(goal_tolerance), goal_time_tolerance
    return TrajectoryOrder(np.array([2.0]), POINTS[1:], None, None, None, *given_tolerances)


def tolerances(wanted):
    return TrajectoryTolerances(NAMES, wanted, PATH, PERIOD)


def broken(wanted, due, commands, measured=None, missing=""):
    return tolerances(wanted).broken(due, commands, SeenMotors(measured, missing))


def arrived(wanted, measured, missing):
    return tolerances(wanted).arrived(SeenMotors(measured, missing))


@given(due=st.floats(0.0, 2.0), age=st.floats(0.0, 0.4))
def test_motors_that_were_where_they_should_be_then_break_nothing(due, age):
    """However long ago that was: the path is looked at as it was at that time."""
    measured = MotorMeasurement(PATH.at(due - age).positions, age)
    assert broken(order([1e-9, 1e-9]), due, PATH.at(due).positions, measured) is None


@given(due=st.floats(0.2, 2.0), lag=st.floats(1e-3, 0.2))
def test_motors_that_lag_break_the_tolerance_they_are_beyond(due, lag):
    commands = PATH.at(due).positions
    away = np.array([0.0, lag])
    measured = MotorMeasurement(commands + away, 0.0)
    assert broken(order([1e-6, 1.01 * lag]), due, commands, measured) is None
    measure, text = broken(order([1e-6, 0.99 * lag]), due, commands, measured)
    assert measure == "path_tolerance"
    assert "motor2 is measured" in text


def test_what_was_measured_before_it_began_is_told_of_where_it_begins():
    measured = MotorMeasurement(np.array([0.1, 0.0]), 0.01)
    _, text = broken(order([0.05, 0.05]), 0.005, PATH.at(0.005).positions, measured)
    assert text.startswith("at 0.000 s motor1 is measured 0.1 from")


def test_commands_come_first_and_are_not_called_measured():
    sent = PATH.at(1.0).positions - 0.1
    _, text = broken(order([0.05, 0.05]), 1.0, sent, MotorMeasurement(sent, 0.0))
    assert "motor1 is 0.1 from where the trajectory has it" in text


def test_without_a_tolerance_any_error_is_one():
    lost = MotorMeasurement(np.array([5.0, 5.0]), 0.0)
    for due in (1.0, 2.0, 100.0):
        assert broken(order(), due, PATH.at(due).positions, lost) is None
    assert arrived(order(), lost, "")


def test_at_the_end_measured_motors_have_the_time_to_arrive():
    wanted = order(goal_tolerance=[0.01, np.inf])
    near, far = (MotorMeasurement(PATH.last - [error, 1.0], 0.0) for error in (0.009, 0.011))
    assert arrived(wanted, near, "")
    assert arrived(wanted, None, "")
    assert not arrived(wanted, far, "")
    for late in (0.0, 0.99 * SETTLING):
        assert broken(wanted, 2.0 + late, PATH.last, far) is None
    measure, text = broken(wanted, 2.0 + 1.01 * SETTLING, PATH.last, far)
    assert measure == "goal_tolerance"
    assert "motor1 is measured 0.011 from the end 0.505 s after it was due" in text
    assert broken(wanted, 2.0 + 1.01 * SETTLING, PATH.last, near) is None


@pytest.mark.parametrize(("allowed", "longest"), [(0.1, SETTLING), (2.0, 2.0)])
def test_a_time_tolerance_that_is_longer_is_given_to_measured_motors_too(allowed, longest):
    wanted = order(goal_tolerance=[0.01, 0.01], goal_time_tolerance=allowed)
    far = MotorMeasurement(PATH.last - 0.1, 0.0)
    assert broken(wanted, 2.0 + 0.99 * longest, PATH.last, far) is None
    assert broken(wanted, 2.0 + 1.01 * longest, PATH.last, far)[0] == "goal_time_tolerance"


@pytest.mark.parametrize("allowed", [0.1, np.inf])
def test_motors_that_are_measured_no_more_hold_no_tolerance(allowed):
    """Encoders were dead, and the trajectory succeeded by its commands."""
    near, missing = np.array([0.01, np.inf]), "the encoders are dead"
    on_the_way, at_the_end = order(near), order(FREE, near, allowed)
    measure, text = broken(on_the_way, 1.0, PATH.at(1.0).positions, None, missing)
    assert measure == "path_tolerance" and missing in text
    assert broken(on_the_way, 1.0, PATH.at(1.0).positions, None, "") is None
    assert broken(at_the_end, 1.0, PATH.at(1.0).positions, None, missing) is None
    assert not arrived(at_the_end, None, missing)
    assert arrived(on_the_way, None, missing)
    assert broken(at_the_end, 2.0 + 0.99 * SETTLING, PATH.last, None, missing) is None
    measure, text = broken(at_the_end, 2.0 + 1.01 * SETTLING, PATH.last, None, missing)
    assert measure == ("goal_tolerance" if np.isinf(allowed) else "goal_time_tolerance")
    assert missing in text


def test_who_measures_uselessly_measures():
    motors = MeasuredMotors(0.5)
    assert motors.missing(1.0) == ""
    motors.refuse("position: a NaN")
    assert motors.missing(1.0) == "no measured motors are of use: position: a NaN"
    motors.take(np.array([1.0, 2.0]), 1.0)
    motors.refuse("position: a NaN")
    assert motors.missing(1.4) == ""
    late = motors.missing(1.6)
    assert "0.6 s old, more than measured_timeout 0.5 s (position: a NaN)" in late
    motors.take(np.array([1.0, 2.0]), 2.0)
    assert motors.missing(2.6).endswith("measured_timeout 0.5 s")
    motors.forget()
    assert motors.missing(2.6) == ""


def test_an_age_and_its_timeout_are_told_apart():
    """Motors were said to be 0.5 s old, more than 0.5 s."""
    motors = MeasuredMotors(0.5)
    motors.take(np.array([1.0, 2.0]), 1.0)
    assert "are 0.50001 s old, more than measured_timeout 0.5 s" in motors.missing(1.50001)
    again = "the measured motors are older than measured_timeout 0.5 s"
    assert motors.missing(1.50001, with_age=False) == again


def test_a_measurement_is_known_as_long_as_it_is_fresh():
    motors = MeasuredMotors(0.5)
    assert motors.newest(1.0) is None
    motors.take(np.array([1.0, 2.0]), 1.0)
    assert motors.newest(1.3).age == pytest.approx(0.3)
    assert motors.newest(1.6) is None
    motors.take(np.array([3.0, 4.0]), 1.6)
    np.testing.assert_array_equal(motors.newest(1.6).motors, [3.0, 4.0])
    motors.forget()
    assert motors.newest(1.6) is None
