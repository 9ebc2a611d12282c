# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether a page may send setpoints, and which it was asked for. No ROS here."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

__all__ = ["PageControl"]

#: What is pressed so soon after control was given back is a second click on the same place [s].
_SECOND_CLICK = 1.0


class PageControl:
    """Asked by the thread of the browser, emptied by that of the node."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Nobody is in control.

        Args:
            clock: Steady time [s].
        """
        self._lock, self._clock = threading.Lock(), clock
        self._taken, self._given_back = False, -math.inf
        self._asked: dict[int, float] = {}

    @property
    def taken(self) -> bool:
        """Whether setpoints are sent."""
        return self._taken

    @property
    def asks(self) -> bool:
        """Whether anything was asked for that is not taken yet."""
        return bool(self._asked)

    def take(self) -> None:
        """Somebody is in control from now on; who was before still is.

        Not just after it was given back: that is the second half of a double click, and whoever gives
        control back walks away without it.
        """
        with self._lock:
            self._taken = self._taken or self._clock() - self._given_back >= _SECOND_CLICK

    def give_back(self, *, pressed: bool = False) -> bool:
        """Nobody is in control from now on; returns whether somebody was.

        Args:
            pressed: Whether somebody has pressed a button for it.
        """
        with self._lock:
            before, self._taken = self._taken, False
            self._asked.clear()
            if before and pressed:
                self._given_back = self._clock()
            return before

    def ask(self, motor: int, position: float) -> bool:
        """Ask for a position of a motor; returns whether it is taken, as only of who is in control.

        Args:
            motor: Its number.
            position: Where to [rad or m].
        """
        with self._lock:
            if self._taken:
                self._asked[motor] = position
            return self._taken

    def take_asked(self) -> dict[int, float]:
        """Positions that were asked for since, by number of the motor."""
        with self._lock:
            asked, self._asked = self._asked, {}
            return asked
