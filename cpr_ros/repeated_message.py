# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A message that is published again and again with nothing new but its stamp."""

from __future__ import annotations

import struct
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message

__all__ = ["RepeatedMessage"]

#: How DDS writes a message that begins with a header: what the numbers are written like (little-endian),
#: then the stamp.
_LITTLE_ENDIAN, _STAMP = b"\x00\x01", struct.Struct("<iI")
_FIRST = 4


class RepeatedMessage:
    """Translated to what goes over the network once, which is most of what publishing costs.

    Attributes:
        message: The message, whose first field is a header.
    """

    def __init__(self, message: Any) -> None:
        """Keep it; it is not translated before it is sent a second time.

        Args:
            message: Must not be changed any more, its stamp aside.
        """
        self.message, self._bytes, self._sent = message, bytearray(), False

    def at(self, stamp: Time) -> Any:
        """What to publish: the message, which has this stamp now, or the same as bytes."""
        self.message.header.stamp = stamp
        if not self._sent:
            self._sent = True
            return self.message
        if not self._bytes:
            self._bytes = bytearray(serialize_message(self.message))
        if self._bytes[:2] != _LITTLE_ENDIAN:
            return self.message
        _STAMP.pack_into(self._bytes, _FIRST, stamp.sec, stamp.nanosec)
        return bytes(self._bytes)
