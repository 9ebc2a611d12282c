# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node costs at rest, and how soon it acts on what comes then.

    .venv/bin/python -m benchmarks.ros_at_rest --seconds 20 --setpoints 300

Processor time of a node with the 6-RFS robot while nobody listens, and while its streams are heard,
beside that of a bare node which publishes as many empty messages of the same kinds. Then setpoints near
by, of motors and of the platform, each sent at rest: the time until the motor command arrives, beside
that of the bare node, which publishes whatever it receives, and of the floor, which does so with bytes
and without an executor. Each is asked by an ordinary client of rclpy, and by one that is as quick as
rclpy and DDS can be. All take turns, so that they see the same machine. The streams go on meanwhile;
who listens to them is not the client that waits, which would be busy with 240 other messages a second.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from cpr_core import Equilibrium, load_robot, solve_home
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from .quick_client import QuickClient
from .running_node import Spun, running_node

#: Of a motor from setpoint to setpoint [rad], and of the platform [m].
STEP, PLATFORM_STEP = 0.002, 0.0005
#: Robot and streams are at rest after that time [s].
PAUSE = 0.1


#: What setpoints are, where they go, and where what answers them comes from.
PAIRS = {
    "motor setpoint to command": (
        Float64MultiArray,
        "/cpr_node/commands",
        "/cpr_node/motor_commands",
    ),
    "platform setpoint to command": (
        PoseStamped,
        "/cpr_node/platform_setpoint",
        "/cpr_node/motor_commands",
    ),
    "bare echo": (Float64MultiArray, "/echo/in", "/echo/out"),
    "floor": (Float64MultiArray, "/floor/in", "/floor/out"),
}
#: What the node publishes at rest, and how often [Hz].
STREAMS = (
    (JointState, "/joint_states", 50.0),
    (PoseStamped, "/cpr_node/platform_pose", 50.0),
    (StabilityMetrics, "/cpr_node/stability", 20.0),
)


def of_echo(topic: str) -> str:
    """Where the bare node publishes what the node publishes to a topic."""
    return f"/echo/{topic.rsplit('/', 1)[1]}"


def echo() -> None:
    """A node that publishes what it receives, and streams if they are heard, until it is killed."""
    rclpy.init()
    node = Spun("echo")
    streams = [
        (node.create_publisher(kind, of_echo(topic), 10), serialize_message(kind()), 1.0 / rate)
        for kind, topic, rate in STREAMS
    ]
    due = [time.monotonic()] * len(streams)
    publisher = node.create_publisher(Float64MultiArray, "/echo/out", 10)
    node.create_subscription(
        Float64MultiArray, "/echo/in", lambda message: publisher.publish(message), 1
    )
    while True:
        node.executor_.spin_once(timeout_sec=max(0.0, min(due) - time.monotonic()))
        heard = streams[0][0].get_subscription_count() > 0
        for number, (stream, message, period) in enumerate(streams):
            if due[number] <= time.monotonic():
                due[number] += period if heard else 0.1
                if heard:
                    stream.publish(message)


def floor() -> None:
    """Publishes the bytes it receives until it is killed: what rclpy and DDS take at least."""
    rclpy.init()
    client = QuickClient(Node("floor"), "/floor/out", "/floor/in", depth=1)
    while True:
        client.wait(1.0)
        if message := client.take():
            client.publisher.publish(message)


class Listener(Spun):
    """Counts messages of the streams."""

    def __init__(self) -> None:
        super().__init__("streams_benchmark")
        self.messages: Counter[str] = Counter()

    def listen(self) -> None:
        """To the streams."""
        for kind, topic, _ in STREAMS:
            self.create_subscription(kind, topic, self._counting("node"), 10)
            self.create_subscription(kind, of_echo(topic), self._counting("bare node"), 10)

    def _counting(self, whose: str) -> Callable[[Any], None]:
        def count(_message: Any) -> None:
            self.messages[whose] += 1

        return count


class Sender(Spun):
    """Sends, and notes when something comes back."""

    def __init__(self) -> None:
        super().__init__("at_rest_benchmark")
        self.came = 0.0
        self._newest: dict[str, list[float]] = {}

    def pair(self, kind: type[Any], sent: str, received: str) -> Any:
        """A publisher, and what answers it."""
        self.create_subscription(
            Float64MultiArray, received, lambda message: self._on_answer(received, message), 10
        )
        return self.create_publisher(kind, sent, 1)

    def _on_answer(self, topic: str, message: Float64MultiArray) -> None:
        numbers = list(message.data)
        if numbers != self._newest.get(topic):  # at rest commands are repeated
            self._newest[topic], self.came = numbers, self.came or time.perf_counter()

    def latency(self, publisher: Any, setpoint: Any) -> float:
        """Time from sending to the first message that is new [s]."""
        self.came = 0.0
        begin = time.perf_counter()
        publisher.publish(setpoint)
        while not self.came and time.perf_counter() < begin + 5.0:
            self.executor_.spin_once(timeout_sec=0.1)
        if not self.came:
            raise TimeoutError(f"no answer on {publisher.topic_name}")
        return self.came - begin


def near_by(kind: type[Any], home: Equilibrium, first: int, second: int) -> Any:
    """A setpoint so many steps from home."""
    if kind is Float64MultiArray:
        motors = home.motors.copy()
        motors[:2] += STEP * np.array([first, second])
        return Float64MultiArray(data=motors.tolist())
    message = PoseStamped()
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y, position.z = (
        home.platform_position + PLATFORM_STEP * np.array([first, second, 0.0])
    ).tolist()
    orientation.w, orientation.x, orientation.y, orientation.z = home.pose[3:].tolist()
    return message


def processor_time(process: subprocess.Popen[bytes]) -> float:
    """Of all threads so far [s]."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def load(processes: dict[str, subprocess.Popen[bytes]], listener: Listener, seconds: float) -> str:
    """Processor time of processes, in words."""
    begin, listener.messages = time.perf_counter(), Counter()
    used = {name: processor_time(process) for name, process in processes.items()}
    listener.spin(seconds)
    took = time.perf_counter() - begin
    return "; ".join(
        f"{name} {100.0 * (processor_time(process) - used[name]) / took:5.2f} % of a core, "
        f"{listener.messages[name] / took:.0f} messages/s"
        for name, process in processes.items()
    )


def measure(processes: dict[str, subprocess.Popen[bytes]], seconds: float, setpoints: int) -> None:
    """Print what was found."""
    rclpy.init()
    node, listener = Sender(), Listener()
    publishers = {name: node.pair(*topics) for name, topics in PAIRS.items()}
    quick = Node("quick_client")
    clients = {
        name: QuickClient(quick, sent, received, kind=kind)
        for name, (kind, sent, received) in PAIRS.items()
    }
    all_publishers = [*publishers.values(), *(client.publisher for client in clients.values())]
    while not all(publisher.get_subscription_count() for publisher in all_publishers):
        node.spin(0.1)
    node.spin(3.0)  # discovery, and the first ticks
    print(f"at rest, nobody listens:  {load(processes, listener, seconds)}")
    listener.listen()
    listener.spin(2.0)
    print(f"at rest, streams heard:   {load(processes, listener, seconds)}")
    random = np.random.default_rng(0)
    times: dict[str, list[float]] = {}
    home = solve_home(load_robot("six_rfs"))
    for number in range(setpoints):
        for client, away in (("ordinary", 0), ("quick", 1)):
            for name, (kind, *_) in PAIRS.items():
                node.spin(PAUSE + (0.02 * random.random()))
                message = near_by(kind, home, 1 + number % 2, away)
                asked = publishers[name] if client == "ordinary" else clients[name]
                took = (
                    node.latency(asked, message) if client == "ordinary" else asked.latency(message)
                )
                times.setdefault(f"{name}, {client} client", []).append(took)
    for name, values in times.items():
        least, median, high, largest = 1e3 * np.percentile(values[10:], [10, 50, 99, 100])
        print(
            f"{name:36} p10 {least:5.2f} ms, median {median:5.2f} ms, p99 {high:5.2f} ms, "
            f"largest {largest:5.1f} ms"
        )
    node.end()
    listener.end()
    quick.destroy_node()
    rclpy.try_shutdown()


def main() -> int:
    """Run the benchmark, or, with --echo and --floor, what it is measured beside."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--setpoints", type=int, default=300)
    parser.add_argument("--echo", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--floor", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.echo:
        echo()
    if options.floor:
        floor()
    program = [sys.executable, "-m", "benchmarks.ros_at_rest"]
    with running_node("--ros-args", "-p", "start_from:=home") as process:
        bare, least = (subprocess.Popen([*program, name]) for name in ("--echo", "--floor"))
        try:
            measure({"node": process, "bare node": bare}, options.seconds, options.setpoints)
        finally:
            bare.kill()
            least.kill()
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
