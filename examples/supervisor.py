# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A supervisor: reads the stability stream, pauses a robot that was halted, and sends it home.

    .venv/bin/cpr_node --ros-args -p robot:=rfrfr
    .venv/bin/python examples/supervisor.py

It acts on `action` alone, and on a stream that ends. Slowing down needs nothing: the node does that by
itself. What to do about a node that is dead or stuck is yours to fill in: cut the power, say.
"""

from __future__ import annotations

import signal
import threading
import time
from typing import Any

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from cpr_msgs.msg import StabilityMetrics
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import SetBool, Trigger

#: A halt that lasts so long is not waited out any more [s].
PATIENCE = 2.0
#: A node that has not been heard for so long is dead or stuck; needs a stability_rate of at least 10 Hz.
LONGEST_SILENCE = Duration(seconds=0.2)


class Supervisor(Node):
    """Watches one cpr_node in its namespace. Services are called without waiting in a callback."""

    def __init__(self) -> None:
        """Subscribe to the stream."""
        super().__init__("supervisor")
        self._action = StabilityMetrics.ACTION_NONE
        self._halted_since: float | None = None
        self._helped = False
        self._pause = self.create_client(SetBool, "cpr_node/pause")
        self._reset = self.create_client(Trigger, "cpr_node/reset")
        self.create_subscription(
            StabilityMetrics,
            "cpr_node/stability",
            self._on_metrics,
            QoSProfile(
                depth=10,
                deadline=LONGEST_SILENCE,
                liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
                liveliness_lease_duration=LONGEST_SILENCE,
            ),
            event_callbacks=SubscriptionEventCallbacks(liveliness=self._on_liveliness),
        )

    def _on_liveliness(self, status: Any) -> None:
        if status.alive_count:
            self.get_logger().info("the node is there")
        else:
            self.get_logger().error("the node is dead, stuck or not active: stop the motors")

    def _on_metrics(self, metrics: StabilityMetrics) -> None:
        if metrics.action != self._action:
            self._action = metrics.action
            name = {0: "NONE", 1: "SLOW", 2: "HALT"}[metrics.action]
            self.get_logger().info(
                f"{name}: {metrics.status_text} (nearest: {metrics.nearest_threshold or 'nothing'}, "
                f"margin {metrics.margin:.3f}, {metrics.margin_trend:+.3f}/s)"
            )
        now = time.monotonic()  # the time of ROS may jump, or stand still
        if metrics.action != StabilityMetrics.ACTION_HALT:
            self._halted_since, self._helped = None, False
        elif self._halted_since is None:
            self._halted_since = now
        elif now - self._halted_since > PATIENCE and not self._helped:
            self._helped = True  # once: what does not help does not help the second time
            self._send_home()

    def _send_home(self) -> None:
        """Pause, release, reset: the setpoint is forgotten before the robot moves again."""
        self.get_logger().warning("halted for too long: pausing and sending the robot home")
        self._pause.call_async(SetBool.Request(data=True)).add_done_callback(self._paused)

    def _paused(self, future: rclpy.task.Future) -> None:
        answer = future.result()
        if not answer.success:  # the node follows motors that somebody else moves
            self.get_logger().error(f"stop what moves the motors: {answer.message}")
            return
        self._pause.call_async(SetBool.Request(data=False)).add_done_callback(
            lambda _: self._reset.call_async(Trigger.Request()).add_done_callback(self._done)
        )

    def _done(self, future: rclpy.task.Future) -> None:
        answer = future.result()
        self.get_logger().info(f"reset: {answer.success}, {answer.message}")


def main() -> None:
    """Supervise until Ctrl-C."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    # A flag, for an exception could end up anywhere in rclpy, and be lost there.
    enough = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: enough.set())
    node = Supervisor()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not enough.is_set():
        executor.spin_once(timeout_sec=0.1)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
