# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When ticks come: one a period while there is something to do, none at rest. No ROS here.

Whoever spins looks after every callback, and waits no longer than until the next tick is due. A timer of
rclpy that is cancelled and reset as motions come and go was seen to stop, and others with it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

__all__ = ["JITTER", "Ticking"]

#: How much later than planned a tick may come without moving the next one, part of a period: so much
#: closer together than a period may two ticks come, and no closer.
JITTER = 0.05
#: What a tick leaves to all else before the next one, part of the time it took.
_BREATHER = 0.1


class Ticking:
    """Ticks while there is something to do.

    What comes at rest is acted on at once, and ticks follow a period apart from that moment. A tick that
    was late is not made up for: in any time there are no more ticks than periods that have begun. Where
    a tick takes nearly a period or more, the next one waits, so that other things are heard meanwhile.

    Attributes:
        due: Steady time of the next tick [s]; infinite at rest.
        late: Number of ticks that came more than a period late.
    """

    def __init__(
        self,
        period: float,
        tick: Callable[[float], None],
        at_rest: Callable[[], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Do not tick yet.

        Args:
            period: Time of a tick [s].
            tick: Does one, at a steady time [s].
            at_rest: Whether a tick would change nothing, until something comes from outside.
            clock: Steady time [s].
        """
        self.due, self.late = math.inf, 0
        self._period, self._tick, self._at_rest, self._clock = period, tick, at_rest, clock
        self._started = False

    @property
    def resting(self) -> bool:
        """Whether ticks come when something comes from outside, and none comes until then."""
        return self._started and math.isinf(self.due)

    def start(self, now: float) -> None:
        """Begin with a tick in a period; ``now`` is steady time [s]."""
        self._started, self.due = True, now + self._period

    def stop(self) -> None:
        """Tick no more."""
        self._started, self.due = False, math.inf

    def look(self, now: float) -> None:
        """Tick if it is time to; to be asked after whatever has happened, and when a tick is due.

        Args:
            now: Steady time [s].
        """
        if not self._started or (math.isfinite(self.due) and now < self.due):
            return
        if self._at_rest():
            self.due = math.inf  # a period after the last tick: the next one may come at any time
            return
        lateness = now - self.due  # of what comes at rest: none
        self.late += lateness > self._period
        on_time = -math.inf < lateness <= JITTER * self._period
        self.due = (self.due if on_time else now) + self._period
        try:
            self._tick(now)
        finally:
            end = self._clock()
            self.due = max(self.due, end + _BREATHER * (end - now))
