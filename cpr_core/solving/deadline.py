# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One time limit for all parts of a request: each is given what those before have left."""

from __future__ import annotations

import time
from collections.abc import Callable

from ..validation import checked_time

__all__ = ["Deadline"]


class Deadline:
    """When a request has to be answered."""

    def __init__(
        self, time_limit: float | None, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        """Begin now.

        Args:
            time_limit: Time for all of the request [s]; None: without end.
            clock: Steady time [s].

        Raises:
            InvalidRequest: A time limit that is negative or no number.
        """
        allowed = checked_time(time_limit)
        self._clock, self._end = clock, clock() + allowed

    @property
    def left(self) -> float:
        """Time that is left for what is still to be done [s]; 0: none, infinite: without end."""
        return max(0.0, self._end - self._clock())

    @property
    def over(self) -> bool:
        """Whether no time is left."""
        return self._clock() >= self._end
