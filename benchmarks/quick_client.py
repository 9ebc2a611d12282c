# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Messages as bytes, waited for without an executor: the least that rclpy and DDS take.

A controller in C++ is about as quick. What an ordinary client of rclpy measures beyond that is its own.
"""

from __future__ import annotations

import time
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64MultiArray

__all__ = ["QuickClient"]


class QuickClient:
    """Of one pair of topics; what answers is an array of numbers.

    Attributes:
        publisher: Of rclpy.
        published: When the message that was taken last was published, by the system's clock [ns].
    """

    def __init__(
        self,
        node: Node,
        sent: str,
        received: str,
        depth: int = 10,
        kind: type[Any] = Float64MultiArray,
    ) -> None:
        """Publish and subscribe.

        Args:
            node: Which no executor has.
            sent: Topic.
            received: Topic.
            depth: How many messages wait.
            kind: Of what is sent.
        """
        self.publisher = node.create_publisher(kind, sent, depth)
        self._subscription = node.create_subscription(
            Float64MultiArray, received, lambda message: None, depth, raw=True
        )
        self._newest, self.published = b"", 0
        self._waiting: Any = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    def wait(self, seconds: float) -> None:
        """Until a message is there, or the time is over."""
        self._waiting.clear_entities()
        self._waiting.add_subscription(self._subscription.handle)
        self._waiting.wait(int(1e9 * seconds))

    def take(self) -> bytes:
        """The oldest message that is there; empty without."""
        taken = self._subscription.handle.take_message(Float64MultiArray, True)
        if not taken:
            return b""
        message, information = taken
        self.published = information["source_timestamp"]
        return message

    def latency(self, setpoint: Any) -> float:
        """Time from sending a message to the first one that is new [s].

        Raises:
            TimeoutError: None came.
        """
        self._has_new()
        message = serialize_message(setpoint)
        begin = time.perf_counter()
        self.publisher.publish(message)
        while not self._has_new():
            if time.perf_counter() > begin + 5.0:
                raise TimeoutError(f"no answer on {self._subscription.topic_name}")
            self.wait(0.1)
        return time.perf_counter() - begin

    def _has_new(self) -> bool:
        """Whether one of the messages that are there differs from the one before."""
        found = False
        while message := self.take():
            found = found or message != self._newest
            self._newest = message
        return found
