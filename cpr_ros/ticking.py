# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When ticks come: one a period while there is something to do, none at rest. No ROS here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

__all__ = ["Ticking", "Timer"]

#: How much later than planned a tick may come without moving the next one, part of a period. So much
#: closer together than a period may two ticks come, and no closer.
JITTER = 0.05


class Timer(Protocol):
    """A timer of the period of a tick, as rclpy makes them."""

    def reset(self) -> None:
        """Run; the next time is a period from now."""
        ...

    def cancel(self) -> None:
        """Run no more."""
        ...


class Ticking:
    """Ticks while there is something to do.

    What comes at rest is acted on at once, and ticks follow a period apart from that moment. A tick that
    was late is not made up for: in any time there are no more ticks than periods that have begun.

    Attributes:
        late: Number of ticks that came more than a period late.
    """

    def __init__(
        self, period: float, tick: Callable[[float], None], at_rest: Callable[[], bool]
    ) -> None:
        """Have no timer yet.

        Args:
            period: Time of a tick [s].
            tick: Does one, at a steady time [s].
            at_rest: Whether a tick would change nothing, until something comes from outside.
        """
        self.late = 0
        self._period, self._tick, self._at_rest = period, tick, at_rest
        self._timer: Timer | None = None
        self._running = False
        self._due = 0.0

    def start(self, timer: Timer, now: float) -> None:
        """Begin with a tick in a period.

        Args:
            timer: Calls :meth:`on_timer`; it has just been started.
            now: Steady time [s].
        """
        self._timer, self._running = timer, True
        self._due = now + self._period

    def stop(self) -> None:
        """Tick no more; whoever made the timer destroys it."""
        self._timer, self._running = None, False

    def wake(self, now: float) -> None:
        """Tick at once if ticks rest and there is something to do. Ask after whatever has happened."""
        if self._timer is None or self._running or self._at_rest():
            return
        self._running = True
        self._from_now_on(self._timer, now)
        self._tick(now)

    def on_timer(self, now: float) -> None:
        """Tick, or rest."""
        if self._timer is None or not self._running or now < self._due - JITTER * self._period:
            return
        if self._at_rest():
            self._running = False  # a period after the last tick: the next one may come at any time
            self._timer.cancel()
            return
        lateness = now - self._due
        self.late += lateness > self._period
        if lateness > JITTER * self._period:
            self._from_now_on(self._timer, now)
        else:
            self._due += self._period
        self._tick(now)

    def _from_now_on(self, timer: Timer, now: float) -> None:
        """The next tick in a period."""
        timer.reset()
        self._due = now + self._period
