# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is looked after between ticks, as part of what is due to the thread that spins. No rclpy here."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..process.ticking import Ticking
from .session import Session

__all__ = ["BetweenTicks"]


class BetweenTicks:
    """Settles doubts, and at rest judges what may be asked for next."""

    def __init__(self, session: Callable[[], Session | None], ticking: Ticking) -> None:
        """Look at nothing yet.

        Args:
            session: Gives the robot, also while the node is not active; None: there is none.
            ticking: Whether the robot rests.
        """
        self._session, self._ticking = session, ticking

    @property
    def due(self) -> float:
        """Steady time of the next look [s]; infinite while there is nothing to look at."""
        session = self._session()
        if session is None:
            return math.inf
        return min(session.others.due, session.first_step.due)

    def look(self, now: float) -> None:
        """Look at a steady time [s]; to be asked whenever something may have come."""
        session = self._session()
        if session is not None:
            session.look_around(now, self._ticking.resting)
