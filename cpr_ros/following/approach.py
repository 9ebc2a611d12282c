# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether motors that are not yet where they were sent come nearer. No ROS here.

Commands may rest as far ahead of the motors as `max_lead` lets them: slow drives take longer than any
fixed time to come there, and are neither jammed nor moved by others.
"""

from __future__ import annotations

import math

from .standstill import RESTING

__all__ = ["Approach"]


class Approach:
    """Follows the largest way that is left to a command.

    Attributes:
        since: Steady time at which they came nearer last, or at which it began [s].
        leaving: Whether they are farther away again than they were.
    """

    def __init__(self) -> None:
        """Know of no command yet."""
        self.begin()

    def begin(self, since: float = math.inf) -> None:
        """Commands go elsewhere, or the motors are there: what was before tells nothing.

        Args:
            since: Steady time at which it begins [s]; infinite: when a way is taken first.
        """
        self._nearest, self.since, self.leaving = math.inf, since, False

    def take(self, way: float, now: float) -> None:
        """Take the way that is left [rad, rod lengths]; NaN: nobody knows."""
        self.since = min(self.since, now)
        if way < self._nearest - RESTING:
            if self._nearest < math.inf:  # where it begins tells nothing
                self.since = now
            self._nearest = way
        self.leaving = way > self._nearest + RESTING
