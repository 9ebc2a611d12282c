# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Errors of requests that were not reached: how far the way was gone, and what stopped it."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Self

from ..errors import CprError, distinct
from ..model.equilibrium import Equilibrium
from .events import PathEvent

__all__ = [
    "MotorLimitExceeded",
    "NoForwardSolution",
    "NoInverseSolution",
    "NoSolution",
    "NotReached",
    "StrainLimitExceeded",
    "TimeLimitExceeded",
    "UnstableEquilibrium",
    "refusal_of",
]


class NotReached(CprError):
    """A request was not reached along the branch of the start.

    Attributes:
        fraction: Fraction of the way, in [0, 1], that was gone.
        last: Last good equilibrium on the way (the start itself with fraction 0); None where there
            was no start.
        event: What stopped the way; None where it was not followed at all.
    """

    def __init__(
        self,
        message: str,
        fraction: float,
        last: Equilibrium | None,
        event: PathEvent | None = None,
    ) -> None:
        """Keep how far the solver came, and why not farther."""
        self.fraction, self.last, self.event = fraction, last, event
        super().__init__(message)


class NoSolution(NotReached):
    """The branch of the start does not reach the request: it folds back, or it was lost."""

    code = "NOT_CONVERGED"


class NoForwardSolution(NoSolution):
    """The requested motors, efforts or loads were not reached."""


class NoInverseSolution(NoSolution):
    """The requested platform coordinates were not reached."""

    code = "NO_IK_SOLUTION"


class UnstableEquilibrium(NotReached):
    """Only stable equilibria were asked for, and stability ends before the request."""

    code = "UNSTABLE_EQUILIBRIUM"


class TimeLimitExceeded(NotReached):
    """The time allowed was over before the request was reached."""

    code = "TIMED_OUT"


class _LimitPassed(NotReached):
    """A limit is passed on the way."""

    def __init__(
        self,
        exceeded: str,
        fraction: float,
        last: Equilibrium | None,
        event: PathEvent | None,
        doubt: str = "",
    ) -> None:
        """Name the limit, where it is passed, and what looks wrong."""
        self._exceeded, self._doubt = exceeded, doubt
        place = f"after {100.0 * fraction:.2f} % of the way" if fraction < 1.0 else ""
        super().__init__(self._words(place), fraction, last, event)

    def _words(self, place: str) -> str:
        passed = f", it is passed {place}" if place else ""
        return f"{self._exceeded}{passed}" + (f"; {self._doubt}" if self._doubt else "")

    def on_longer_way(self, fraction: float, place: str) -> Self:
        """One of a way of which that of this error was a part: how far on it, and where in words."""
        found = copy(self)
        found.__notes__ = [*getattr(self, "__notes__", ())]  # else both have the same list
        found.fraction, found.args = fraction, (self._words(place),)
        if self.event is not None:
            found.event = replace(self.event, fraction=fraction)
        return found


class MotorLimitExceeded(_LimitPassed):
    """A motor would have to leave its position range or give more than its effort.

    Attributes:
        motor: Name of the motor.
        quantity: ``position`` or ``effort``.
        value: What it would have to be.
        limits: Lower and upper limit.
    """

    code = "MOTOR_LIMIT"

    def __init__(
        self,
        motor: str,
        quantity: str,
        value: float,
        limits: tuple[float, float],
        unit: str,
        fraction: float = 1.0,
        last: Equilibrium | None = None,
        event: PathEvent | None = None,
        doubt: str = "",
    ) -> None:
        """Name the motor, the value and the limits, and what looks wrong with the value.

        It takes what all errors of its kind take, and what it has by itself.
        """
        self.motor, self.quantity, self.value, self.limits = motor, quantity, value, limits
        told, lower, upper = distinct(value, *limits, fewest=6)
        exceeded = f"{motor}: {quantity} {told} {unit} is outside its limits [{lower}, {upper}]"
        super().__init__(exceeded, fraction, last, event, doubt)


class StrainLimitExceeded(_LimitPassed):
    """A rod would yield.

    Attributes:
        rod: Name of the rod: that of its leg, numbered where it has several.
        value: Largest bending strain of the rod.
        limit: Its yield strain.
    """

    code = "STRAIN_LIMIT"

    def __init__(
        self,
        rod: str,
        value: float,
        limit: float,
        fraction: float = 1.0,
        last: Equilibrium | None = None,
        event: PathEvent | None = None,
    ) -> None:
        """Name the rod, its strain and the limit."""
        self.rod, self.value, self.limit = rod, value, limit
        told, most = distinct(value, limit, fewest=6)
        exceeded = f"{rod}: bending strain {told} is above its yield strain {most}"
        super().__init__(exceeded, fraction, last, event)


def refusal_of(
    event: PathEvent, message: str, last: Equilibrium, problem: str, stable_only: bool
) -> NotReached:
    """The error of a way that an event stopped; that of limits is ``limit_error``.

    Args:
        event: What stopped it.
        message: How far it was gone, and why not farther.
        last: Last good equilibrium on it.
        problem: What was imposed: ``motors``, ``pose`` or ``efforts``.
        stable_only: Whether stability must not end on it.
    """
    kind: type[NotReached] = NoInverseSolution if problem == "pose" else NoForwardSolution
    if event.kind == "time_limit":
        kind = TimeLimitExceeded
    elif stable_only and event.kind in ("stability", "bifurcation"):
        kind = UnstableEquilibrium
    return kind(message, event.fraction, last, event)
