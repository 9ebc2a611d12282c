# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is sent again and again is the message with the stamp of now."""

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from cpr_ros.repeated_message import RepeatedMessage

STAMPS = [(0, 0), (1, 999_999_999), (2**31 - 1, 7), (-(2**31), 2**32 - 1), (1_795_370_676, 1)]


def joints():
    message = JointState(name=["motor1", "a longer name"], position=[1.0, -2.5], effort=[0.1, 0.2])
    message.header.frame_id = "base"
    return message


def pose():
    message = PoseStamped()
    message.header.frame_id = "left/base"
    message.pose.position.x, message.pose.orientation.w = 0.25, 1.0
    return message


@pytest.mark.parametrize("make", [joints, pose])
def test_only_the_stamp_is_another(make):
    repeated, kinds = RepeatedMessage(make()), []
    for sec, nanosec in STAMPS:
        sent, expected = repeated.at(Time(sec=sec, nanosec=nanosec)), make()
        expected.header.stamp = Time(sec=sec, nanosec=nanosec)
        kinds.append(type(sent))
        raw = sent if isinstance(sent, bytes) else serialize_message(sent)
        assert deserialize_message(raw, type(expected)) == expected
    assert kinds == [type(make()), *[bytes] * (len(STAMPS) - 1)]
