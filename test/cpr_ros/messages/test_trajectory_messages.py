# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Trajectories from messages: all of them in the order of the motors, or refused by what is wrong."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from helpers.drive import changed_robot, robot
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from cpr_core import InvalidRequest, NonFiniteInput
from cpr_ros.error_codes import RequestError
from cpr_ros.following.trajectory_order import TrajectoryRefused
from cpr_ros.messages.trajectory_messages import AllowedErrors, trajectory_order
from cpr_ros.messages.trajectory_points import duration_of, point_message, seconds_of

NAMES = ["motor2", "motor1"]


def point(time, positions, velocities=(), accelerations=()):
    return JointTrajectoryPoint(
        time_from_start=duration_of(time),
        positions=positions,
        velocities=velocities,
        accelerations=accelerations,
    )


#: A point and one with an effort.
PUSHED = [
    point(1.0, [0.5, 2.6]),
    JointTrajectoryPoint(time_from_start=duration_of(2.0), positions=[0.5, 2.6], effort=[0.0, 0.0]),
]


def test_all_numbers_are_put_in_the_order_of_the_motors():
    points = [
        point(1.0, [0.5, 2.6], [0.1, 0.2], [0.3, 0.4]),
        point(2.5, [0.6, 2.7], [0.0, 0.0], [0.7, 0.8]),
    ]
    message = JointTrajectory(joint_names=NAMES, points=points)
    message.header.stamp = Time(sec=12, nanosec=250_000_000)
    now = Time(sec=10, nanosec=500_000_000)
    order = trajectory_order(
        robot("rfrfr"), message, now, AllowedErrors([0.0, 0.2], [0.3, 0.4], 1.5)
    )
    for name, expected in {
        "times": [1.0, 2.5],
        "positions": [[2.6, 0.5], [2.7, 0.6]],
        "velocities": [[0.2, 0.1], [0.0, 0.0]],
        "accelerations": [[0.4, 0.3], [0.8, 0.7]],
        "start_in": 1.75,
        "path_tolerance": [0.2, np.inf],
        "goal_tolerance": [0.4, 0.3],
        "goal_time_tolerance": 1.5,
    }.items():
        np.testing.assert_array_equal(getattr(order, name), expected, err_msg=name)


def test_of_names_in_any_order_every_motor_has_its_own_numbers():
    """Two that change places do not tell an order from its inverse."""
    six = robot("six_rfs")
    names = [*six.motor_names[1:], six.motor_names[0]]
    given = [5.6, 5.7, 5.8, 5.9, 6.0, 5.5]
    message = JointTrajectory(joint_names=names, points=[point(1.0, given)])
    order = trajectory_order(six, message, Time(), AllowedErrors(given))
    np.testing.assert_array_equal(order.positions, [sorted(given)])
    np.testing.assert_array_equal(order.path_tolerance, sorted(given))


def test_what_is_not_said_is_at_once_and_anything_goes():
    message = JointTrajectory(joint_names=NAMES, points=[point(1.0, [0.5, 2.6])])
    order = trajectory_order(robot("rfrfr"), message, Time(sec=10))
    assert order.velocities is order.accelerations is order.start_in is None
    for tolerance in (order.path_tolerance, order.goal_tolerance):
        np.testing.assert_array_equal(tolerance, [np.inf, np.inf])
    assert order.goal_time_tolerance == np.inf


@pytest.mark.parametrize(
    ("points", "tolerance", "error", "words"),
    [
        ([point(1.0, [0.5, 2.6], (), [0.0, 0.0])], (), InvalidRequest, r"points\[0\]\.velocities"),
        ([point(1.0, [0.5, np.nan])], (), NonFiniteInput, r"points\[0\]\.positions"),
        ([point(1.0, [0.5])], (), InvalidRequest, r"points\[0\]\.positions"),
        ([point(1.0, [0.5, 2.6])] * 10_001, (), InvalidRequest, "no more than 10000 points"),
        (
            [point(1.0, [0.5, 2.6])] * 10_000,
            (),
            TrajectoryRefused,
            r"points\[1\].*more than the 1 s",
        ),
        ([point(1.0, [])], (), InvalidRequest, r"points\[0\]\.positions: expected 2 numbers"),
        (PUSHED, (), InvalidRequest, r"points\[1\]\.effort"),
        ([point(1.0, [0.5, 2.6])], [0.1, -0.1], InvalidRequest, "path_tolerance: .* at least 0"),
    ],
    ids=["accelerations", "nan", "short", "many", "same time", "none", "effort", "tolerance"],
)
def test_what_cannot_be_followed_is_refused(points, tolerance, error, words):
    message = JointTrajectory(joint_names=NAMES, points=points)
    with pytest.raises(error, match=words):
        trajectory_order(robot("rfrfr"), message, Time(), AllowedErrors(tolerance))


def test_an_end_may_be_late_by_a_time_that_ends():
    message = JointTrajectory(joint_names=NAMES, points=[point(1.0, [0.5, 2.6])])
    with pytest.raises(RequestError, match=r"goal_time_tolerance: expected .* got inf"):
        trajectory_order(robot("rfrfr"), message, Time(), AllowedErrors((), (), np.inf))


def test_a_stamp_has_no_meaning_before_there_is_a_clock():
    message = JointTrajectory(joint_names=NAMES, points=[point(1.0, [0.5, 2.6])])
    message.header.stamp = Time(sec=12)
    with pytest.raises(TrajectoryRefused, match=r"header\.stamp: expected 0 .* got 12 s"):
        trajectory_order(robot("rfrfr"), message, Time())


def test_a_point_says_what_is_known_at_its_time():
    told = point_message(-0.25, np.array([1.0, 2.0]), np.array([0.1, 0.2]))
    assert (told.time_from_start.sec, told.time_from_start.nanosec) == (-1, 750_000_000)
    assert seconds_of(told.time_from_start) == -0.25
    assert (list(told.velocities), list(told.accelerations)) == ([0.1, 0.2], [])


def test_rods_without_length_are_refused():
    def unlimited(content):
        for leg in content["legs"]:
            leg["motor"].pop("limits")

    made = changed_robot("gough_stewart", unlimited)
    message = JointTrajectory(joint_names=list(made.motor_names))
    message.points = [point(1.0, [0.4] * 6), point(2.0, [0.4] * 5 + [-0.1])]
    with pytest.raises(InvalidRequest, match="motor6: expected a rod length above 0"):
        trajectory_order(made, message, Time())
