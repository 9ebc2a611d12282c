# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot on the bench, simulated: what a tracker and the torque sensors of its motors would tell of it.

    .venv/bin/python examples/bench_robot.py measure poses.csv data.csv
    .venv/bin/python examples/bench_robot.py push --seconds 10

It is a six_rfs whose rods are softer than its file says and one of whose motors has another zero.
`measure` goes to the motors of a CSV file, under its loads, and writes the poses that are measured,
with noise.
`push` publishes measured_joint_states for a cpr_node while a hand pushes on the platform, and prints
what it does beside what the node feels. docs/bench.md walks through both.
"""

from __future__ import annotations

import argparse
import csv
import math
import signal
import sys
import threading
import time
from pathlib import Path

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import numpy as np
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from cpr_core import Equilibrium, load_robot, read_measurements, solve_forward, solve_home

#: What its file says otherwise: 210 GPa, and no offset.
REALITY = {"rod.young_modulus": 197e9, "legs[2].motor.offset": 0.02}
#: Noise of the tracker [m, rad], and of an effort, relative.
POSITION_NOISE, ROTATION_NOISE, EFFORT_NOISE = 0.5e-3, 2e-3, 0.01
#: At first nobody touches it: what is felt then is not the hand [s].
ALONE = 2.0
#: For a node that feels [s].
LONGEST_WAIT = 60.0
#: Of the joint states [Hz].
RATE = 200.0


def measure(poses: Path, data: Path, seed: int) -> int:
    """Go to the motors of a file and write what the tracker sees."""
    robot = load_robot("six_rfs").with_parameters(REALITY)
    random = np.random.default_rng(seed)
    place: Equilibrium = solve_home(robot)
    with data.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        posed = (*"xyz", "qw", "qx", "qy", "qz")
        writer.writerow([*robot.motor_names, *posed, "mx", "my", "mz", "fx", "fy", "fz"])
        for row in read_measurements(robot, poses):
            place = solve_forward(robot, row.motors, start=place, loads=row.loads)
            position = place.platform_position + random.normal(0.0, POSITION_NOISE, 3)
            orientation = turned(place.platform_quaternion, random.normal(0.0, ROTATION_NOISE, 3))
            numbers = [place.motors, position, orientation, place.loads.wrench_world]
            writer.writerow(np.concatenate(numbers).tolist())
    return 0


def turned(quaternion: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """A unit quaternion (w, x, y, z) after a small turn about axes of the world."""
    w, vector = quaternion[0], quaternion[1:]
    found = np.concatenate(
        [[w - 0.5 * turn @ vector], vector + 0.5 * (w * turn + np.cross(turn, vector))]
    )
    return found / np.linalg.norm(found)


def hand(seconds: float) -> np.ndarray:
    """Wrench of the hand on the platform: moment, then force in the world, (6,) [N m, N]."""
    if seconds < ALONE:
        return np.zeros(6)
    push = math.sin(0.5 * math.pi * seconds)
    return np.array([0.0, 0.0, 0.005 * push, 0.2 * push, 0.1, -0.3])


class BenchRobot:
    """The robot under a cpr_node: goes where it is told, and tells its joint states."""

    def __init__(self, seed: int) -> None:
        """At home, until commands come; ROS has to be there."""
        self.robot = load_robot("six_rfs").with_parameters(REALITY)
        self.place = solve_home(self.robot)
        self.told: np.ndarray = self.place.motors
        #: What the hand did and what the node felt of it, as rows, (2, 3) [N], since somebody looked.
        self.felt: list[np.ndarray] = []
        self._hands: dict[tuple[int, int], np.ndarray] = {}  # by the stamp of the joint states
        self._random = np.random.default_rng(seed)
        self.node = rclpy.create_node("bench_robot")
        self.node.create_subscription(
            Float64MultiArray, "cpr_node/motor_commands", self._on_commands, 10
        )
        self.node.create_subscription(
            WrenchStamped, "cpr_node/estimated_wrench", self._on_wrench, 10
        )
        self._states = self.node.create_publisher(JointState, "measured_joint_states", 10)

    def _on_commands(self, message: Float64MultiArray) -> None:
        self.told = np.array(message.data)

    def _on_wrench(self, message: WrenchStamped) -> None:
        force, stamp = message.wrench.force, message.header.stamp
        told = self._hands.pop((stamp.sec, stamp.nanosec), None)
        if told is not None:
            self.felt.append(np.array([told, [force.x, force.y, force.z]]))

    def tell(self, wrench: np.ndarray) -> None:
        """Publish where the motors are and what they do under a wrench, (6,)."""
        loads = self.robot.default_loads.with_(wrench_world=wrench.tolist())
        self.place = solve_forward(self.robot, self.told, start=self.place, loads=loads)
        noise = 1.0 + EFFORT_NOISE * self._random.normal(size=self.robot.motor_count)
        message = JointState(name=list(self.robot.motor_names))
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.position = self.place.motors.tolist()
        message.effort = (self.place.efforts * noise).tolist()
        self._hands[message.header.stamp.sec, message.header.stamp.nanosec] = wrench[3:]
        self._states.publish(message)

    def hear(self, until: float) -> None:
        """Take what has come, and what comes up to a time of the monotonic clock."""
        left = 0.0
        while left >= 0.0:
            left = until - time.monotonic()
            rclpy.spin_once(self.node, timeout_sec=max(0.0, left))


def push(seconds: float, seed: int) -> int:
    """Be the robot under a cpr_node while a hand pushes; 0 seconds: until Ctrl-C. Returns the status."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    # A flag, for an exception could end up anywhere in rclpy, and be lost there.
    enough = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: enough.set())
    bench, started, ticks = BenchRobot(seed), time.monotonic(), 0
    untouched: list[np.ndarray] = []
    try:
        while not enough.is_set() and ticks < (RATE * seconds or math.inf):
            now = time.monotonic()
            if not bench.felt and ticks == 0 and now - started > LONGEST_WAIT:
                print("bench_robot: no cpr_node tells what it feels", file=sys.stderr)
                return 1
            # Its own time, by which a busy computer takes longer.
            bench.tell(hand(ticks / RATE))
            bench.hear(now + 1.0 / RATE)
            ticks += ticks > 0 or bool(bench.felt)
            if ticks % RATE or not bench.felt:
                continue
            told, felt = np.mean(bench.felt, axis=0)
            bench.felt.clear()
            if ticks <= ALONE * RATE:
                untouched.append(felt)
            else:
                print(
                    f"hand {told.round(2)} N, felt {(felt - np.mean(untouched, axis=0)).round(2)} N"
                )
        if untouched:
            print(f"felt without a hand: {np.mean(untouched, axis=0).round(2)} N")
    finally:
        bench.node.destroy_node()
        rclpy.try_shutdown()
    return 0


def main() -> int:
    """Measure or push; exit status 0, or 1 where no node feels anything."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    measuring = commands.add_parser("measure", help="poses at the motors of a file, with noise")
    measuring.add_argument(
        "poses", type=Path, help="CSV file with motors, as cpr measure writes it"
    )
    measuring.add_argument("data", type=Path, help="CSV file to write, as cpr calibrate takes it")
    measuring.set_defaults(run=lambda given: measure(given.poses, given.data, given.seed))
    pushing = commands.add_parser("push", help="joint states with efforts, while a hand pushes")
    pushing.add_argument("--seconds", type=float, default=0.0, help="default: until Ctrl-C")
    pushing.set_defaults(run=lambda given: push(given.seconds, given.seed))
    for command in (measuring, pushing):
        command.add_argument("--seed", type=int, default=0, help="of the noise")
    options = parser.parse_args()
    status: int = options.run(options)
    return status


if __name__ == "__main__":
    sys.exit(main())
