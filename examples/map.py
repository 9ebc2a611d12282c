# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map of the workspace, made by a running cpr_node from where its robot is now.

    .venv/bin/cpr_node --ros-args -p robot:=rfrfr
    .venv/bin/python examples/map.py map.nc x=-0.9:0.9 y=-1:1 --resolution 0.02

Ctrl-C cancels the map; the same command goes on with it, as it does where the node was gone.
"""

from __future__ import annotations

import argparse
import math
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import cpr_ros  # noqa: F401  finds the ROS 2 of this environment
import rclpy
from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode, MapAxis
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

#: How long the node is waited for, and what it answers at once [s].
TIMEOUT = 20.0


def goal_of(options: argparse.Namespace) -> MapWorkspace.Goal:
    """What is asked of the node: NAME=FIRST:LAST is an axis, NAME=VALUE is held."""
    goal = MapWorkspace.Goal(file=str(options.file), existing_file=MapWorkspace.Goal.RESUME)
    for part in options.slice:
        name, numbers = part.split("=")
        ends = [float(number) for number in numbers.split(":")]
        if len(ends) == 2:
            axis = MapAxis(name=name, first=ends[0], last=ends[1], resolution=options.resolution)
            goal.axes.append(axis)
        else:
            goal.held.append(name)
            goal.held_values.append(ends[0])
    return goal


class MapClient(Node):
    """Asks one cpr_node in its namespace for a map."""

    def __init__(self) -> None:
        """Nothing is asked for yet."""
        super().__init__("map_client")
        self._client = ActionClient(self, MapWorkspace, "cpr_node/map_workspace")

    def make(self, goal: MapWorkspace.Goal, enough: threading.Event) -> MapWorkspace.Result:
        """Have a map made, or cancelled once it is enough.

        Raises:
            TimeoutError: No cpr_node is there, it is gone, or it answers no more.
        """
        end = time.monotonic() + TIMEOUT
        while not self._client.wait_for_server(0.1):
            if enough.is_set() or time.monotonic() > end:
                raise TimeoutError("no cpr_node offers maps")
        sent = self._client.send_goal_async(goal, feedback_callback=show)
        self._spin_until(sent.done, TIMEOUT)
        ended = sent.result().get_result_async()
        self._spin_until(lambda: ended.done() or enough.is_set())
        if not ended.done():
            self._spin_until(sent.result().cancel_goal_async().done, TIMEOUT)
            self._spin_until(ended.done, TIMEOUT)
        return ended.result().result

    def _spin_until(self, done: Callable[[], bool], timeout: float = math.inf) -> None:
        """Spin until something holds; a future of a node that is gone is never done.

        Raises:
            TimeoutError: It does not hold in time [s], or the node is gone.
        """
        end = time.monotonic() + timeout
        while not done():
            if not self._client.server_is_ready():
                raise TimeoutError("cpr_node is gone")
            if time.monotonic() > end:
                raise TimeoutError("cpr_node answers no more")
            rclpy.spin_once(self, timeout_sec=0.1)


def main() -> int:
    """Send the goal and show what comes back; exit status 0 for a complete map."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="NetCDF file, in the map_directory of the node")
    parser.add_argument("slice", nargs="+", help="NAME=FIRST:LAST or NAME=VALUE")
    parser.add_argument("--resolution", type=float, default=0.01)
    options = parser.parse_args()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C has to reach the node first
    # A flag, for an exception could end up anywhere in a callback, and be lost there.
    enough = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: enough.set())
    node = MapClient()
    try:
        result = node.make(goal_of(options), enough)
    except TimeoutError as error:
        print(f"\nmap: {error}", file=sys.stderr)
        return 1
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    if result.error_code.val != ErrorCode.SUCCESS:
        print(f"\n{result.error_code.val}: {result.error_code.message}")
    print(f"\n{result.file}: {result.reached} of {result.cells} cells are reached")
    print(f"  stable {result.stable}, usable {result.usable}, area {result.cell_area:g} each")
    for border in result.borders:
        print(f"  border {border.kind}: {border.points} points")
    return 0 if result.complete else 1


def show(message: object) -> None:
    """Feedback on one line."""
    state = message.feedback  # type: ignore[attr-defined]
    print(f"\r{state.done} of {state.reached} cells, {state.rate:.0f}/s ", end="", flush=True)


if __name__ == "__main__":
    sys.exit(main())
