# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers that measurements hardly tell, and numbers that end at a bound or where descriptions do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..description.changed_description import schema_allows
from ..errors import DescriptionError
from ..model.robot import Robot
from ..solving.not_reached import NotReached
from .parameter_problem import ParameterProblem
from .tried_robot import tried_robot

__all__ = [
    "HALF_95_PERCENT",
    "border_doubts",
    "bound_doubts",
    "hardly_told",
    "many_times_larger",
    "strayed",
]

Floats = NDArray[np.float64]

#: Half the width of an interval that holds the truth 95 times of 100, in standard deviations.
HALF_95_PERCENT = 1.959963984540054
#: How near to what descriptions refuse is next to it, by the number.
_NEXT = 1e-2
#: How near to a bound, in standard deviations, is at it.
_AT_BOUND = 1e-2
#: How many times larger a number is tried, where its standard deviation is more than this part of it.
_MANY, _ROUGH = 5.0, 1e-2
#: Part of a parameter that is in no direction but unseen ones, where nothing at all tells it.
_UNTOLD = 1.0 - 1e-6


def hardly_told(
    robot: Robot,
    paths: Sequence[str],
    values: Floats,
    deviations: Floats,
    scales: Floats,
    sizes: Floats | None = None,
) -> tuple[str, ...]:
    """Numbers whose interval of 95 % is wider than there is room for, one line each.

    A number that has to be positive, such as a modulus, is not told where the interval reaches zero:
    what is measured follows its inverse, say, and one many times larger fits nearly as well. One that
    may vanish, such as a mass, is told where the interval is narrow by what was expected; one that may
    have any sign, such as an offset, where it is narrower than a natural unit too.

    Args:
        robot: Whose numbers they are.
        paths: Of the numbers, P.
        values: Of the numbers, (P,).
        deviations: Their standard deviations, (P,); infinite ones are of values that stayed.
        scales: Their natural units, (P,).
        sizes: How large numbers that may vanish were expected to be, (P,); default as they are.
    """
    found = []
    expected = np.abs(values) if sizes is None else np.maximum(np.abs(values), sizes)
    each = zip(paths, *map(np.ndarray.tolist, (values, deviations, expected, scales)), strict=True)
    for path, value, deviation, size, unit in each:
        half = HALF_95_PERCENT * deviation
        if not np.isfinite(deviation) or half <= abs(value):
            continue
        kind, enough = "has to be positive", 0.0
        if schema_allows(robot.description, path, -1.0):
            kind, enough = "may have any sign", max(size, unit)
        elif schema_allows(robot.description, path, 0.0):
            kind, enough = "cannot be negative", size
        if half > enough:
            found.append(
                f"{path} is hardly told: its standard deviation is {deviation:.3g}, of a number that "
                f"{kind} and is {value:.3g}"
            )
    return tuple(found)


def border_doubts(
    robot: Robot, paths: Sequence[str], values: Floats, deviations: Floats, start: Floats
) -> tuple[str, ...]:
    """Numbers that ended next to what the description refuses, one line each.

    Args:
        robot: With the numbers that were found.
        paths: Of the numbers, P.
        values: Of the numbers, (P,).
        deviations: Their standard deviations, (P,); infinite ones are of values that stayed.
        start: What was described, (P,).
    """
    found = []
    steps = np.minimum(_NEXT * np.maximum(np.abs(values), np.abs(start)), deviations)
    each = zip(paths, values.tolist(), steps.tolist(), deviations.tolist(), strict=True)
    for path, value, step, deviation in each:
        if not np.isfinite(deviation) or not step > 0.0:
            continue
        refused = _refused(robot, path, value - step) or _refused(robot, path, value + step)
        if refused:
            found.append(
                f"{path} ends next to what no robot has ({refused}): the measurements may fit better "
                "beyond it, or hardly tell it"
            )
    return tuple(found)


def bound_doubts(
    paths: Sequence[str], values: Floats, deviations: Floats, bounds: Floats
) -> tuple[str, ...]:
    """Parameters that ended at a bound, one line each.

    Args:
        paths: Of the parameters, P.
        values: What was found, (P,).
        deviations: Their standard deviations, (P,); infinite ones are of values that stayed.
        bounds: Lowest and highest values, (2, P).
    """
    moved = np.where(np.isfinite(deviations), deviations, 0.0)
    near = np.abs(values - bounds) <= _AT_BOUND * moved
    return tuple(
        f"{paths[column]} ends at its bound {bounds[side, column]:g}: the measurements fit better "
        "beyond it, and standard deviations are those without bounds"
        for side, column in np.argwhere(near & np.isfinite(bounds))
    )


def many_times_larger(
    problem: ParameterProblem, change: Floats, deviations: Floats, limits: Floats
) -> tuple[str, ...]:
    """Numbers that have to be positive and, many times larger, fit within 95 %, one line each.

    Where something gives way below a value (a rod sags, or buckles) and measurements say only that it
    has not, squares are steep on that side alone: a standard deviation is small, and half of the truth.

    Args:
        problem: What is compared.
        change: The answer, in natural units, (P,).
        deviations: Standard deviations of the values, (P,).
        limits: Bounds of the values, (2, P).
    """
    found, robot = [], problem.robot
    values = problem.values_at(change)
    least = sum(problem.squares(change))
    for place, path in enumerate(problem.paths):
        value, deviation, larger = values[place], deviations[place], _MANY * values[place]
        if not _ROUGH * value < deviation <= value / HALF_95_PERCENT or larger > limits[1, place]:
            continue
        if schema_allows(robot.description, path, -1.0) or schema_allows(
            robot.description, path, 0.0
        ):
            continue
        if _squares_with(problem, change, place, larger, limits) - least < HALF_95_PERCENT**2:
            found.append(
                f"{path} is hardly told: it is {value:.3g} with a standard deviation of "
                f"{deviation:.3g}, but one {_MANY:.0f} times as large fits nearly as well"
            )
    return tuple(found)


def strayed(problem: ParameterProblem, change: Floats, unseen: Floats) -> tuple[str, ...]:
    """Numbers that nothing tells where they ended, which is not where they began, one line each.

    What is not told stays; but a number may go, with little to gain, to where it is told no more.

    Args:
        problem: What is compared.
        change: The answer, in natural units, (P,).
        unseen: Directions in which nothing that is compared changes there, orthonormal rows (K, P).
    """
    values = problem.values_at(change)
    untold = np.sum(unseen**2, axis=0) > _UNTOLD
    far = np.abs(values - problem.values) > _NEXT * np.maximum(
        np.abs(values), np.abs(problem.values)
    )
    return tuple(
        f"{problem.paths[place]} is not determined at {values[place]:.3g}, where it went from "
        f"{problem.values[place]:.3g}: the measurements tell at most what it is not"
        for place in np.flatnonzero(untold & far)
    )


def _squares_with(
    problem: ParameterProblem, change: Floats, place: int, value: float, limits: Floats
) -> float:
    """The same with another value of one number, the others after it; infinite: no such robot."""
    tried = change.copy()
    tried[place] = (value - problem.values[place]) / problem.scales[place]
    others = np.arange(len(change)) != place
    try:
        pairs = zip(problem.rows, problem.equilibria(tried), strict=True)
        residual = np.concatenate([row.residual(equilibrium) for row, equilibrium in pairs])
        step = np.linalg.lstsq(problem.rates(tried)[:, others], -residual, rcond=None)[0]
        bounds = (limits - problem.values) / problem.scales
        tried[others] = np.clip(tried[others] + step, *bounds[:, others])
        return sum(problem.squares(tried))
    except (DescriptionError, NotReached):
        return np.inf


def _refused(robot: Robot, path: str, value: float) -> str:
    """Why there is no robot with another number; empty: there is one."""
    try:
        tried_robot(robot, {path: value})
    except DescriptionError as error:
        return f"{error.field}: {error.problem}"
    return ""
