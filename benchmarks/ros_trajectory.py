# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How evenly and how soon motor commands come along a trajectory, whoever listens meanwhile.

    .venv/bin/python -m benchmarks.ros_trajectory --seconds 8

A node with the 6-RFS robot (5 modes, ticks at 200 Hz) in its own process follows a JointTrajectory while
nobody listens but for the commands; while another process listens to the states and the stability
stream, as a supervisor does; and while that one looks at the legs as well, as rviz does.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time

import numpy as np

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from builtin_interfaces.msg import Duration
from cpr_core import load_robot, solve_home
from cpr_msgs.msg import StabilityMetrics
from cpr_ros.interface.outputs import LATCHED
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import MarkerArray

from .quick_client import QuickClient
from .running_node import Spun, running_node

Floats = NDArray[np.float64]

#: Of the motors [rad], and how fast they swing [rad/s].
AMPLITUDE, FREQUENCY = 0.05, 1.5
#: Between the points of the trajectory [s].
SPACING = 0.05
STREAMS = {
    "/joint_states": JointState,
    "/cpr_node/platform_pose": PoseStamped,
    "/cpr_node/stability": StabilityMetrics,
    "/cpr_node/leg_markers": MarkerArray,
}
LISTENERS = {"nobody": 0, "a supervisor": 3, "a supervisor and rviz": 4}


class Follower(Spun):
    """Sends the trajectory, and notes when commands come."""

    def __init__(self) -> None:
        super().__init__("trajectory_benchmark")
        self.ready = False
        self._client = QuickClient(
            Node("commands"),
            "/cpr_node/joint_trajectory",
            "/cpr_node/motor_commands",
            depth=50,
            kind=JointTrajectory,
        )
        self.publisher = self._client.publisher
        self.create_subscription(JointState, "/cpr_node/home", self._on_home, LATCHED)

    def _on_home(self, _message: JointState) -> None:
        self.ready = True

    def follow(self, trajectory: JointTrajectory, seconds: float) -> tuple[Floats, Floats]:
        """Intervals between the commands of a trajectory that takes so long, and their delays [s]."""
        came, delays = list[float](), list[float]()
        while self._client.take():
            pass
        begin = time.perf_counter()
        self.publisher.publish(trajectory)
        while time.perf_counter() < begin + seconds - 0.2:
            self._client.wait(0.1)
            while self._client.take():
                came.append(time.perf_counter())
                delays.append(1e-9 * (time.time_ns() - self._client.published))
        self.spin(1.2)
        counts = np.array(came) > begin + 0.2
        return np.diff(np.array(came)[counts]), np.array(delays)[counts]


def swinging(seconds: float) -> JointTrajectory:
    """All motors about home, from rest."""
    robot = load_robot("six_rfs")
    home, signs = solve_home(robot).motors, np.tile([1.0, -1.0], 3)
    trajectory = JointTrajectory(joint_names=list(robot.motor_names))
    for moment in np.arange(SPACING, seconds, SPACING).tolist():
        way = AMPLITUDE * min(1.0, moment) * np.sin(FREQUENCY * moment) * signs
        whole, part = divmod(round(1e9 * moment), 1_000_000_000)
        after = Duration(sec=whole, nanosec=part)
        point = JointTrajectoryPoint(positions=(home + way).tolist(), time_from_start=after)
        trajectory.points.append(point)
    return trajectory


def listen(count: int) -> None:
    """To so many streams, until it is killed."""
    rclpy.init()
    node = Spun("listener")
    for topic, kind in list(STREAMS.items())[:count]:
        node.create_subscription(kind, topic, lambda message: None, 10)
    while True:
        node.spin(1.0)


def told(times: Floats) -> str:
    """Times [s] in words."""
    median, high, higher, largest = 1e3 * np.percentile(times, [50, 90, 99, 100])
    return (
        f"median {median:.2f} ms, p90 {high:.2f} ms, p99 {higher:.2f} ms, largest {largest:.1f} ms"
    )


def measure(seconds: float) -> None:
    """Print what was found."""
    rclpy.init()
    node, trajectory = Follower(), swinging(seconds)
    while not (node.publisher.get_subscription_count() and node.ready):
        node.spin(0.1)
    for name, count in LISTENERS.items():
        program = [sys.executable, "-m", "benchmarks.ros_trajectory", "--listen", str(count)]
        listener = subprocess.Popen(program)
        try:
            node.spin(4.0)  # until it is found
            intervals, delays = node.follow(trajectory, seconds)
        finally:
            listener.kill()
            listener.wait()
        print(f"{name:22} listens: {len(delays)} commands, {told(intervals)} apart")
        print(f"{'':32}from publishing to receipt {told(delays)}")
    node.end()
    rclpy.try_shutdown()


def main() -> int:
    """Run the benchmark, or, with --listen, one who listens."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--listen", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.listen is not None:
        listen(options.listen)
    with running_node() as process:
        measure(options.seconds)
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
