# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A controller that drives a circle with the platform.

    .venv/bin/cpr_node --ros-args -p robot:=six_rfs
    .venv/bin/python examples/circle.py --radius 0.05 --turns 2

The circle lies in the plane z = constant (planar robots: in their plane) around where the platform is,
with the orientation it has. Setpoints go out at 100 Hz, or as fast as the robot comes along; the node
follows the newest within its limits.
"""

from __future__ import annotations

import argparse
import math
import signal
import sys
import threading
import time
from typing import Any

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

RATE = 100.0
#: So long without a pose is no busy computer any more [s].
SILENCE = 10.0


class Circle(Node):
    """Sends points of a circle and measures how far the platform is from the newest."""

    def __init__(self, radius: float, period: float) -> None:
        """Listen; the circle starts with :meth:`drive`."""
        super().__init__("circle")
        self.radius, self.period = radius, period
        self.pose: PoseStamped | None = None
        self.halted = False
        self.largest_error = 0.0
        self._posed = 0
        self._target: PoseStamped | None = None
        self._setpoint = self.create_publisher(PoseStamped, "cpr_node/platform_setpoint", 1)
        self.create_subscription(PoseStamped, "cpr_node/platform_pose", self._on_pose, 10)
        self.create_subscription(StabilityMetrics, "cpr_node/stability", self._on_metrics, 10)

    def drive(self, turns: float, enough: threading.Event) -> None:
        """Drive around; returns at the end, when it is enough, or when the node halts.

        Raises:
            TimeoutError: No cpr_node is there.
        """
        end = time.monotonic() + 20.0
        while self.pose is None or not self._setpoint.get_subscription_count():
            if enough.is_set():
                return
            rclpy.spin_once(self, timeout_sec=0.1)
            if time.monotonic() > end:
                raise TimeoutError("no cpr_node publishes its platform pose")
        start = self.pose
        for number in range(round(turns * self.period * RATE)):
            angle = 2.0 * math.pi * number / (self.period * RATE)
            target = PoseStamped()
            target.header.frame_id = start.header.frame_id
            target.pose.orientation = start.pose.orientation
            target.pose.position.x = start.pose.position.x + self.radius * (math.cos(angle) - 1.0)
            target.pose.position.y = start.pose.position.y + self.radius * math.sin(angle)
            target.pose.position.z = start.pose.position.z
            self._target = target
            self._hear_after(target)
            if self.halted or enough.is_set():
                return

    def _hear_after(self, target: PoseStamped) -> None:
        """Send a setpoint and listen for a while, and until a pose of later comes.

        Where the computer is busy the circle waits for the robot, and does not run away from it.

        Raises:
            TimeoutError: No pose comes.
        """
        sent, begin = time.time_ns(), time.monotonic()
        self._setpoint.publish(target)
        while (left := begin + 1.0 / RATE - time.monotonic()) > 0.0 or self._posed <= sent:
            if left < -SILENCE:
                raise TimeoutError("cpr_node publishes its platform pose no more")
            rclpy.spin_once(self, timeout_sec=left if left > 0.0 else 0.1)

    def _on_pose(self, pose: PoseStamped, about: dict[str, Any]) -> None:
        self.pose = pose
        self._posed = about["source_timestamp"]  # by DDS: stamps of a simulation are another time
        if self._target is not None:
            measured, target = pose.pose.position, self._target.pose.position
            error = math.dist((measured.x, measured.y, measured.z), (target.x, target.y, target.z))
            self.largest_error = max(self.largest_error, error)

    def _on_metrics(self, metrics: StabilityMetrics) -> None:
        if metrics.action == StabilityMetrics.ACTION_HALT:
            self.get_logger().warning(f"halted: {metrics.status_text}")
            self.halted = True


def main(arguments: list[str] | None = None) -> int:
    """Drive the circle; exit status 0, or 1 if the node halted or is not there."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--radius", type=float, default=0.05, help="[m]")
    parser.add_argument("--period", type=float, default=5.0, help="time of a turn [s]")
    parser.add_argument("--turns", type=float, default=1.0)
    options = parser.parse_args(arguments)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    # A flag, for an exception could end up anywhere in rclpy, and be lost there.
    enough = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: enough.set())
    node = Circle(options.radius, options.period)
    try:
        node.drive(options.turns, enough)
    except TimeoutError as error:
        print(f"circle: {error}", file=sys.stderr)
        return 1
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    print(f"largest distance from the newest setpoint: {1e3 * node.largest_error:.1f} mm")
    return 1 if node.halted else 0


if __name__ == "__main__":
    sys.exit(main())
