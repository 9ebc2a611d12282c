# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the arguments of ``cpr_view`` to the end of its page."""

from __future__ import annotations

import argparse
import sys

import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from cpr_core import CprError

from ..process.spinning import spin
from ..process.stop_signal import StopSignal
from .view_node import ViewNode

__all__ = ["run"]


def run(arguments: list[str]) -> int:
    """Show the page until SIGINT or SIGTERM.

    Args:
        arguments: With the name of the program first.

    Returns:
        Exit status: 0; 1 if there is no viser, the address cannot be had, or the name is none.
    """
    parser = argparse.ArgumentParser(
        prog="cpr_view",
        description="A running cpr_node in the browser: its robot, its stability, its last minute.",
        epilog="Arguments of ROS go behind --ros-args.",
    )
    parser.add_argument("--node", default="cpr_node", metavar="NAME", help="else cpr_node")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="where to listen; else 127.0.0.1: whoever reaches the page can move the robot",
    )
    parser.add_argument("--port", type=int, default=8081, metavar="N", help="default 8081; 0: any")
    options = parser.parse_args(remove_ros_args(arguments)[1:])
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    stop = StopSignal()
    stop.remember()
    try:
        node = ViewNode(options.node, options.host, options.port)
    except (CprError, NameValidationException) as error:
        print(f"cpr_view: {error}", file=sys.stderr)
        rclpy.try_shutdown()
        return 1
    print(f"{options.node}: look at {node.page.address} (Ctrl-C ends)", flush=True)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        spin(executor, stop, node.log_exception)
    finally:
        node.page.close()
        node.destroy_node()
        rclpy.try_shutdown()
    return 0
