# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Round trip of the forward service beside that of an empty service of the same node.

    .venv/bin/python -m benchmarks.ros_round_trip --calls 2000

The calls alternate, so that both see the same machine.
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

import numpy as np

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveForward
from rclpy.client import Client
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from cpr_core import load_robot, solve_home
from cpr_ros.node import CprNode
from cpr_ros.node_run import run
from cpr_ros.process.stop_signal import StopSignal

from .running_node import running_node


class NodeWithEmptyService(CprNode):
    """A cpr_node that offers a service that does nothing."""

    def __init__(self, stop: StopSignal) -> None:
        super().__init__(stop)
        self.create_service(Trigger, "~/empty", lambda _request, response: response)


def timed(executor: SingleThreadedExecutor, client: Client, request: object) -> tuple[float, Any]:
    """Time of a call [s] and the answer."""
    begin = time.perf_counter()
    future = client.call_async(request)
    while not future.done():
        executor.spin_once(timeout_sec=1.0)
    return time.perf_counter() - begin, future.result()


def measure(robot: str, calls: int) -> None:
    """Call both services and print the medians."""
    rclpy.init()
    node, executor = Node("round_trip_benchmark"), SingleThreadedExecutor()
    executor.add_node(node)
    forward = node.create_client(SolveForward, "/cpr_node/solve_forward")
    empty = node.create_client(Trigger, "/cpr_node/empty")
    if not (forward.wait_for_service(240.0) and empty.wait_for_service(20.0)):
        raise TimeoutError("the node does not offer its services")
    home = solve_home(load_robot(robot))
    names = list(home.robot.motor_names)
    times: dict[str, list[float]] = {"forward": [], "with eigenvalues": [], "empty": []}
    rng = np.random.default_rng(0)
    for _ in range(calls):
        motors = home.motors + 0.02 * rng.standard_normal(len(names)) * home.robot.motor_units
        state = JointState(name=names, position=motors.tolist())
        for name, eigenvalues in (("forward", False), ("with eigenvalues", True)):
            request = SolveForward.Request(motors=state, with_eigenvalues=eigenvalues)
            took, answer = timed(executor, forward, request)
            if answer.error_code.val != ErrorCode.SUCCESS:
                raise RuntimeError(answer.error_code.message)
            times[name].append(took)
        times["empty"].append(timed(executor, empty, Trigger.Request())[0])
    medians = {name: 1e3 * np.median(values) for name, values in times.items()}
    print(f"{robot}: medians of {calls} calls")
    for name, median in medians.items():
        print(f"{name:20} {median:6.3f} ms, {median / medians['empty']:5.2f} times the empty one")
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


def main() -> int:
    """Run the benchmark, or, with --serve, the node it calls."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="six_rfs")
    parser.add_argument("--calls", type=int, default=2000)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options, others = parser.parse_known_args()
    if options.serve:
        run(NodeWithEmptyService, [sys.argv[0], *others])
    arguments = ("--serve", "--ros-args", "-p", f"robot:={options.robot}")
    with running_node(*arguments, module="benchmarks.ros_round_trip") as process:
        measure(options.robot, options.calls)
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
