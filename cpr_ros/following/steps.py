# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One step of the robot: solving it, and comparing its two ends."""

from __future__ import annotations

import time
from dataclasses import dataclass
from operator import sub, truediv

from cpr_core import (
    CprError,
    Equilibrium,
    Loads,
    MotorLimitExceeded,
    NotReached,
    Robot,
    StrainLimitExceeded,
    TimeLimitExceeded,
)
from cpr_core.errors import distinct
from cpr_core.model.assessment import Assessment
from cpr_core.model.configurations import leg_units
from cpr_core.model.robot import kept_with_robot

from .goals import Goal
from .supervision import Refusal

__all__ = ["LONGEST_SOLVE", "Undecided", "attempt", "change_between", "falls"]

#: Longest time that a solution of a tick may take [s]: meanwhile the node hears nothing.
LONGEST_SOLVE = 0.1
#: If the thread had the processor for less than this part of that time, others took it, and the
#: solution is tried once more.
_WORKED = 0.5


@dataclass(frozen=True)
class Undecided(Refusal):
    """Nothing was found in time, or the solver failed: asked once more it may be found.

    Attributes:
        reached: How far the branch was followed; None: not at all.
        fraction: Part of the way that it was followed.
    """

    reached: Assessment | None = None
    fraction: float = 0.0


def attempt(
    current: Assessment,
    goal: Goal,
    fraction: float,
    loads: Loads,
    time_limit: float = LONGEST_SOLVE,
) -> Assessment | Refusal:
    """Solve at a fraction of the way to a goal; cannot raise: a robot that cannot go on stays."""
    begin = time.perf_counter()
    try:
        equilibrium = _solved(current, goal, fraction, loads, time_limit)
    except MotorLimitExceeded as error:
        reason = "motor_range" if error.quantity == "position" else "effort_reserve"
        value, lower, upper = distinct(error.value, *error.limits)
        return Refusal(
            reason, f"{error.motor}: {error.quantity} {value} would be outside [{lower}, {upper}]"
        )
    except StrainLimitExceeded as error:
        value, limit = distinct(error.value, error.limit)
        return Refusal(
            "strain_reserve", f"{error.rod}: bending strain {value} would be above {limit}"
        )
    except TimeLimitExceeded as error:
        last, length = error.last, current.characteristic_length
        reached = Assessment(last, length) if last is not None and error.fraction > 0.0 else None
        text = f"no equilibrium is found within {time_limit:g} s"
        return Undecided("not_converged", text, reached, error.fraction)
    except NotReached as error:
        # How far a request goes and what it may have meant are of no use a step ahead.
        why = error.event.message if error.event is not None else str(error)
        return Refusal("not_converged", f"no equilibrium is reached: {why}")
    except CprError as error:
        return Refusal("not_converged", str(error))
    except Exception as error:
        return Undecided("not_converged", f"the solver failed: {type(error).__name__}: {error}")
    return Assessment(
        equilibrium, current.characteristic_length, solve_time=time.perf_counter() - begin
    )


def _solved(
    current: Assessment, goal: Goal, fraction: float, loads: Loads, time_limit: float
) -> Equilibrium:
    """The same as a value or an error; tried once more where others had the processor all the time.

    Else a motion would be given up where a busy computer holds the node up within a solution.
    """
    begin = time.thread_time()
    try:
        return goal.solve(current.equilibrium, fraction, loads, time_limit)
    except TimeLimitExceeded:
        if time.thread_time() - begin >= _WORKED * time_limit:
            raise
    return goal.solve(current.equilibrium, fraction, loads, time_limit)


def falls(first: float, last: float) -> bool:
    """Whether a measure falls by more than rounding."""
    return last < first - 1e-9 * max(1.0, abs(first))


def change_between(first: Equilibrium, last: Equilibrium) -> float:
    """Largest change of a leg coordinate [1/rod length] and of the platform [rod lengths, radians]."""
    robot = first.robot
    # In lists: after a pause numpy takes twice as long.
    change = map(sub, last.configuration.tolist(), first.configuration.tolist())
    return max(map(truediv, map(abs, change), _units(robot)))


@kept_with_robot
def _units(robot: Robot) -> list[float]:
    return leg_units(robot).tolist()
