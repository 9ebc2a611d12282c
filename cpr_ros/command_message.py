# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The message of the motor commands, ready but for its numbers.

Made and translated anew, a command takes half as long again to publish, and the motors wait for it.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64MultiArray

__all__ = ["CommandMessage"]

#: How DDS says that numbers are written little-endian.
_LITTLE_ENDIAN = b"\x00\x01"


class CommandMessage:
    """A message of so many numbers, as it goes over the network."""

    def __init__(self, count: int) -> None:
        """Find where the numbers are written.

        Args:
            count: Of motors.
        """
        self._numbers = struct.Struct(f"<{count}d")
        marks = -1.2345678912345e-280 * np.arange(1.0, count + 1.0)
        self._bytes = bytearray(serialize_message(Float64MultiArray(data=marks.tolist())))
        self._place = self._bytes.find(self._numbers.pack(*marks))

    def of(self, commands: NDArray[np.float64]) -> Float64MultiArray | bytes:
        """What to publish for commands in motor order, (n,)."""
        if self._bytes[:2] != _LITTLE_ENDIAN or self._place < 0:
            return Float64MultiArray(data=commands.tolist())
        self._numbers.pack_into(self._bytes, self._place, *commands.tolist())
        return bytes(self._bytes)
