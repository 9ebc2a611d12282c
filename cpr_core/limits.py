"""Limits of motors and rods at an equilibrium."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .equilibrium import Equilibrium
from .errors import MotorLimitExceeded, NotReached, StrainLimitExceeded
from .events import PathEvent
from .strain_limits import bending_strains

__all__ = ["Violation", "check_limits", "limit_error", "violations"]

Floats = NDArray[np.float64]

#: Overshoot that is rounding, relative.
_ROUNDING = 1e-12


class Violation(NamedTuple):
    """A limit that does not hold.

    Attributes:
        kind: Which one.
        number: Motor or leg, from 0.
    """

    kind: Literal["motor_limit", "effort_limit", "strain_limit"]
    number: int


def violations(equilibrium: Equilibrium) -> frozenset[Violation]:
    """Limits of motors (position, effort) and rods (bending strain) that do not hold."""
    robot, found = equilibrium.robot, set()
    for motor, leg in robot.limited_motors:
        position, limits = equilibrium.motors[motor], leg.limits
        slack = _ROUNDING * max(1.0, abs(position))
        if not limits.lower - slack <= position <= limits.upper + slack:
            found.add(Violation("motor_limit", motor))
        if not abs(equilibrium.efforts[motor]) <= limits.effort * (1.0 + _ROUNDING):
            found.add(Violation("effort_limit", motor))
    if robot.limits_strain:
        beyond = bending_strains(equilibrium) > robot.strain_limits * (1.0 + _ROUNDING)
        found |= {Violation("strain_limit", int(leg)) for leg in np.flatnonzero(beyond)}
    return frozenset(found)


def limit_error(
    equilibrium: Equilibrium,
    violation: Violation,
    fraction: float = 1.0,
    event: PathEvent | None = None,
    requested: Floats | None = None,
) -> NotReached:
    """The error of a limit that does not hold at an equilibrium.

    Args:
        equilibrium: Where it does not hold.
        violation: Which one.
        fraction: Fraction of the way where it ceases to hold.
        event: The same as an event of a path.
        requested: Motor positions that were asked for, if they were.
    """
    robot, last = equilibrium.robot, event.equilibrium if event else equilibrium
    if violation.kind == "strain_limit":
        leg = robot.description.legs[violation.number]
        value = float(bending_strains(equilibrium)[violation.number])
        return StrainLimitExceeded(leg.name, value, leg.rod.yield_strain, fraction, last, event)
    leg = dict(robot.limited_motors)[violation.number]
    name, unit, limits = str(leg.motor_name), leg.motor.unit, leg.limits
    if violation.kind == "motor_limit":
        motors = equilibrium.motors if requested is None else requested
        value, interval = float(motors[violation.number]), (limits.lower, limits.upper)
        return MotorLimitExceeded(name, "position", value, interval, unit, fraction, last, event)
    value, interval = float(equilibrium.efforts[violation.number]), (-limits.effort, limits.effort)
    unit = "N m" if unit == "rad" else "N"
    return MotorLimitExceeded(name, "effort", value, interval, unit, fraction, last, event)


def check_limits(equilibrium: Equilibrium) -> None:
    """Whether the motors can be at an equilibrium and hold it, and the rods bear it.

    Raises:
        MotorLimitExceeded: A motor beyond its position range or its effort.
        StrainLimitExceeded: A rod beyond its yield strain.
    """
    found = violations(equilibrium)
    if found:
        raise limit_error(equilibrium, min(found, key=lambda one: (one.number, one.kind)))
