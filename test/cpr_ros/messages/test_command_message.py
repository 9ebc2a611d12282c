# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motor commands arrive as the message that they are, and are read as what they say."""

import math

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, MultiArrayLayout

from cpr_core import InvalidRequest
from cpr_ros.messages import command_message
from cpr_ros.messages.command_message import CommandMessage


@pytest.mark.parametrize("count", [1, 2, 6, 12])
def test_as_bytes_it_is_the_message_of_these_numbers_and_no_others(count):
    message = CommandMessage(count)
    for factor in (1.0, -0.1, 1e300, 5e-324):
        commands = factor * np.arange(1.0, count + 1.0)
        sent = message.of(commands)
        assert isinstance(sent, bytes)
        expected = Float64MultiArray(data=commands.tolist())
        assert deserialize_message(sent, Float64MultiArray) == expected


def test_what_was_sent_before_does_not_change():
    message = CommandMessage(2)
    first = message.of(np.array([1.0, 2.0]))
    message.of(np.array([3.0, math.pi]))
    assert list(deserialize_message(first, Float64MultiArray).data) == [1.0, 2.0]


def test_where_numbers_are_written_otherwise_it_is_an_ordinary_message(monkeypatch):
    monkeypatch.setattr(command_message, "LITTLE_ENDIAN", b"\x00\x00")
    sent = CommandMessage(2).of(np.array([1.0, 2.0]))
    assert sent == Float64MultiArray(data=[1.0, 2.0])


@pytest.mark.parametrize("count", [0, 1, 5, 6, 7, 12])
def test_received_numbers_are_those_of_the_message_however_many(count):
    numbers = [math.nan, -0.0, 5e-324, 1e300, -math.inf, math.pi, *range(6)][:count]
    received = serialize_message(Float64MultiArray(data=numbers))
    np.testing.assert_array_equal(CommandMessage(6).numbers(received), numbers)


def test_what_is_left_between_count_and_numbers_is_not_read():
    numbers = [1.0, 2.0]
    received = bytearray(serialize_message(Float64MultiArray(data=numbers)))
    received[16:20] = b"left"
    np.testing.assert_array_equal(CommandMessage(2).numbers(bytes(received)), numbers)


@pytest.mark.parametrize("numbers", [[1.0, 2.0], [1.0, 2.0, 3.0, 4.0]])
def test_numbers_behind_a_layout_are_read(numbers):
    layout = MultiArrayLayout(dim=[MultiArrayDimension(label="motors", size=2)], data_offset=3)
    received = serialize_message(Float64MultiArray(layout=layout, data=numbers))
    without = serialize_message(Float64MultiArray(data=np.zeros(len(numbers) + 2).tolist()))
    assert len(received) == len(without)  # a message of two numbers more looks as long
    assert list(CommandMessage(len(numbers) + 2).numbers(received)) == numbers


def test_where_numbers_are_written_otherwise_they_are_read_as_well(monkeypatch):
    received = serialize_message(Float64MultiArray(data=[1.0, 2.0]))
    monkeypatch.setattr(command_message, "LITTLE_ENDIAN", b"\x00\x00")
    assert list(CommandMessage(2).numbers(received)) == [1.0, 2.0]


@pytest.mark.parametrize("received", [b"", b"\x00\x01", b"\x00\x01\x00\x00" + 60 * b"\xff"])
def test_bytes_that_are_no_message_are_refused(received):
    with pytest.raises(InvalidRequest, match="data: expected a Float64MultiArray"):
        CommandMessage(6).numbers(received)
