# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How fast and how steadily the node follows a 1 kHz setpoint stream.

    .venv/bin/python -m benchmarks.ros_follow --seconds 600

A node with the 6-RFS robot (5 modes, ticks at 200 Hz) in its own process; this process sends motor
setpoints at 1 kHz and listens to the joint states. The latency of a setpoint is the time from sending it
until a state arrives that has it or a newer one. Memory is the node's resident set.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState

from .running_node import running_node

HOME = np.array([5.86, 5.56, 5.86, 5.46, 5.86, 5.26])
NAMES = [f"motor{k + 1}" for k in range(6)]
RATE = 1000.0
#: Slow enough that every setpoint is reached within a tick.
AMPLITUDE, PERIOD = 0.05, 4.0
WARM_UP = 5.0


def setpoint(number: int) -> list[float]:
    """Positions that no other setpoint has."""
    phase = 2.0 * np.pi * number / (RATE * PERIOD)
    wave = AMPLITUDE * np.sin(phase + np.arange(6))
    wave[0] += 1e-9 * number
    return (HOME + wave).tolist()


class Sender(Node):
    """Sends setpoints and notes when they come back as states."""

    def __init__(self) -> None:
        super().__init__("follow_benchmark")
        self.sent: list[float] = []
        self.numbers: dict[float, int] = {}
        self.latencies: list[float] = []
        self.states = 0
        self._done = 0
        self._publisher = self.create_publisher(JointState, "/cpr_node/motor_setpoint", 1)
        self.create_subscription(JointState, "/joint_states", self._on_state, 10)

    def wait(self) -> None:
        """Wait for the node."""
        while not (self._publisher.get_subscription_count() and self.states):
            rclpy.spin_once(self, timeout_sec=0.1)

    def send(self) -> None:
        """Send the next setpoint."""
        number = len(self.sent)
        positions = setpoint(number)
        self.numbers[positions[0]] = number
        self.sent.append(time.perf_counter())
        self._publisher.publish(JointState(name=NAMES, position=positions))

    def _on_state(self, state: JointState) -> None:
        self.states += 1
        now = time.perf_counter()
        number = self.numbers.get(state.position[0], -1)
        while self._done <= number:
            self.latencies.append(now - self.sent[self._done])
            self._done += 1


def resident_memory(process: subprocess.Popen[bytes]) -> float:
    """Resident set of a process [MB]."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0]) / 1024.0


def measure(process: subprocess.Popen[bytes], seconds: float) -> None:
    """Drive the node and print what was found."""
    rclpy.init()
    node, executor = Sender(), SingleThreadedExecutor()
    node.wait()
    executor.add_node(node)
    begin = time.perf_counter()
    memory, next_look = [], 0.0
    while (elapsed := time.perf_counter() - begin) < seconds + WARM_UP:
        if elapsed * RATE >= len(node.sent):
            node.send()
        executor.spin_once(timeout_sec=max(0.0, len(node.sent) / RATE - elapsed))
        if elapsed >= next_look:
            memory.append((elapsed, resident_memory(process)))
            next_look += max(1.0, seconds / 60.0)
    latencies = 1e3 * np.array(node.latencies[int(WARM_UP * RATE) :])
    rate = len(node.sent) / (time.perf_counter() - begin)
    print(f"{len(latencies)} setpoints at {rate:.0f} Hz in {seconds:.0f} s, {os.cpu_count()} cores")
    print(
        "setpoint to state: median {:.2f} ms, p90 {:.2f} ms, p99 {:.2f} ms, largest {:.1f} ms".format(
            *np.percentile(latencies, [50, 90, 99, 100])
        )
    )
    times, sizes = np.array(memory).T
    late = times > 0.2 * times[-1]
    slope = np.polyfit(times[late], sizes[late], 1)[0] if late.sum() > 2 else np.nan
    print(
        f"memory of the node: {sizes[0]:.1f} MB at the start, {sizes[late][0]:.1f} MB after a fifth, "
        f"{sizes[-1]:.1f} MB at the end; trend after a fifth {60.0 * slope:+.3f} MB/min"
    )
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    with running_node("--ros-args", "-p", "robot:=six_rfs") as process:
        measure(process, options.seconds)
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
