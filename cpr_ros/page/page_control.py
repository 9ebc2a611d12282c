# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether a page may send setpoints, and which it was asked for. No ROS here."""

from __future__ import annotations

import threading

__all__ = ["PageControl"]


class PageControl:
    """Asked by the thread of the browser, emptied by that of the node."""

    def __init__(self) -> None:
        """Nobody is in control."""
        self._lock = threading.Lock()
        self._taken = False
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
        """Somebody is in control from now on; who was before still is."""
        with self._lock:
            self._taken = True

    def give_back(self) -> bool:
        """Nobody is in control from now on; returns whether somebody was."""
        with self._lock:
            before, self._taken = self._taken, False
            self._asked.clear()
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
