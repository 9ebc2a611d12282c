# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What one thread looks after, part by part. No ROS here."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

__all__ = ["Part", "Parts"]


class Part(Protocol):
    """Something that is to be done at times."""

    @property
    def due(self) -> float:
        """Steady time at which to look [s]; infinite while nothing is to be done."""

    def look(self, now: float) -> None:
        """Do it, if it is time to; asked as well whenever something may have come."""


class Parts:
    """Looks after all in turn; one that fails takes no turn from the others."""

    def __init__(
        self,
        parts: tuple[Part, ...],
        failed: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Look at nothing yet.

        Args:
            parts: In the order in which they are looked after.
            failed: Called where what a part has raised is the exception at hand.
            clock: Steady time [s].
        """
        self._parts, self._failed, self._clock = parts, failed, clock

    @property
    def due(self) -> float:
        """Steady time at which the first is due [s]; infinite if none is."""
        return min(part.due for part in self._parts)

    def look(self) -> None:
        """Do what is due."""
        for part in self._parts:
            try:
                part.look(self._clock())
            except Exception:
                self._failed()
