# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A message that is published again and again, with nothing new but its stamp and some numbers."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message

from .serialized import FIRST, LITTLE_ENDIAN, STAMP

__all__ = ["RepeatedMessage", "Stamp"]

#: Seconds and nanoseconds.
Stamp = tuple[int, int]

_NUMBER = struct.Struct("<d")
#: Numbers that no message has: where they are written, others belong.
_MARK = -1.2345678912345e-280


class RepeatedMessage:
    """Translated to what goes over the network once, which is most of what publishing costs.

    Attributes:
        message: The message, whose first field is a header.
    """

    def __init__(self, message: Any, changing: Sequence[str] = ()) -> None:
        """Keep it; it is not translated before it is sent a second time.

        Args:
            message: Must not be changed any more, what is given anew each time aside.
            changing: Its fields that are given anew each time, double precision.
        """
        self.message, self._changing = message, changing
        self._bytes, self._places, self._sent = bytearray(), list[int](), False

    def at(self, stamp: Stamp, *numbers: float) -> Any:
        """What to publish: the message, which has stamp and numbers now, or the same as bytes.

        Args:
            stamp: Time of the message.
            numbers: Of the fields that change, in their order.
        """
        if not self._sent:
            self._sent = True
            return self.stamped(stamp, *numbers)
        if not self._bytes:
            self._translate()
        if self._bytes[:2] != LITTLE_ENDIAN or len(self._places) < len(self._changing):
            return self.stamped(stamp, *numbers)
        STAMP.pack_into(self._bytes, FIRST, *stamp)
        for place, number in zip(self._places, numbers, strict=True):
            _NUMBER.pack_into(self._bytes, place, number)
        return bytes(self._bytes)

    def stamped(self, stamp: Stamp, *numbers: float) -> Any:
        """The message itself, which has stamp and numbers now."""
        self.message.header.stamp = Time(sec=stamp[0], nanosec=stamp[1])
        for name, number in zip(self._changing, numbers, strict=True):
            setattr(self.message, name, number)
        return self.message

    def _translate(self) -> None:
        """Write it as bytes, and find where the numbers that change are written."""
        marks = [_MARK * (1 + number) for number in range(len(self._changing))]
        self._bytes = bytearray(serialize_message(self.stamped((0, 0), *marks)))
        written = [_NUMBER.pack(mark) for mark in marks]
        if all(self._bytes.count(mark) == 1 for mark in written):
            self._places = [self._bytes.index(mark) for mark in written]
