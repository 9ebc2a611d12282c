# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How evenly motor commands come along a trajectory, whoever listens meanwhile.

    .venv/bin/python -m benchmarks.ros_trajectory --seconds 8

A node with the 6-RFS robot (5 modes, ticks at 200 Hz) in its own process follows a JointTrajectory while
nobody listens but for the commands; while another process listens to the states and the stability
stream, as a supervisor does; and while that one looks at the legs as well, as rviz does.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from builtin_interfaces.msg import Duration
from cpr_core import load_robot, solve_home
from cpr_msgs.msg import StabilityMetrics
from cpr_ros.interface.outputs import LATCHED
from cpr_ros.process.own_domain import enter_own_domain
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import MarkerArray

from .ros_at_rest import Spun

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
        self.came: list[float] = []
        self.ready = False
        topic = "/cpr_node/motor_commands"
        self.create_subscription(Float64MultiArray, topic, self._on_command, 50)
        self.create_subscription(JointState, "/cpr_node/home", self._on_home, LATCHED)
        self.publisher = self.create_publisher(JointTrajectory, "/cpr_node/joint_trajectory", 1)

    def _on_home(self, _message: JointState) -> None:
        self.ready = True

    def _on_command(self, _message: Float64MultiArray) -> None:
        self.came.append(time.perf_counter())

    def intervals(self, trajectory: JointTrajectory, seconds: float) -> NDArray[np.float64]:
        """Between the commands of a trajectory that takes so long [s]."""
        self.came.clear()
        begin = time.perf_counter()
        self.publisher.publish(trajectory)
        self.spin(seconds + 1.0)
        came = np.array(self.came)
        return np.diff(came[(came > begin + 0.2) & (came < begin + seconds - 0.2)])


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
            found = 1e3 * node.intervals(trajectory, seconds)
        finally:
            listener.kill()
            listener.wait()
        median, high, higher, largest = np.percentile(found, [50, 90, 99, 100])
        print(
            f"{name:22} listens: {len(found)} commands, median {median:.2f} ms, p90 {high:.2f} ms, "
            f"p99 {higher:.2f} ms, largest {largest:.1f} ms"
        )
    node.executor_.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


def main() -> int:
    """Run the benchmark, or, with --listen, one who listens."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--listen", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.listen is not None:
        listen(options.listen)
    enter_own_domain()
    folder = tempfile.TemporaryDirectory()
    os.environ["ROS_HOME"] = folder.name  # the node begins at home, whatever was done before
    process = subprocess.Popen([sys.executable, "-m", "cpr_ros.cpr_node"])
    try:
        measure(options.seconds)
    finally:
        process.send_signal(signal.SIGINT)
        status = process.wait(timeout=20)
    return status


if __name__ == "__main__":
    sys.exit(main())
