# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Smallest singular value of a linear problem of Section V-C, from the condensed tangent.

It is one over the largest of the inverse, by Lanczos' method. The matrix M = [Z^T K_x, ..., J_x] needs
no basis Z: M x = b and M^T y = c are solved with the Newton matrix F of the geometrico-static problem,
condensed leg by leg, and with its transpose. In other units than the natural ones rows and columns of F
are scaled; what that changes of Z the multipliers bear, which are no unknowns of M.
"""

from __future__ import annotations

import math

import numpy as np

from .condensation_kernel import NO_INVERSE, factor, solve, solve_transposed
from .eigenvalue_kernel import largest_of_tridiagonal
from .kernel_decorators import strict_part

__all__ = ["smallest_singular_value"]

#: Steps of Lanczos' method, and the relative change at which it is done.
_LANCZOS_STEPS = 60
_LANCZOS_CHANGE = 1e-10
#: Steps from one look at the result to the next.
_LANCZOS_CHECK = 4
#: Relative error of the largest Ritz value.
_RITZ_PRECISION = 1e-10


@strict_part
def smallest_singular_value(robot, square, scales, tangent, rotation, work):
    """Smallest singular value of a linear problem, dimensionless.

    Args:
        robot: RobotArrays.
        square: SquareProblem of the forward or the inverse problem.
        scales: ProblemScales: its units.
        tangent: Of the model at an equilibrium, (N, N).
        rotation: Platform rotation there.
        work: Workspace with the same tangent.

    Returns:
        The value; 0 where the problem has no inverse.
    """
    if factor(robot, rotation, square, work, work.factors) == NO_INVERSE:
        return 0.0
    effort_rows = _effort_rows(robot, square, tangent, work.motions)
    motors, size = effort_rows.shape
    basis = np.zeros((_LANCZOS_STEPS, size + motors))
    diagonal, beside = np.empty(_LANCZOS_STEPS), np.empty(_LANCZOS_STEPS)
    vector = np.empty(size + motors)
    for i in range(size):  # zero where a multiplier is, which is no unknown of the linear problem
        vector[i] = 0.0 if scales.unknowns[i] == 0.0 else 1.0 + 0.5 * math.sin(1.7 * i + 0.3)
    for i in range(motors):
        vector[size + i] = 1.0 + 0.5 * math.cos(1.3 * i)
    length = _length(vector)
    before = 0.0
    for step in range(_LANCZOS_STEPS):
        for i in range(size + motors):
            basis[step, i] = vector[i] / length
            vector[i] = basis[step, i]
        _apply_inverse_square(robot, square, scales, effort_rows, vector, work)
        total = 0.0
        for i in range(size + motors):
            total += vector[i] * basis[step, i]
        diagonal[step] = total
        for k in range(step + 1):
            kept, total = basis[k], 0.0
            for i in range(size + motors):
                total += vector[i] * kept[i]
            for i in range(size + motors):
                vector[i] -= total * kept[i]
        length = _length(vector)
        beside[step] = length
        last = step + 1 == min(_LANCZOS_STEPS, size + motors) or length <= 1e-14 * diagonal[step]
        if not last and (step < 8 or step % _LANCZOS_CHECK != 0):
            continue
        # Ritz values only grow; a little is taken off for the rounding of the one before.
        largest = largest_of_tridiagonal(
            diagonal, beside, step + 1, (1.0 - 1e-6) * before, _RITZ_PRECISION
        )
        change = abs(largest - before)
        before = largest
        if last or change <= _LANCZOS_CHANGE * before:
            break
    return 1.0 / math.sqrt(before) if before > 0.0 else 0.0


@strict_part
def _effort_rows(robot, square, tangent, motions):
    """How the unknowns of a problem change the efforts, dimensionless."""
    inner, motors = robot.platform_index, tangent.shape[0] - robot.motor_index
    rows = np.empty((motors, inner + square.unknowns.shape[0]))
    for i in range(motors):
        row = robot.motor_index + i
        per_energy = robot.unit[row] / robot.energy_unit
        for j in range(rows.shape[1]):
            column = j if j < inner else square.unknowns[j - inner]
            turned = column - inner
            value = tangent[row, column]
            if square.angles and 0 <= turned < 3:
                value = 0.0
                for n in range(3):
                    value += tangent[row, inner + n] * motions[n, turned]
            rows[i, j] = per_energy * robot.unit[column] * value
    return rows


@strict_part
def _length(vector):
    total = 0.0
    for i in range(vector.shape[0]):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@strict_part
def _apply_inverse_square(robot, square, scales, effort_rows, vector, work):
    """Multiply by the inverse of M'^T M', in place; efforts are the last entries."""
    motors, size = effort_rows.shape
    for i in range(size + motors):
        vector[i] *= scales.unknowns[i]
    for i in range(motors):  # M^T y = c: the columns of the efforts are minus unit vectors
        pushed = -vector[size + i]
        for j in range(size):
            vector[j] -= effort_rows[i, j] * pushed
        vector[size + i] = pushed
    part = vector[:size]
    solve_transposed(robot, square, part, work, work.factors)
    for i in range(size + motors):
        vector[i] *= scales.squared_equations[i]
    solve(robot, square, part, work, work.factors)
    for i in range(motors):
        total = -vector[size + i]
        for j in range(size):
            total += effort_rows[i, j] * part[j]
        vector[size + i] = total
    for i in range(size + motors):
        vector[i] *= scales.unknowns[i]
