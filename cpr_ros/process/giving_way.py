# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Leaving the processor to whoever waits for a message that was just sent. No ROS here.

The kernel wakes who waits for a message on the processor of who has sent it. If that one goes on
computing, the other one has the message only when it is done, while another processor may be idle.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

__all__ = ["GivingWay"]

#: So much later than asked is woken who shares the processor with others that compute [s].
_LATE = 1e-3
#: For so long it does not give way then [s].
_KEEPING = 0.2


class GivingWay:
    """Sleeps for a moment, unless others than those who wait have taken the processor lately.

    Where more computes than there are processors, every sleep hands the processor to somebody who keeps
    it for milliseconds.
    """

    def __init__(
        self,
        longest: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Know of nobody else.

        Args:
            longest: Sleep for no longer [s].
            clock: Steady time [s].
            sleep: Lets so much time go by [s].
        """
        self._longest, self._clock, self._sleep = longest, clock, sleep
        self._from = -math.inf

    def sleep(self, seconds: float) -> None:
        """Sleep for so long if it is of use [s]."""
        begin, asked = self._clock(), min(seconds, self._longest)
        if begin < self._from:
            return
        self._sleep(asked)
        woken = self._clock()
        if woken > begin + asked + _LATE:
            self._from = woken + _KEEPING
