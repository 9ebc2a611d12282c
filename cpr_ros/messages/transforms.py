# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The platform frame for others, and the frames of others, by tf2; nothing without tf2_ros."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import PoseStamped, TransformStamped
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import Header

from cpr_core.lie import rotation_from_quaternion

from .frames import Frames
from .geometry import quaternion_of, vector_of

try:
    import tf2_ros
except ImportError:  # not among the wheels
    tf2_ros = None

__all__ = ["Transforms", "transform_of"]


def transform_of(pose: PoseStamped, child: str) -> TransformStamped:
    """The transform that a pose of a frame in another one means."""
    transform = TransformStamped(
        header=Header(stamp=pose.header.stamp, frame_id=pose.header.frame_id), child_frame_id=child
    )
    moved = transform.transform.translation
    moved.x, moved.y, moved.z = vector_of(pose.pose.position)
    transform.transform.rotation = pose.pose.orientation
    return transform


class Transforms:
    """Sends the platform frame and looks up frames of others.

    Attributes:
        available: Whether tf2_ros is installed.
    """

    def __init__(self, node: Node, base: str, platform: str, tracker: str) -> None:
        """Listen and broadcast as the node, if tf2_ros is installed.

        Args:
            node: The node.
            base: Name of the frame fixed in space.
            platform: Name of the frame of the platform.
            tracker: Name of the frame of the tracker.
        """
        self.available = tf2_ros is not None
        self.frames = Frames(base, platform, self.rotation_to_base, tracker)
        if tf2_ros is not None:
            self._buffer = tf2_ros.Buffer()
            self._listener = tf2_ros.TransformListener(self._buffer, node)
            self._broadcaster = tf2_ros.TransformBroadcaster(node)

    def send(self, pose: PoseStamped) -> None:
        """Send the pose of the platform."""
        if self.available:
            self._broadcaster.sendTransform(transform_of(pose, self.frames.platform))

    def rotation_to_base(self, frame: str) -> NDArray[np.float64] | None:
        """Newest rotation from a frame to the base frame, (3, 3); None if it is not known."""
        if tf2_ros is None:
            return None
        try:
            found = self._buffer.lookup_transform(self.frames.base, frame, Time())
        except tf2_ros.TransformException:
            return None
        return rotation_from_quaternion(quaternion_of(found.transform.rotation))
