# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The clock of an action: goals are stamped in ROS time, results are kept by steady time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.node import Node
from rclpy.time import Time

__all__ = ["ResultClock"]

#: Rate at which time goes on while results are kept [Hz].
_RATE = 1.0


class ResultClock:
    """Reads ROS time while a goal is accepted, and else the steady time it was last set to.

    rcl_action asks one clock for the stamps of goals, which clients may cancel by, and for how long it
    has kept a result. By ROS time a result was lost with a jump, as where ``use_sim_time`` is changed,
    and kept for ever in a pause.

    An action server is made for it in place of the node, and must not outlive it.
    """

    def __init__(self, node: Node, kept: int, forget: Callable[[], None]) -> None:
        """No goal has come yet.

        Args:
            node: The node, with its ROS time.
            kept: How long results are kept [s].
            forget: Is called again and again while some are, to forget what was kept for long enough.
        """
        self._node, self._forget = node, forget
        self._kept, self._ended = kept * 10**9, 0
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._clock = ROSClock()  # of the kind that can be set
        self._timer: Any = None
        with self._clock.handle:
            self._clock.handle.set_ros_time_override_is_enabled(True)
        self._set_to_steady_time()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)

    def get_clock(self) -> ROSClock:
        """What rclpy asks a node for."""
        return self._clock

    def begin_to_accept(self) -> None:
        """A goal is about to be stamped."""
        self._clock.set_ros_time_override(self._node.get_clock().now())

    def accepted(self) -> None:
        """It was stamped."""
        self._set_to_steady_time()

    def ending(self) -> None:
        """A goal is about to end: its result is kept from now on."""
        self._ended = self._set_to_steady_time()
        if self._timer is None:
            self._timer = self._node.create_timer(1.0 / _RATE, self._go_on, clock=self._steady)

    def close(self) -> None:
        """Results are kept no longer."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None

    def _go_on(self) -> None:
        if self._set_to_steady_time() - self._ended > self._kept:
            self.close()
        self._forget()

    def _set_to_steady_time(self) -> int:
        """Steady time [ns]."""
        now = self._steady.now().nanoseconds
        self._clock.set_ros_time_override(Time(nanoseconds=now, clock_type=ClockType.ROS_TIME))
        return now
