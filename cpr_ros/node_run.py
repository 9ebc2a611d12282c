# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the start of ROS to its end, with the node in between."""

from __future__ import annotations

import gc
import sys
import traceback
from collections.abc import Callable
from typing import NoReturn

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from cpr_core import CprError
from cpr_core.errors import warnings_as_lines

from .node import CprNode
from .process.core_log import core_log_in
from .process.spinning import spin
from .process.stop_signal import StopSignal

__all__ = ["run"]


def run(
    make_node: Callable[[StopSignal], CprNode],
    arguments: list[str] | None = None,
    stop: StopSignal | None = None,
) -> NoReturn:
    """Run a node until SIGINT or SIGTERM, and end the process: status 0, or 1 if it cannot start.

    Args:
        make_node: Makes it.
        arguments: With the name of the program first; None for those of the process.
        stop: What has taken the signals over already.
    """
    stop = stop or StopSignal()
    executor: Executor | None = None
    node, status = None, 0
    stop.remember()
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        executor = _light_executor()
        if not stop.requested:
            node = make_node(stop)
            executor.add_node(node)
            with core_log_in(node.get_logger()), warnings_as_lines():
                if node.parameters.autostart and not node.start():
                    status = 1
                else:
                    spin(executor, stop, node.log_exception, node.until_due, node.do_what_is_due)
    except Exception as error:
        if not stop.requested:
            known = isinstance(error, CprError | ParameterException)
            expected = known or executor is None or not rclpy.ok()
            print(f"cpr_node: {error}" if expected else traceback.format_exc(), file=sys.stderr)
            status = 1
    finally:
        if executor is not None:
            executor.shutdown()
        if node is not None:
            node.destroy_node()
        else:
            gc.collect()  # of a node that could not be made DDS still has a part
        rclpy.try_shutdown()
    stop.finish(status)


def _light_executor() -> Executor:
    """One that is woken by events: at rest the node takes a third of the processor time it takes else.

    Older versions of rclpy have none. Both run one callback after the other. With rclpy 7.1 it has
    crashed in clients that destroy subscriptions or action clients meanwhile: the node destroys none.
    """
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
