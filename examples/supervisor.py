# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A supervisor: reads the stability stream, pauses a robot that was halted, and sends it home.

    .venv/bin/cpr_node --ros-args -p robot:=rfrfr
    .venv/bin/python examples/supervisor.py

It acts on `action` alone. Slowing down needs nothing: the node does that by itself.
"""

from __future__ import annotations

import sys

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from cpr_msgs.msg import StabilityMetrics
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

#: A halt that lasts so long is not waited out any more [s].
PATIENCE = 2.0


class Supervisor(Node):
    """Watches one cpr_node in its namespace. Services are called without waiting in a callback."""

    def __init__(self) -> None:
        """Subscribe to the stream."""
        super().__init__("supervisor")
        self._action = StabilityMetrics.ACTION_NONE
        self._halted_since: float | None = None
        self._busy = False
        self._pause = self.create_client(SetBool, "cpr_node/pause")
        self._reset = self.create_client(Trigger, "cpr_node/reset")
        self.create_subscription(StabilityMetrics, "cpr_node/stability", self._on_metrics, 10)

    def _on_metrics(self, metrics: StabilityMetrics) -> None:
        if metrics.action != self._action:
            self._action = metrics.action
            name = {0: "NONE", 1: "SLOW", 2: "HALT"}[metrics.action]
            self.get_logger().info(
                f"{name}: {metrics.status_text} (nearest: {metrics.nearest_threshold or 'nothing'}, "
                f"margin {metrics.margin:.3f}, {metrics.margin_trend:+.3f}/s)"
            )
        now = metrics.header.stamp.sec + 1e-9 * metrics.header.stamp.nanosec
        if metrics.state != StabilityMetrics.STATE_HALTED:
            self._halted_since = None
        elif self._halted_since is None:
            self._halted_since = now
        elif now - self._halted_since > PATIENCE and not self._busy:
            self._send_home()

    def _send_home(self) -> None:
        """Pause, release, reset: the setpoint is forgotten before the robot moves again."""
        self._busy = True
        self.get_logger().warning("halted for too long: pausing and sending the robot home")
        self._pause.call_async(SetBool.Request(data=True)).add_done_callback(
            lambda _: self._pause.call_async(SetBool.Request(data=False)).add_done_callback(
                lambda _: self._reset.call_async(Trigger.Request()).add_done_callback(self._done)
            )
        )

    def _done(self, future: rclpy.task.Future) -> None:
        answer = future.result()
        self._busy, self._halted_since = False, None
        self.get_logger().info(f"reset: {answer.success}, {answer.message}")


def main() -> int:
    """Supervise until a signal comes."""
    rclpy.init()
    node = Supervisor()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        if rclpy.ok():  # else a signal came while rclpy was taking a message
            raise
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
