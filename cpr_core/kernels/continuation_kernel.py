# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one equilibrium to the next: predicted along the tangent, corrected, with its signs."""

from __future__ import annotations

import math

from .condensation_kernel import DELAYED, UNKNOWN
from .inertia_kernel import signs_of
from .kept_factors import keep, recalled
from .kernel_decorators import inlined, kernel
from .kernel_records import complete, read_pose, rods_exist, square_problem
from .natural_units import EFFORT_UNIT, LONGEST_STEP
from .newton_kernel import CONVERGED, learn_bend, newton, predict_state
from .problems import Problem
from .record_layout import (
    EFFORT,
    IMPOSED_MOTORS,
    INDEX_FREE,
    INDEX_LOCKED,
    INVERSE_SIGN,
    POSITION,
    ROTATION,
    SIGNS,
)
from .square_problem import Configuration, Tolerances

__all__ = ["FREELY", "UNPREDICTED", "WATCHED", "continue_equilibria"]

#: How to go: near requests only, no sign changes; wherever corrections contract; the same without
#: prediction: where the loads are others than at the start the tangent alone does not tell the way.
WATCHED, FREELY, UNPREDICTED = 0, 1, 2


@kernel
def continue_equilibria(
    prepared,
    loads,
    problem,
    given,
    mode,
    residual,
    iterations,
    contraction,
    record,
    kept_before,
    records,
    kept,
):
    """From one equilibrium to the next, as long as Newton's method converges.

    Long, as every part that is cut out takes a second more to compile; all numbers by themselves, as
    taking tuples from Python apart takes a microsecond.

    Args:
        prepared: PreparedRobot.
        loads: LoadArrays at the ends of the steps.
        problem: Of Problem.
        given: What is imposed, one row a step: motors or efforts, (P, n), or platform rotation, position
            and motors, (P, 12 + n): those of the equilibrium where they are not imposed; motors that are
            unknown are not read.
        mode: WATCHED, FREELY or UNPREDICTED.
        residual: Of Tolerances.
        iterations: Of Tolerances.
        contraction: Of Tolerances.
        record: The equilibrium to go on from.
        kept_before: Kept factors of the tangent there; not read where UNPREDICTED.
        records: Result, (P, .); behind the last step that was made, where Newton's method ended.
        kept: Result where all steps were made, kept factors of the tangents at the last equilibria, one
            after the other: as many as there is memory for (``kept_factors``).

    Returns:
        Number of steps that were made.
    """
    robot, work, watched = prepared.robot, prepared.work, mode == WATCHED
    tolerances = Tolerances(residual, iterations, contraction)
    size, square = robot.unit.shape[0], square_problem(robot, problem)
    first_kept = given.shape[0] - kept.shape[0] // robot.kept_count
    work.bend_count[0], work.factors.status[0] = 0, UNKNOWN
    factors = work.factors
    if mode != UNPREDICTED:
        factors = recalled(robot, kept_before, work.factors)
    if work.factors.status[0] == DELAYED:  # these are not kept: the tangent is evaluated again
        read_pose(robot, record, work)
        for i in range(size):
            work.simplified[i] = record[i]
        configuration = Configuration(work.simplified, work.rotation, work.position)
        anywhere = Tolerances(math.inf, 0, 1.0)
        status, _, _, _ = newton(
            robot, loads, configuration, square, work.given_efforts, 0.0, anywhere, work
        )
        if status != CONVERGED:
            work.factors.status[0] = UNKNOWN
        factors = work.factors
    for row in range(given.shape[0]):
        before = record if row == 0 else records[row - 1]
        if watched and not _is_near(robot, problem, given[row], before):
            return row
        next_record = records[row]
        state = next_record[:size]
        for i in range(size):
            state[i] = before[i]
        read_pose(robot, before, work)
        _impose(robot, problem, given[row], before, work)
        configuration = Configuration(state, work.rotation, work.position)
        predicted = predict_state(robot, square, configuration, factors, work)
        if not rods_exist(robot, state):
            return row
        status, steps, largest, energy = newton(
            robot, loads, configuration, square, work.given_efforts, predicted, tolerances, work
        )
        if status == CONVERGED:
            learn_bend(robot.platform_index + square.unknowns.shape[0], work)
            signs_of(robot, work.rotation, work, work.signs)
        complete(robot, energy, largest, steps, next_record, work)
        if status != CONVERGED or not rods_exist(robot, state):
            return row
        if watched and not _same_signs(robot, problem, before, next_record):
            return row
        factors = work.factors
        if row >= first_kept:
            keep(robot, work.factors, kept[(row - first_kept) * robot.kept_count :])
    return given.shape[0]


@inlined
def _impose(robot, problem, given, before, work):
    """What is imposed, and what stays as it is, into the workspace."""
    size, first = robot.unit.shape[0], robot.motor_index
    for i in range(size - first):
        work.given_motors[i] = before[first + i]
        if problem == Problem.MOTORS:
            work.given_motors[i] = given[i]
        elif problem == Problem.POSE:
            work.given_motors[i] = given[IMPOSED_MOTORS + i]
        work.given_efforts[i], work.effort_change[i] = 0.0, 0.0
        if problem == Problem.EFFORTS:
            work.given_efforts[i] = given[i]
            work.effort_change[i] = given[i] - before[size + EFFORT + i]
    if problem == Problem.POSE:
        for i in robot.inverse_unknowns:
            if i >= first:
                work.given_motors[i - first] = before[i]
    for i in range(3):
        at = POSITION + i
        work.given_position[i] = given[at] if problem == Problem.POSE else before[size + at]
        for j in range(3):
            at = ROTATION + 3 * i + j
            work.given_rotation[i, j] = given[at] if problem == Problem.POSE else before[size + at]


@inlined
def _is_near(robot, problem, given, before):
    """Whether a request is finite and not farther than a step may be, see ``Target.distance``."""
    longest = LONGEST_STEP
    size, first = robot.unit.shape[0], robot.motor_index
    if problem == Problem.POSE:
        trace = 0.0
        for i in range(9):
            trace += given[ROTATION + i] * before[size + ROTATION + i]
        if not 0.5 * (trace - 1.0) >= math.cos(longest):
            return False
        length = robot.unit[robot.motor_index - 1]
        for i in range(3):
            change = given[POSITION + i] - before[size + POSITION + i]
            if not abs(change) <= longest * length:
                return False
        return True
    for i in range(size - first):
        if problem == Problem.MOTORS:
            change = (given[i] - before[first + i]) / robot.unit[first + i]
        else:
            change = (given[i] - before[size + EFFORT + i]) * robot.unit[first + i]
            change /= EFFORT_UNIT * robot.energy_unit
        if not abs(change) <= longest:
            return False
    return True


@inlined
def _same_signs(robot, problem, record, next_record):
    """Whether nothing happens between two equilibria, as far as their signs tell."""
    first = robot.unit.shape[0] + SIGNS
    watched = INDEX_FREE if problem == Problem.EFFORTS else INDEX_LOCKED
    if record[first + watched] != next_record[first + watched]:
        return False
    turned = record[first + INVERSE_SIGN] != next_record[first + INVERSE_SIGN]
    return problem != Problem.POSE or not turned
