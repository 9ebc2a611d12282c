# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The bytes of a file that remembers a robot: a header and two slots of numbers, each with a checksum.

The slots are written in turn: one that was being written counts for nothing, the other one does. A new
file has two slots of turn 0, and no state; what has no slot that is whole had a state once, which is
lost, and is no file of a robot that never moved. No ROS here.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zlib

from cpr_core import Robot

__all__ = ["HEADER_SIZE", "StateLayout", "header_of", "is_header"]

_MAGIC = b"cpr_ros state 3\n"
#: Before the slots: what this is, of which description and motors, how many numbers a slot has, and a
#: checksum.
_HEADER, _CHECKSUM = struct.Struct("=16s32s32sQ"), struct.Struct("=I")
HEADER_SIZE = _HEADER.size + _CHECKSUM.size
#: Before the numbers of a slot: which turn they are of, and a checksum.
_SLOT = struct.Struct("=QI")


def header_of(robot: Robot, count: int) -> bytes:
    """The header of the file of a robot, whose slots have so many numbers."""
    header = _HEADER.pack(_MAGIC, _fingerprint(robot), _fingerprint_of_motors(robot), count)
    return header + _CHECKSUM.pack(zlib.crc32(header))


def is_header(header: bytes) -> bool:
    """Whether a file of this version may begin so, whosever it is."""
    whole = header[: _HEADER.size]
    return header.startswith(_MAGIC) and header == whole + _CHECKSUM.pack(zlib.crc32(whole))


class StateLayout:
    """Where things are in a file that begins with a header.

    Attributes:
        header: With its checksum.
        motors: Fingerprint of the motors.
        count: How many numbers a slot has.
        size: Bytes of the file.
    """

    def __init__(self, header: bytes) -> None:
        self.header = header
        _, _, self.motors, self.count = _HEADER.unpack(header[: _HEADER.size])
        self._slot_size = _SLOT.size + 8 * self.count
        self.size = HEADER_SIZE + 2 * self._slot_size

    def empty(self) -> bytes:
        """A file without a state."""
        return self.header + 2 * self.slot(0, bytes(8 * self.count))

    def newest(self, content: bytes | bytearray) -> tuple[int, bytes]:
        """Turn and numbers of the newer slot."""
        return max(self.slots(content))

    def slots(self, content: bytes | bytearray) -> list[tuple[int, bytes]]:
        """Turns and numbers of the slots that are whole."""
        found: list[tuple[int, bytes]] = []
        for place in (HEADER_SIZE, HEADER_SIZE + self._slot_size):
            slot = bytes(content[place : place + self._slot_size])
            turn, _ = _SLOT.unpack_from(slot)
            if slot == self.slot(turn, slot[_SLOT.size :]):
                found.append((turn, slot[_SLOT.size :]))
        return found

    def slot(self, turn: int, numbers: bytes) -> bytes:
        """What is written of a turn; slots of other headers have other checksums."""
        # Of a header with its own checksum the checksum is always the same.
        of_header = zlib.crc32(self.header[: _HEADER.size])
        checksum = zlib.crc32(numbers, zlib.crc32(turn.to_bytes(8), of_header))
        return _SLOT.pack(turn, checksum) + numbers


def _fingerprint(robot: Robot) -> bytes:
    """What tells a robot, its description and its modes from others.

    All fields count but those of the tracker, which moves nothing of the robot; comments do not.
    """
    written = robot.description.written
    fields = {} if written is None else {**written.content, "tracker": None}
    text = json.dumps(fields, default=repr, sort_keys=True)
    described = f"{text}\0{robot.motor_list}\0{robot.state_size}"
    return hashlib.sha256(described.encode()).digest()


def _fingerprint_of_motors(robot: Robot) -> bytes:
    """What tells the motors of a robot from those of others, whatever else is said of it."""
    return hashlib.sha256(f"{robot.description.name}\0{robot.motor_list}".encode()).digest()
