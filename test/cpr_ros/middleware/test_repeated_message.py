# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is sent again and again is the message with the stamp of now, and with the numbers of now."""

import math

import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from cpr_ros.middleware import repeated_message
from cpr_ros.middleware.repeated_message import RepeatedMessage

STAMPS = [(0, 0), (1, 999_999_999), (2**31 - 1, 7), (-(2**31), 2**32 - 1), (1_795_370_676, 1)]
AGES = ("margin_trend", "setpoint_age", "measured_pose_age")


def joints():
    message = JointState(name=["motor1", "a longer name"], position=[1.0, -2.5], effort=[0.1, 0.2])
    message.header.frame_id = "base"
    return message


def pose():
    message = PoseStamped()
    message.header.frame_id = "left/base"
    message.pose.position.x, message.pose.orientation.w = 0.25, 1.0
    return message


def metrics(text="stable"):
    message = StabilityMetrics(status_text=text, nearest_threshold="margin", margin=0.25)
    message.header.frame_id = "base"
    message.smallest_eigenvalues_locked = [1.0, 2.0, 3.0]
    return message


def sent_as(sent):
    """As it arrives."""
    return sent if isinstance(sent, bytes) else serialize_message(sent)


@pytest.mark.parametrize("make", [joints, pose])
def test_only_the_stamp_is_another(make):
    repeated, kinds = RepeatedMessage(make()), []
    for stamp in STAMPS:
        sent, expected = repeated.at(stamp), make()
        expected.header.stamp = Time(sec=stamp[0], nanosec=stamp[1])
        kinds.append(type(sent))
        assert deserialize_message(sent_as(sent), type(expected)) == expected
    assert kinds == [type(make()), *[bytes] * (len(STAMPS) - 1)]


@pytest.mark.parametrize("text", ["", "stable", "of another length"])
def test_numbers_that_change_are_those_of_now(text):
    repeated, kinds = RepeatedMessage(metrics(text), AGES), []
    for count, stamp in enumerate(STAMPS):
        numbers = [0.125 * count, -1.0, 1e300 * count]
        sent, expected = repeated.at(stamp, *numbers), metrics(text)
        expected.header.stamp = Time(sec=stamp[0], nanosec=stamp[1])
        for name, number in zip(AGES, numbers, strict=True):
            setattr(expected, name, number)
        kinds.append(type(sent))
        assert deserialize_message(sent_as(sent), StabilityMetrics) == expected
    assert kinds == [StabilityMetrics, *[bytes] * (len(STAMPS) - 1)]


def test_a_number_that_is_not_found_for_certain_is_not_written_over(monkeypatch):
    """Another field has the bits by which the places of numbers are found."""
    monkeypatch.setattr(repeated_message, "_MARK", 0.25)
    repeated = RepeatedMessage(metrics(), AGES)
    for count in range(3):
        sent = repeated.at((count, 0), 1.0, math.inf, 3.0)
        assert isinstance(sent, StabilityMetrics)
        assert (sent.header.stamp.sec, sent.margin, sent.setpoint_age) == (count, 0.25, math.inf)
