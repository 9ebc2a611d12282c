# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motor commands arrive as the message that they are."""

import math

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from std_msgs.msg import Float64MultiArray

from cpr_ros import command_message
from cpr_ros.command_message import CommandMessage


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
    monkeypatch.setattr(command_message, "_LITTLE_ENDIAN", b"\x00\x00")
    sent = CommandMessage(2).of(np.array([1.0, 2.0]))
    assert sent == Float64MultiArray(data=[1.0, 2.0])
