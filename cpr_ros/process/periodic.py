# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is said again and again, each at its own rate, by the thread that spins. No ROS here.

Timers of rclpy wake a thread of their own first: two switches for every call where one does, and calls
that are due together wake it one by one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["LOOK", "Periodic"]

#: How often it is asked whether anybody wants what nobody wanted before [s].
LOOK = 0.1
#: What rounding may do to a time [s].
_NOTHING = 1e-6


@dataclass
class _Stream:
    """Of one rate: its calls are due at whole periods from the beginning [s]."""

    period: float
    say: Callable[[], None]
    wanted: Callable[[float], bool]
    due: float

    def due_after(self, passed: float) -> None:
        """Be due at the first whole period after a time [s]."""
        self.due = (math.floor(passed / self.period) + 1) * self.period


class Periodic:
    """Calls at rates. All begin together, so that those of related rates come together.

    A call that was late is not made up for; the next ones come when they would have come without it.

    Attributes:
        due: Steady time of the next call [s]; infinite without any.
    """

    def __init__(self) -> None:
        """Call nothing yet."""
        self.due, self._begin = math.inf, 0.0
        self._streams: list[_Stream] = []

    def begin(self, now: float) -> None:
        """Call nothing any more; what is added from now on begins at this steady time [s]."""
        self._begin, self._streams = now, []
        self._find_due()

    def add(
        self,
        rate: float,
        say: Callable[[], None],
        wanted: Callable[[float], bool] = lambda now: True,
    ) -> None:
        """Call from a period after the beginning on.

        Args:
            rate: How often [Hz].
            say: What to call; what it raises ends the look, and the others are called in the next.
            wanted: Whether anybody wants it, at a steady time [s]; if not, this is asked more seldom.
        """
        self._streams.append(_Stream(1.0 / rate, say, wanted, 1.0 / rate))
        self._find_due()

    def look(self, now: float) -> None:
        """Call what is due at a steady time [s]; to be asked whenever something may be."""
        if now < self.due:
            return
        passed = now - self._begin
        for stream in self._streams:
            if stream.due <= passed:
                stream.due_after(passed)
                if stream.wanted(now):
                    stream.say()
                else:  # what nobody wants is looked at together, with one waking up
                    stream.due_after(LOOK * (math.floor(passed / LOOK) + 1) - _NOTHING)
        self._find_due()

    def _find_due(self) -> None:
        due = min((stream.due for stream in self._streams), default=math.inf)
        self.due = self._begin + due
