# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is not measured though it should be, until it has come again for a while. No ROS here."""

from __future__ import annotations

import math

__all__ = ["SETTLED", "Sight"]

#: What is measured again and is missing again within this time was missing all along [s].
SETTLED = 1.0


class Sight:
    """Keeps what a supervisor is told from changing with every message of a slow or broken sensor."""

    def __init__(self) -> None:
        """Miss nothing."""
        self.forget()

    def forget(self) -> None:
        """Be as if nothing had ever been missing."""
        self._problem, self._missed_at = "", -math.inf

    def missing(self, problem: str, now: float) -> str:
        """What is missing, in words; empty: nothing.

        Args:
            problem: What is missing at this moment; empty: nothing.
            now: Steady time [s], not before the last.
        """
        if problem:
            self._problem, self._missed_at = problem, now
            return problem
        if now - self._missed_at >= SETTLED:
            return ""
        return f"{self._problem}; it came again less than {SETTLED:g} s ago"
