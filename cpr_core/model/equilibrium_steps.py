# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one equilibrium to another in a step of Newton's method or two, limits not looked at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.continuation_kernel import UNPREDICTED, WATCHED
from ..kernels.kept_factors import kept_factors
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.prepared_robot import continue_prepared
from ..kernels.problems import PROBLEMS
from ..kernels.record_layout import STEPS
from ..kernels.square_problem import (
    CONTRACTION,
    ITERATIONS,
    RESIDUAL_TOLERANCE,
    Configuration,
    Tolerances,
)
from .equilibrium import Equilibrium
from .equilibrium_records import AS_IT_IS, corrected_record, new_record, record_of
from .robot import Robot

__all__ = ["corrected", "equilibrium_at", "evaluated_again", "stepped", "stepped_twice"]

Floats = NDArray[np.float64]


def stepped(
    start: Equilibrium,
    robot: Robot,
    loads: Loads,
    load_arrays: LoadArrays,
    problem: str,
    given: Floats,
    mode: int,
    residual: float = RESIDUAL_TOLERANCE,
) -> Equilibrium | None:
    """The equilibrium one step from another one, limits not looked at; None where there is none.

    Args:
        start: Where the step begins.
        robot: The robot at its end: that of the start, or a relative with as many numbers.
        loads: Loads at its end.
        load_arrays: The same as the kernels see them.
        problem: ``motors``, ``pose`` or ``efforts``: what is imposed.
        given: What is imposed, one row, as ``continue_equilibria`` takes it.
        mode: Of ``continue_equilibria``; other robots and loads than at the start: UNPREDICTED.
        residual: Largest dimensionless residual.
    """
    records, factors = new_record(robot, 1), kept_factors(robot.kernel_arrays)
    if not continue_prepared(
        robot.prepared,
        load_arrays,
        PROBLEMS[problem],
        given,
        mode,
        residual,
        ITERATIONS,
        CONTRACTION,
        start.record,
        factors if mode == UNPREDICTED else start.factors,
        records,
        factors,
    ):
        return None
    return Equilibrium(robot, loads, load_arrays, records[0], factors)


def stepped_twice(
    start: Equilibrium, problem: str, given: Floats
) -> tuple[Equilibrium, Equilibrium] | None:
    """Two near equilibria, one behind the other, on a way on which no sign changes; None: none such.

    As two times `stepped`, but in one call: the second step knows what the tangent missed in the first
    one. The second one's iterations are those of both.

    Args:
        start: Where the first step begins; its loads hold on.
        problem: See `stepped`.
        given: What is imposed, two rows.
    """
    robot, loads, load_arrays = start.robot, start.loads, start.load_arrays
    records, factors = new_record(robot, 2), kept_factors(robot.kernel_arrays, 2)
    tolerances = RESIDUAL_TOLERANCE, ITERATIONS, CONTRACTION
    imposed = load_arrays, PROBLEMS[problem], given, WATCHED
    known = start.record, start.factors
    if continue_prepared(robot.prepared, *imposed, *tolerances, *known, records, factors) < 2:
        return None
    first, second = records
    second[robot.state_size + STEPS] += first[robot.state_size + STEPS]
    count = robot.kernel_arrays.kept_count
    return (
        Equilibrium(robot, loads, load_arrays, first, factors[:count]),
        Equilibrium(robot, loads, load_arrays, second, factors[count:]),
    )


def corrected(
    robot: Robot,
    loads: Loads,
    load_arrays: LoadArrays,
    record: Floats,
    tolerances: Tolerances,
) -> Equilibrium:
    """Newton's method from a rough record at its motors.

    Returns:
        The result, within the tolerance or not: the caller has to look.
    """
    return Equilibrium(
        robot, loads, load_arrays, *corrected_record(robot, load_arrays, record, tolerances)
    )


def evaluated_again(equilibrium: Equilibrium) -> Equilibrium:
    """The same; its condensed tangent, with slots that were delayed, is in the workspace afterwards."""
    return corrected(
        equilibrium.robot,
        equilibrium.loads,
        equilibrium.load_arrays,
        equilibrium.record,
        AS_IT_IS,
    )


def equilibrium_at(
    robot: Robot, loads: Loads, load_arrays: LoadArrays, place: Configuration, iterations: int = 0
) -> Equilibrium:
    """A configuration as an equilibrium, which it is taken for as it is.

    Args:
        robot: The robot.
        loads: Loads in force.
        load_arrays: The same as the kernels see them.
        place: The configuration.
        iterations: How many Newton steps have led there.
    """
    solution = corrected(robot, loads, load_arrays, record_of(robot, place), AS_IT_IS)
    return solution if solution.iterations == iterations else solution.with_iterations(iterations)
