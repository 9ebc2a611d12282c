# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is looked after between ticks, as part of what is due to the thread that spins. No rclpy here."""

from __future__ import annotations

import math
from collections.abc import Callable

from .session import Session

__all__ = ["BetweenTicks"]


class BetweenTicks:
    """Settles doubts, and at rest judges what may be asked for next.

    Attributes:
        due: Steady time of the next look [s]; infinite while there is nothing to look at.
    """

    def __init__(self, session: Session, resting: Callable[[], bool]) -> None:
        """Look at nothing yet.

        Args:
            session: The robot, also while the node is not active.
            resting: Whether the node is active and the robot rests.
        """
        self._session, self._resting, self.due = session, resting, math.inf

    def look(self, now: float) -> None:
        """Look at a steady time [s]; to be asked whenever something may have come."""
        session = self._session
        session.moved_by_others.look(now)
        session.orders.end_if_stopped()
        if self._resting() and session.tracking is None and not session.follower.paused:
            session.first_step.look(session.solver.current, now)
        else:
            session.first_step.wait()
        self.due = min(session.moved_by_others.due, session.first_step.due)
