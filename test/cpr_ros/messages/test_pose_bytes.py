# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Poses are read from bytes as rclpy reads them."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Header

from cpr_core import InvalidRequest
from cpr_ros.messages import pose_bytes
from cpr_ros.messages.pose_bytes import read_pose
from cpr_ros.messages.pose_messages import pose_numbers


def message(frame="base"):
    """All its numbers differ, and none is an ordinary one but the last."""
    point, turn = (
        Point(x=-0.0, y=1e300, z=5e-324),
        Quaternion(x=math.inf, y=-0.1, z=math.nan, w=1.0),
    )
    header = Header(stamp=Time(sec=-7, nanosec=4_000_000_000), frame_id=frame)
    return PoseStamped(header=header, pose=Pose(position=point, orientation=turn))


def same(found, sent):
    frame, numbers = found
    assert frame == sent.header.frame_id
    for values, expected in zip(numbers, pose_numbers(sent.pose), strict=True):
        np.testing.assert_array_equal(values, expected)
        np.testing.assert_array_equal(np.signbit(values), np.signbit(expected))


def no_reading(*_):
    raise AssertionError("rclpy was asked")


@pytest.mark.parametrize("frame", ["robot/base"[:length] for length in range(11)] + ["Füße", "基"])
def test_they_are_those_of_the_message_whatever_the_frame(frame, monkeypatch):
    monkeypatch.setattr(pose_bytes, "deserialize_message", no_reading)
    same(read_pose(serialize_message(message(frame))), message(frame))


def test_what_is_left_between_frame_and_numbers_is_not_read():
    written = serialize_message(message("base"))
    left = written[:21] + b"lef" + written[24:]
    assert written != left
    same(read_pose(left), message("base"))


def test_where_numbers_are_written_otherwise_they_are_read_as_well(monkeypatch):
    written = serialize_message(message())
    monkeypatch.setattr(pose_bytes, "LITTLE_ENDIAN", b"\x00\x00")
    same(read_pose(written), message())


def test_big_endian_numbers_are_read():
    """As other computers write them; what aligns the numbers is the same."""
    little = np.frombuffer(serialize_message(message("bases"))[4:], np.uint8)
    words = [little[at : at + 4][::-1] for at in (0, 4, 8)]
    doubles = [little[at : at + 8][::-1] for at in range(24, len(little), 8)]
    big = np.concatenate([*words, little[12:24], *doubles])
    same(read_pose(b"\x00\x00\x00\x00" + big.tobytes()), message("bases"))


@pytest.mark.parametrize("cut", [*range(18), 40, 79])
def test_bytes_that_are_no_message_are_refused(cut):
    written = serialize_message(message())
    with pytest.raises(InvalidRequest, match="pose: expected a PoseStamped"):
        read_pose(written[:cut])


@pytest.mark.parametrize("place, bytes_there", [(12, bytes(4)), (20, b"X")], ids=["empty", "open"])
def test_a_name_without_an_end_is_read_as_rclpy_does(place, bytes_there):
    written = bytearray(serialize_message(message()))
    written[place : place + len(bytes_there)] = bytes_there
    same(read_pose(bytes(written)), deserialize_message(bytes(written), PoseStamped))


@pytest.mark.parametrize("length", [2**31, 2**32 - 1, 100])
def test_a_name_of_another_length_than_there_is_room_for_is_refused(length):
    written = bytearray(serialize_message(message()))
    written[12:16] = length.to_bytes(4, "little")
    with pytest.raises(InvalidRequest, match="pose: expected a PoseStamped"):
        read_pose(bytes(written))
