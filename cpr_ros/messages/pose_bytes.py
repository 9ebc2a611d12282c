# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A received PoseStamped, read from its bytes: made into a message first, motors wait 0.1 ms longer."""

from __future__ import annotations

import struct

from geometry_msgs.msg import PoseStamped
from rclpy.serialization import deserialize_message

from cpr_core import InvalidRequest

from ..middleware.serialized import FIRST, LITTLE_ENDIAN, STAMP
from .pose_messages import PoseNumbers, pose_numbers

__all__ = ["read_pose"]

#: How many bytes the name of the frame has, its zero at the end included; the name follows.
_LENGTH = struct.Struct("<I")
_LENGTH_AT = FIRST + STAMP.size
_NAME_AT = _LENGTH_AT + _LENGTH.size
#: Position x y z, orientation x y z w; aligned to eight bytes.
_POSE = struct.Struct("<7d")


def read_pose(received: bytes) -> tuple[str, PoseNumbers]:
    """Name of the frame, and the numbers.

    Raises:
        InvalidRequest: It is no such message.
    """
    if received[:2] == LITTLE_ENDIAN and len(received) >= _NAME_AT:
        (length,) = _LENGTH.unpack_from(received, _LENGTH_AT)
        behind = _NAME_AT + length
        pose_at = behind + (FIRST - behind) % 8
        if length and len(received) == pose_at + _POSE.size and received[behind - 1] == 0:
            *position, x, y, z, w = _POSE.unpack_from(received, pose_at)
            name = received[_NAME_AT : behind - 1].decode(errors="replace")
            return name, PoseNumbers(tuple(position), (w, x, y, z))
    try:
        message = deserialize_message(received, PoseStamped)
    except Exception as error:  # of rclpy, by the middleware
        raise InvalidRequest("pose", f"expected a PoseStamped: {error}") from None
    return message.header.frame_id, pose_numbers(message.pose)
