# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Spinning a node until it is told to stop."""

from __future__ import annotations

from collections.abc import Callable

import rclpy
from rclpy.executors import Executor, ExternalShutdownException

from .stop_signal import StopSignal

__all__ = ["spin"]

#: How often it is looked whether a signal has come [s].
_LOOK = 0.1


def spin(
    executor: Executor,
    stop: StopSignal,
    failed: Callable[[], None],
    until_due: Callable[[], float] = lambda: _LOOK,
    do_what_is_due: Callable[[], None] = lambda: None,
) -> None:
    """Spin until a signal comes; no message of a client may end it.

    Args:
        executor: Has the node.
        stop: Hears of signals.
        failed: Called where what a callback has raised is the exception at hand.
        until_due: How long there is nothing to do but to answer [s].
        do_what_is_due: Called after every callback, and when that time has passed.
    """
    while rclpy.ok() and not stop.requested:
        try:
            executor.spin_once(timeout_sec=min(_LOOK, until_due()))
            do_what_is_due()
        except ExternalShutdownException:
            return
        except Exception:  # rclpy raises for malformed parameter messages, for one
            failed()
