# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured poses and twists from messages: which frame they are in, and what of them is believed."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import PoseStamped, TwistStamped
from helpers.drive import robot
from helpers.tracked_robots import tracked
from rclpy.time import Time as RosTime

from cpr_core import InvalidQuaternion, InvalidRequest, solve_forward, solve_home
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_ros.error_codes import RequestError
from cpr_ros.messages.frames import Frames
from cpr_ros.messages.geometry import fill_quaternion, fill_vector, quaternion_of, vector_of
from cpr_ros.messages.platform_messages import (
    measured_pose,
    measurement_delay,
    platform_in_base,
    platform_twist,
)

TRACKER, MARKER = [0.4, -0.2, 1.1, 0.3, -0.5, 1.2], [0.05, 0.02, -0.03, -0.7, 0.2, 0.4]
QUARTER = rotation_exp([0.0, 0.0, 0.5 * np.pi])
FRAMES = Frames("base", "platform", lambda name: QUARTER if name == "tool" else None, "tracker")


def pose_message(position, rotation, frame="base", stamp=(7, 8)):
    message = PoseStamped()
    message.header.frame_id, message.header.stamp = frame, Time(sec=stamp[0], nanosec=stamp[1])
    fill_vector(message.pose.position, np.array(position))
    if rotation is not None:
        fill_quaternion(message.pose.orientation, quaternion_from_rotation(rotation))
    else:
        fill_quaternion(message.pose.orientation, np.zeros(4))
    return message


def seen(name, turned=True):
    """A robot away from home, and what a tracker says of its marker."""
    made = tracked(name, TRACKER, MARKER)
    current = solve_forward(made, solve_home(made).motors + 0.1)
    rotation = current.platform_rotation
    position, turn = made.description.tracker.marker_in_tracker(current.platform_position, rotation)
    return current, pose_message(position, turn if turned else None, "tracker")


@pytest.mark.parametrize("turned", [True, False])
def test_a_marker_tells_where_the_platform_is_in_the_base_frame(turned):
    current, message = seen("six_rfs", turned)
    found = platform_in_base(current, message, FRAMES)
    assert (found.header.frame_id, found.header.stamp) == ("base", Time(sec=7, nanosec=8))
    np.testing.assert_allclose(
        vector_of(found.pose.position), current.platform_position, atol=1e-12
    )
    orientation = np.array(quaternion_of(found.pose.orientation))
    expected = current.platform_quaternion if turned else np.zeros(4)
    np.testing.assert_allclose(orientation * np.sign(orientation @ expected + 1e-9), expected)


def test_a_point_does_not_turn_whatever_its_marker_does():
    made = tracked("rfrfr", TRACKER, MARKER)
    current = solve_home(made)
    position, _ = made.description.tracker.marker_in_tracker(current.platform_position, np.eye(3))
    message = pose_message(position, rotation_exp([0.4, 0.5, 0.6]), "tracker")
    found = platform_in_base(current, message, FRAMES)
    np.testing.assert_allclose(
        vector_of(found.pose.position), current.platform_position, atol=1e-12
    )
    assert quaternion_of(found.pose.orientation) == (1.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("frame", ["tracker", "camera"])
def test_other_frames_are_refused(frame):
    """Also that of a tracker of which the description says nothing."""
    home = solve_home(robot("six_rfs"))
    with pytest.raises(RequestError, match=r"header\.frame_id: expected 'base', got") as caught:
        platform_in_base(home, pose_message([0, 0, 0], np.eye(3), frame), FRAMES)
    assert caught.value.val == ErrorCode.FRAME_TRANSFORM_FAILURE


@pytest.mark.parametrize(("tilt", "taken"), [(0.15, True), (0.25, False)])
def test_a_small_tilt_of_a_planar_robot_is_left_aside(tilt, taken):
    made = robot("planar_body")
    message = pose_message([0.1, 0.2, 0.01], rotation_exp([0, 0, 0.3]) @ rotation_exp([tilt, 0, 0]))
    if taken:
        np.testing.assert_allclose(measured_pose(made, message), [0.1, 0.2, 0.3], atol=1e-3)
    else:
        with pytest.raises(InvalidQuaternion):
            measured_pose(made, message)


def test_a_message_is_as_late_as_its_stamp_says_and_without_one_not_at_all():
    now = RosTime(seconds=10, nanoseconds=250_000_000)
    stamps = ((9, 0), (0, 0), (10, 500_000_000))
    headers = [pose_message([0, 0, 0], None, stamp=stamp).header for stamp in stamps]
    delays = [measurement_delay(header, now) for header in headers]
    np.testing.assert_allclose(delays, [1.25, 0.0, -0.25], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("frame", "expected", "in_platform"),
    [
        ("", [0.004, 1.0, 0.0], False),
        ("base", [0.004, 1.0, 0.0], False),
        ("platform", [0.004, 1.0, 0.0], True),
        ("tool", [-1.0, 0.004, 0.0], False),
    ],
)
def test_a_twist_has_the_axes_of_its_frame(frame, expected, in_platform):
    """What turning leaves of zeros is none, and what is small is not."""
    message = TwistStamped()
    message.header.frame_id = frame
    message.twist.linear.x, message.twist.linear.y = 0.004, 1.0
    found = platform_twist(robot("six_rfs"), message, FRAMES)
    np.testing.assert_allclose(found.twist, [0, 0, 0, *expected], rtol=1e-12)
    assert found.in_platform == in_platform


def test_rounding_of_another_frame_moves_no_coordinate_that_is_not_controlled():
    made, message = robot("rfrfr"), TwistStamped()
    frames = Frames("base", "platform", lambda _: rotation_exp([0.5 * np.pi, 0.0, 0.0]))
    message.header.frame_id = "tool"
    message.twist.linear.x, message.twist.linear.z = 0.3, 1.0
    np.testing.assert_allclose(platform_twist(made, message, frames).twist[3:], [0.3, -1.0, 0.0])
    message.twist.linear.y = 1e-3
    with pytest.raises(InvalidRequest, match=r"got linear\.z as well"):
        platform_twist(made, message, frames)
