# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""ROS time for stamps. Not by way of rclpy.time.Time, which takes several times as long."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rclpy.node import Node

from .repeated_message import Stamp

__all__ = ["RosClock"]


class RosClock:
    """The clock of a node."""

    def __init__(self, node: Node) -> None:
        """Read that of this node."""
        self._clock = node.get_clock().handle

    def now(self) -> Stamp:
        """ROS time."""
        return divmod(self._clock.get_now().nanoseconds, 1_000_000_000)

    def stamp(self) -> Time:
        """The same as a message."""
        seconds, nanoseconds = self.now()
        return Time(sec=seconds, nanosec=nanoseconds)
