# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node uses of tf2_ros, within one process: tf2_ros is not among the wheels.

Frames form a tree; of a moving one the transform with the newest stamp counts, whenever it came.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import ClassVar
from weakref import WeakSet

import numpy as np
from geometry_msgs.msg import TransformStamped

from cpr_core.lie import quaternion_from_rotation, rotation_from_quaternion


class TransformException(Exception):
    """No way between two frames."""


class Buffer:
    """Rotations between frames that are known."""

    def __init__(self) -> None:
        self._newest: dict[str, TransformStamped] = {}

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        before = self._newest.get(transform.child_frame_id)
        if before is None or _time(transform) >= _time(before):
            self._newest[transform.child_frame_id] = transform

    set_transform_static = set_transform

    def lookup_transform(self, target: str, source: str, time) -> TransformStamped:
        assert time.nanoseconds == 0, "the newest is all that is here"
        (root, to_root), (other, from_root) = self._to_root(source), self._to_root(target)
        if root != other:
            raise TransformException(f"no way from {source} to {target}")
        found = TransformStamped()
        w, x, y, z = quaternion_from_rotation(from_root.T @ to_root).tolist()
        turn = found.transform.rotation
        turn.w, turn.x, turn.y, turn.z = w, x, y, z
        return found

    def _to_root(self, frame: str) -> tuple[str, np.ndarray]:
        """The end of the tree, and the rotation from a frame to it."""
        turned, known = np.eye(3), frame in self._newest
        known |= frame in {each.header.frame_id for each in self._newest.values()}
        if not known:
            raise TransformException(f"no frame {frame}")
        while frame in self._newest:
            turn = self._newest[frame].transform.rotation
            turned = rotation_from_quaternion([turn.w, turn.x, turn.y, turn.z]) @ turned
            frame = self._newest[frame].header.frame_id
        return frame, turned


class TransformListener:
    """Hears what is sent in its process."""

    heard_by: ClassVar[WeakSet[Buffer]] = WeakSet()

    def __init__(self, buffer: Buffer, node) -> None:
        self.heard_by.add(buffer)


class TransformBroadcaster:
    """Sends to all listeners, and keeps what it sent."""

    def __init__(self, node) -> None:
        self.sent: list[TransformStamped] = []

    def sendTransform(self, transform: TransformStamped) -> None:  # noqa: N802  of tf2_ros
        self.sent.append(transform)
        for buffer in TransformListener.heard_by:
            buffer.set_transform(transform, "")


def _time(transform: TransformStamped) -> tuple[int, int]:
    return transform.header.stamp.sec, transform.header.stamp.nanosec


#: In the place of the package.
TF2_ROS = SimpleNamespace(
    Buffer=Buffer,
    TransformBroadcaster=TransformBroadcaster,
    TransformException=TransformException,
    TransformListener=TransformListener,
)
