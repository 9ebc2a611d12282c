# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is not measured as it should be, until it has been for a while. No ROS here."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..closed_loop.loop_status import Loop, LoopStatus
from ..following.external_wrench import ExternalWrench
from ..following.measured_motors import MeasuredMotors

__all__ = ["SETTLED", "Senses", "Sight"]

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


class Senses:
    """What of a robot is to be measured, or was, and is not: what is moved then is moved unseen."""

    def __init__(
        self,
        motors: MeasuredMotors | None,
        wrench: ExternalWrench,
        loop: Callable[[float], LoopStatus],
        lag: Callable[[], str],
    ) -> None:
        """Miss nothing.

        Args:
            motors: Measured motors of a robot that the node moves; None: of those that are tracked
                the state tells.
            wrench: External wrench.
            loop: Tells at a steady time [s] whether the measured pose corrects the setpoint.
            lag: Tells whether commands wait for motors, in words; empty: they do not.
        """
        self._motors, self._wrench, self._loop, self._lag = motors, wrench, loop, lag
        self._sight_of_motors, self._sight_of_platform = Sight(), Sight()
        self._sight_of_wrench, self._sight_of_lag = Sight(), Sight()

    def forget(self) -> None:
        """Be as if nothing had ever been missing."""
        for sight in (
            self._sight_of_motors,
            self._sight_of_lag,
            self._sight_of_wrench,
            self._sight_of_platform,
        ):
            sight.forget()

    def unseen(self, now: float) -> str:
        """What is missing at a steady time [s], in words; empty if nothing is."""
        missing = (
            self.missing_motors(now),
            self._lagging_motors(now),
            self._missing_platform(now),
            self.missing_wrench(now),
        )
        return next(filter(None, missing), "")

    def missing_motors(self, now: float) -> str:
        """Why motors that were measured are no more; empty without, and of those that are tracked."""
        if self._motors is None:
            return ""
        return self._sight_of_motors.missing(self._motors.missing(now, with_age=False), now)

    def motors_again(self, now: float) -> bool:
        """Whether motors are measured at this moment, also where they were not just before."""
        return self._motors is not None and not self._motors.missing(now)

    def missing_wrench(self, now: float) -> str:
        """Why what pushes on the platform is not known any more; empty otherwise."""
        return self._sight_of_wrench.missing(self._wrench.missing, now)

    def _lagging_motors(self, now: float) -> str:
        """That motors do not keep up with their commands; empty if they do, or nobody measures."""
        if self._motors is None:
            return ""
        return self._sight_of_lag.missing(self._lag(), now)

    def _missing_platform(self, now: float) -> str:
        loop = self._loop(now)
        if loop.loop == Loop.OPEN:
            self._sight_of_platform.forget()
        return self._sight_of_platform.missing(loop.text if loop.blind else "", now)
