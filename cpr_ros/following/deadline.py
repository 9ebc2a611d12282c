# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One time limit for all parts of a request: each is given what those before have left. No ROS here."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Deadline"]


class Deadline:
    """When a request has to be answered."""

    def __init__(self, allowed: float, clock: Callable[[], float] = time.perf_counter) -> None:
        """Begin now.

        Args:
            allowed: Time for all of the request [s].
            clock: Steady time [s].
        """
        self._clock, self._end = clock, clock() + allowed

    @property
    def left(self) -> float:
        """Time that is left for what is still to be done [s]; 0: none."""
        return max(0.0, self._end - self._clock())
