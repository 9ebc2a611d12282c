# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Critical loads: how much more a robot can carry before it loses stability."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..description.loads import Loads
from ..errors import InvalidRequest, distinct
from ..kernels.twist_layout import FIRST_LINEAR, LINEAR
from ..model.equilibrium import Equilibrium, check_equilibrium, spectrum
from ..model.stability import MotorReading
from ..validation import checked_number, checked_vector
from .events import PathEvent
from .geometrico_statics import solve_forward
from .not_reached import MotorLimitExceeded, NoForwardSolution, NoSolution, StrainLimitExceeded

__all__ = ["CriticalLoad", "critical_load", "critical_load_factor"]

#: Accuracy of the critical factor or force, relative.
_TOLERANCE = 1e-8
#: Steps of the load that are smaller than this part of the first one are not tried.
_SMALLEST_STEP = 1e-3
#: Where stability ends the smallest eigenvalue is less than this part of what it was, or the margin less
#: than this, where it was as small at the start.
_FALLEN, _NO_MARGIN = 0.1, 1e-2


@dataclass(frozen=True, eq=False)
class CriticalLoad:
    """Where the first eigenvalue of H_r reaches zero.

    Attributes:
        value: Critical factor, or force [N].
        equilibrium: Last stable equilibrium before it.
        kind: ``crossing``: the eigenvalue goes through zero, several branches may cross (a bifurcation),
            whether this one goes on, unstable, or not; ``fold``: the branch turns back there.
    """

    value: float
    equilibrium: Equilibrium
    kind: str


def critical_load_factor(
    equilibrium: Equilibrium, *, motors_are: MotorReading = "locked", limit: float = 1e3
) -> CriticalLoad | None:
    """Factor on all loads at which stability is lost, the motors held where they are.

    Args:
        equilibrium: Stable equilibrium under the loads with factor one.
        motors_are: Reading of the motors in the stability test.
        limit: Largest factor tried.

    Returns:
        The critical load, to a relative accuracy of 1e-8, or what rounding of the smallest eigenvalue
        leaves of it; None if there is none up to the limit.

    Raises:
        InvalidRequest: The start is unstable or its loads have no potential.
        MotorLimitExceeded: Before that, a motor would give more than its effort; ``fraction`` is that of
            the way to the limit.
        StrainLimitExceeded: Before that, a rod would yield; the same holds.
        NoForwardSolution: The walk was lost where the robot is still stable.
    """
    check_equilibrium(equilibrium)
    raised = _Raised(
        loads=equilibrium.loads.scaled,
        begin=1.0,
        step=0.1,
        in_words="at a factor of {:.6g} on the loads".format,
    )
    return _critical(equilibrium, raised, limit, motors_are)


def critical_load(
    equilibrium: Equilibrium,
    direction: ArrayLike,
    *,
    motors_are: MotorReading = "locked",
    limit: float | None = None,
) -> CriticalLoad | None:
    """Additional force on the platform at which stability is lost, the motors held.

    Args:
        equilibrium: Stable equilibrium without the additional force.
        direction: Of the force, in the world, (3,).
        motors_are: Reading of the motors in the stability test.
        limit: Largest force tried [N]; default a thousand times E J / l^2.

    Returns:
        The critical force, to a relative accuracy of 1e-8, or what rounding of the smallest eigenvalue
        leaves of it; None if there is none up to the limit.

    Raises:
        InvalidRequest: The start is unstable, its loads have no potential, or no direction is given.
        MotorLimitExceeded: Before that, a motor would give more than its effort; ``fraction`` is that of
            the way to the limit.
        StrainLimitExceeded: Before that, a rod would yield; the same holds.
        NoForwardSolution: The walk was lost where the robot is still stable.
    """
    check_equilibrium(equilibrium)
    axis = checked_vector("direction", direction, 3, "x y z in the world")
    size = np.abs(axis).max()
    if size < 1e-12:
        raise InvalidRequest("direction", f"expected a direction, got {axis.tolist()}")
    axis = axis / size  # the squares of large numbers are infinite
    if equilibrium.robot.planar:
        if abs(axis[2]) > 1e-12:
            problem = f"expected z = 0 of a planar robot, got {axis.tolist()}"
            raise InvalidRequest("direction", problem)
        axis[2] = 0.0
    axis /= np.linalg.norm(axis)
    natural = float(equilibrium.robot.wrench_units[FIRST_LINEAR])
    start = equilibrium.loads

    def loads(force: float) -> Loads:
        wrench = start.wrench_world.copy()
        wrench[LINEAR] += force * axis
        return start.with_(wrench_world=wrench)

    raised = _Raised(
        loads=loads, begin=0.0, step=0.1 * natural, in_words="at a force of {:.6g} N".format
    )
    largest = 1e3 * natural if limit is None else limit
    return _critical(equilibrium, raised, largest, motors_are)


@dataclass(frozen=True)
class _Raised:
    """A load that is raised.

    Attributes:
        loads: All loads at a value of it.
        begin: Its value at the start.
        step: First step of the value.
        in_words: Where a value is.
    """

    loads: Callable[[float], Loads]
    begin: float
    step: float
    in_words: Callable[[float], str]


def _critical(
    start: Equilibrium, raised: _Raised, limit: float, motors_are: MotorReading
) -> CriticalLoad | None:
    """Raise the load until the smallest eigenvalue is negative or the branch ends, then bisect.

    Limits that are passed on the way are told with a fraction of all of it, and in words.
    """
    robot, limit, value = start.robot, checked_number("limit", limit), raised.begin
    if not limit > value:
        least, given = distinct(value, limit, fewest=6)
        raise InvalidRequest("limit", f"expected more than {least}, got {given}")
    if not robot.has_potential(start.loads):
        raise InvalidRequest(
            "loads", "expected loads with a potential: energy decides nothing here"
        )
    smallest = spectrum(start, motors_are).smallest
    if smallest <= 0.0:
        raise InvalidRequest(
            "equilibrium", f"expected a stable one, its smallest eigenvalue is {smallest:.3g} J"
        )
    low, last, beyond, end, high, step = value, start, "", "", np.inf, raised.step
    while high - low > _TOLERANCE * max(abs(low), step * 1e-3):
        target = min(low + step, limit) if np.isinf(high) else 0.5 * (low + high)
        try:
            next_equilibrium = solve_forward(
                robot, start.motors, start=last, loads=raised.loads(target)
            )
            eigenvalue = spectrum(next_equilibrium, motors_are).smallest
        except (MotorLimitExceeded, StrainLimitExceeded) as error:
            # A walk goes on where stability is lost: that may have been before the limit.
            if error.last is None or spectrum(error.last, motors_are).smallest > 0.0:
                reached = low + error.fraction * (target - low)
                part = (reached - value) / (limit - value)
                raise error.on_longer_way(part, raised.in_words(reached)) from None
            high, beyond = target, "crossing"
            continue
        except NoSolution as error:
            if np.isinf(high) and _not_walked(error) and step > _SMALLEST_STEP * raised.step:
                step *= 0.5
            else:
                # As it was told first, from afar: next to a fold it looks like a crossing.
                crosses = error.event is not None and error.event.kind == "bifurcation"
                end = end or ("crossing" if crosses else "fold")
                high, beyond = target, end
            continue
        if eigenvalue <= 0.0:
            high, beyond = target, "crossing"
            continue
        if np.isinf(high):
            if target >= limit:
                return None
            # Slowly where the eigenvalue falls fast, so that no unstable stretch is passed over.
            step *= (
                2.0 if eigenvalue > 0.8 * smallest else 0.7 if eigenvalue < 0.5 * smallest else 1.0
            )
        low, last, smallest = target, next_equilibrium, eigenvalue
    if end:
        _check_end(start, last, motors_are, (low - value) / (limit - value), raised.in_words(low))
    return CriticalLoad(value=0.5 * (low + high), equilibrium=last, kind=beyond)


def _check_end(
    start: Equilibrium, last: Equilibrium, motors_are: MotorReading, fraction: float, place: str
) -> None:
    """Whether it is stability that ends where no walk goes on.

    Raises:
        NoForwardSolution: It does not: a robot far from the origin of its world, whose rounding is too
            much for every step, was told to fold.
    """
    before, found = (spectrum(each, motors_are) for each in (start, last))
    if found.smallest < _FALLEN * before.smallest or abs(found.firm_margin) < _NO_MARGIN:
        return
    text = (
        f"the walk was lost {place}, where stability does not end: the smallest eigenvalue is "
        f"{found.smallest:.3g} J, at the start it is {before.smallest:.3g} J"
    )
    index = last.index_locked
    event = PathEvent("lost", fraction, last, index, index, text)
    raise NoForwardSolution(text, fraction, last, event)


def _not_walked(error: NoSolution) -> bool:
    """Whether a load was too much for one walk, which says nothing about the branch."""
    return error.fraction == 0.0 and error.event is not None and error.event.kind == "lost"
