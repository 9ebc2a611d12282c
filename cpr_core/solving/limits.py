# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of motors and rods at an equilibrium."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.doubted_requests import request_doubt
from ..kernels.limit_kernel import ROUNDING, grazed, steps_within_limits
from ..model.bending_strain import bending_strains, strain_reserves, strains_in
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from .events import PathEvent
from .not_reached import MotorLimitExceeded, NotReached, StrainLimitExceeded

__all__ = [
    "Limit",
    "beyond_limits",
    "check_limits",
    "first_of",
    "grazes",
    "limit_error",
    "limits_along",
    "limits_of",
    "margins",
    "may_be_kept_again",
    "undisturbed",
    "violated",
    "with_strain_margins",
]

Floats = NDArray[np.float64]
LimitKind = Literal["motor_limit", "effort_limit", "strain_limit"]

_NONE = np.zeros(0)


class Limit(NamedTuple):
    """A limit a robot has, at one end: who is beyond one has still the other one to keep.

    Attributes:
        kind: Which one.
        number: Motor or rod, from 0.
        end: At which end of a range; of strains there is only the upper one.
    """

    kind: LimitKind
    number: int
    end: Literal["lower", "upper"]


def limits_of(robot: Robot) -> tuple[Limit, ...]:
    """All limits of a robot, in the order of ``margins``."""
    limits, rods = robot.motor_limits, np.flatnonzero(np.isfinite(robot.yield_strains))
    found = list[Limit]()
    for motor, of_effort, upper in zip(
        limits.motors.tolist(), limits.of_effort, limits.upper, strict=True
    ):
        kind: LimitKind = "effort_limit" if of_effort else "motor_limit"
        found.append(Limit(kind, motor, "upper" if upper else "lower"))
    return (*found, *(Limit("strain_limit", number, "upper") for number in rods.tolist()))


def may_be_kept_again(robot: Robot, problem: str) -> bool:
    """Whether a robot has limits that may be passed and kept again on a straight way.

    Ranges of motors that are imposed are no such: they move evenly.
    """
    if problem == "motors":
        return robot.limited and (robot.limits_strain or robot.limits_effort)
    return robot.limited


def limits_along(robot: Robot, records: Floats) -> Floats:
    """How far limits are at equilibria of a robot, whose records are (..., .): ``margins``, (..., K)."""
    of_motors = robot.motor_limits.left_of(records.take(robot.limited_numbers, axis=-1))
    if not robot.limits_strain:
        return of_motors
    return with_strain_margins(
        robot, of_motors, strains_in(robot, records[..., : robot.state_size])
    )


def margins(equilibrium: Equilibrium) -> Floats:
    """How far every limit is, negative where it does not hold, in the order of ``limits_of``, (K,).

    Positions count in natural units, efforts and strains relative to their limits.
    """
    robot = equilibrium.robot
    return limits_along(robot, equilibrium.record) if robot.limited else _NONE


def with_strain_margins(robot: Robot, of_motors: Floats, strains: Floats) -> Floats:
    """Margins of motors, and of the rods that have a limit of strain, (..., K).

    Args:
        robot: The robot.
        of_motors: Of the limits of motors, ``MotorLimitArrays.left``.
        strains: Largest bending strain of every rod, (..., R).
    """
    return np.concatenate([of_motors, strain_reserves(robot, strains)], axis=-1)


def grazes(before: Floats, after: Floats) -> bool:
    """Whether a limit may be passed, and be kept again, between two sets of margins, (K,)."""
    return grazed(np.ascontiguousarray(before), np.ascontiguousarray(after))


def undisturbed(along: Floats) -> int:
    """After how many steps a limit does not hold, or was grazed: of margins along a way, (T + 1, K)."""
    return steps_within_limits(np.ascontiguousarray(along))


def violated(robot: Robot, margin: Floats) -> frozenset[Limit]:
    """The limits that do not hold."""
    if not margin.size or margin.min() >= -ROUNDING:
        return frozenset()
    limits = limits_of(robot)
    return frozenset(limits[number] for number in np.flatnonzero(margin < -ROUNDING))


def first_of(limits: frozenset[Limit]) -> Limit | None:
    """That of the first motor or rod; None: there are none."""
    return min(limits, key=lambda limit: (limit.number, limit.kind), default=None)


def limit_error(
    equilibrium: Equilibrium,
    limit: Limit,
    fraction: float = 1.0,
    event: PathEvent | None = None,
    requested: Floats | None = None,
) -> NotReached:
    """The error of a limit that does not hold at an equilibrium.

    Args:
        equilibrium: Where it does not hold.
        limit: Which one.
        fraction: Fraction of the way where it ceases to hold.
        event: The same as an event of a path.
        requested: Motor positions that were asked for, if they were.
    """
    robot, last, number = (
        equilibrium.robot,
        event.equilibrium if event else equilibrium,
        limit.number,
    )
    if limit.kind == "strain_limit":
        strain, borne = bending_strains(equilibrium)[number], robot.yield_strains[number]
        name = robot.rod_names[number]
        return StrainLimitExceeded(name, float(strain), float(borne), fraction, last, event)
    motor = robot.description.motors[number]
    quantity, unit, doubt = "effort", motor.effort_unit, ""
    value, interval = equilibrium.efforts[number], (-motor.limits.effort, motor.limits.effort)
    if limit.kind == "motor_limit":
        quantity, unit = "position", motor.unit
        value = (equilibrium.motors if requested is None else requested)[number]
        interval = motor.limits.lower, motor.limits.upper
        doubt = request_doubt(robot.description, requested, None)
    return MotorLimitExceeded(
        motor=motor.name,
        quantity=quantity,
        value=float(value),
        limits=interval,
        unit=unit,
        fraction=fraction,
        last=last,
        event=event,
        doubt=doubt,
    )


def beyond_limits(equilibrium: Equilibrium) -> NotReached | None:
    """The error of the first limit that does not hold at an equilibrium; None: all hold."""
    limit = first_of(violated(equilibrium.robot, margins(equilibrium)))
    return None if limit is None else limit_error(equilibrium, limit)


def check_limits(equilibrium: Equilibrium) -> None:
    """Whether the motors can be at an equilibrium and hold it, and the rods bear it.

    Raises:
        MotorLimitExceeded: A motor beyond its position range or its effort.
        StrainLimitExceeded: A rod beyond its yield strain.
    """
    error = beyond_limits(equilibrium)
    if error is not None:
        raise error
