# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is known of one cell beyond its solution: eigenvalues of H_r and distances from singularities.

The same numbers as `model.stability` and `model.kinemato_statics`, without scipy. The
smallest singular value of a linear problem of Section V-C comes from Lanczos' method on its inverse:
the matrix M = [Z^T K_x, ..., J_x] needs no basis Z, for M x = b and M^T y = c are solved with the
Newton matrix F of the geometrico-static problem, condensed leg by leg, and with its transpose.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels.condensation_kernel import NO_INVERSE, factor, solve, solve_transposed
from ..kernels.kernel_decorators import strict_part
from ..kernels.rotation_matrices import roll_pitch_yaw_into
from .eigenvalue_kernel import (
    count_below,
    eigenvalues_of_tridiagonal,
    largest_of_tridiagonal,
    tridiagonalise,
)

__all__ = ["smallest_singular_value", "spectrum_of"]

#: Steps of Lanczos' method, and the relative change at which it is done.
_LANCZOS_STEPS = 60
_LANCZOS_CHANGE = 1e-6
#: Steps from one look at the result to the next.
_LANCZOS_CHECK = 4
#: Relative error of the largest Ritz value.
_RITZ_PRECISION = 1e-10


@strict_part
def spectrum_of(problem, tangent, values):
    """Eigenvalues of H_r with the motors held, orthonormal basis of the admissible motions.

    Args:
        problem: CellProblem.
        tangent: Of the model at an equilibrium, (N, N).
        values: Result, (K,): the smallest eigenvalues, ascending [J]; NaN beyond their number.

    Returns:
        The smallest and the largest absolute eigenvalue [J], and the number of negative ones.
    """
    moving, motions, span = problem.moving, problem.motions, problem.span
    size, held = moving.shape[0], problem.multipliers.shape[0]
    half, hessian = np.empty((size, size)), np.empty((size, size))
    slopes = np.empty((held, size))
    for j in range(size):
        for i in range(size):
            total = 0.0
            for k in range(span[j, 0], span[j, 1]):
                entry = tangent[moving[i], moving[k]] + tangent[moving[k], moving[i]]
                total += 0.5 * entry * motions[k, j]
            half[i, j] = total
        for i in range(held):
            total = 0.0
            for k in range(span[j, 0], span[j, 1]):
                total += tangent[problem.multipliers[i], moving[k]] * motions[k, j]
            slopes[i, j] = total
    for i in range(size):
        for j in range(size):
            hessian[i, j] = 0.0
        for k in range(span[i, 0], span[i, 1]):
            weight, source = motions[k, i], half[k]
            for j in range(size):
                hessian[i, j] += weight * source[j]
    rank = _reflect_onto_null_space(slopes, hessian)
    free = size - rank
    for k in range(values.shape[0]):
        values[k] = np.nan
    if free == 0:
        return np.inf, np.inf, 0
    reduced = np.empty((free, free))
    for i in range(free):
        for j in range(free):
            reduced[i, j] = hessian[rank + i, rank + j]
    diagonal, beside = np.empty(free), np.empty(free)
    tridiagonalise(reduced, free, diagonal, beside, np.empty(free), np.empty(free))
    below = count_below(diagonal, beside, free, 0.0)
    count = min(values.shape[0], free)
    wanted, found = np.empty(count + 3, np.int64), np.empty(count + 3)
    for k in range(count):
        wanted[k] = k
    wanted[count] = max(below - 1, 0)  # the two on either side of zero, and the largest
    wanted[count + 1] = min(below, free - 1)
    wanted[count + 2] = free - 1
    eigenvalues_of_tridiagonal(diagonal, beside, free, wanted, found)
    for k in range(count):
        values[k] = found[k]
    nearest = min(abs(found[count]), abs(found[count + 1]))
    largest = max(abs(found[0]), abs(found[count + 2]))
    negative = 0 if below == 0 else count_below(diagonal, beside, free, -1e-11 * largest)
    return nearest, largest, negative


@strict_part
def _reflect_onto_null_space(slopes, hessian):
    """Reflect so that the last coordinates span the null space of ``slopes``; returns the rank.

    Args:
        slopes: Constraint Jacobian, (C, m); destroyed.
        hessian: Symmetric, (m, m); afterwards in the new coordinates where both are beyond the rank.
    """
    count, size = slopes.shape
    vector, product = np.empty(size), np.empty(size)
    first_length = 0.0
    for k in range(min(count, size)):
        best, row = -1.0, k
        for i in range(k, count):
            total = 0.0
            for j in range(k, size):
                total += slopes[i, j] * slopes[i, j]
            if total > best:
                best, row = total, i
        length = math.sqrt(best)
        if k == 0:
            first_length = length
        if length <= 1e-12 * first_length:
            return k
        for j in range(size):
            slopes[k, j], slopes[row, j] = slopes[row, j], slopes[k, j]
        for j in range(k, size):
            vector[j] = slopes[k, j]
        beta = 1.0 / (best + length * abs(vector[k]))
        vector[k] += length if vector[k] >= 0.0 else -length
        for i in range(k + 1, count):
            target, total = slopes[i], 0.0
            for j in range(k, size):
                total += target[j] * vector[j]
            total *= beta
            for j in range(k, size):
                target[j] -= total * vector[j]
        for j in range(k, size):
            product[j] = 0.0
        for i in range(k, size):
            source, weight = hessian[i], beta * vector[i]
            for j in range(k, size):
                product[j] += source[j] * weight
        inner = 0.0
        for i in range(k, size):
            inner += product[i] * vector[i]
        inner *= 0.5 * beta
        for i in range(k, size):
            product[i] -= inner * vector[i]
        for i in range(k, size):
            target, one, two = hessian[i], vector[i], product[i]
            for j in range(k, size):
                target[j] -= one * product[j] + two * vector[j]
    return min(count, size)


@strict_part
def smallest_singular_value(problem, square, tangent, rotation, scratch, work):
    """Smallest singular value of a linear problem of Section V-C, dimensionless.

    Args:
        problem: CellProblem.
        square: SquareProblem of forward or inverse problem.
        tangent: Of the model at an equilibrium, (N, N).
        rotation: Platform rotation there.
        scratch: Memory, (N, N).
        work: Workspace with the same tangent.
    """
    robot = problem.robot
    for i in range(tangent.shape[0]):
        for j in range(tangent.shape[0]):
            scratch[i, j] = tangent[i, j]
    if square.angles:
        _use_angles(robot, rotation, scratch)
    columns = square.unknowns
    if factor(robot, rotation, square, work, work.factors) == NO_INVERSE:
        return 0.0
    effort_rows = _effort_rows(robot, columns, scratch)
    motors, size = effort_rows.shape
    rigid = np.ones(size)  # zero where a multiplier is, which is no unknown of the linear problem
    for i in range(problem.multipliers.shape[0]):
        rigid[problem.multipliers[i]] = 0.0
    basis = np.zeros((_LANCZOS_STEPS, size + motors))
    diagonal, beside = np.empty(_LANCZOS_STEPS), np.empty(_LANCZOS_STEPS)
    vector = np.empty(size + motors)
    for i in range(size):
        vector[i] = rigid[i] * (1.0 + 0.5 * math.sin(1.7 * i + 0.3))
    for i in range(motors):
        vector[size + i] = 1.0 + 0.5 * math.cos(1.3 * i)
    length = _length(vector)
    before = 0.0
    for step in range(_LANCZOS_STEPS):
        for i in range(size + motors):
            basis[step, i] = vector[i] / length
            vector[i] = basis[step, i]
        _apply_inverse_square(robot, square, effort_rows, rigid, vector, work)
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
def _effort_rows(robot, columns, tangent):
    """How the unknowns of a problem, whose border has these columns, change the efforts."""
    inner, motors = robot.platform_index, tangent.shape[0] - robot.motor_index
    rows = np.empty((motors, inner + columns.shape[0]))
    for i in range(motors):
        row = robot.motor_index + i
        for j in range(rows.shape[1]):
            column = j if j < inner else columns[j - inner]
            scale = robot.unit[row] * robot.unit[column] / robot.energy_unit
            rows[i, j] = scale * tangent[row, column]
    return rows


@strict_part
def _length(vector):
    total = 0.0
    for i in range(vector.shape[0]):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@strict_part
def _apply_inverse_square(robot, square, effort_rows, rigid, vector, work):
    """Multiply by the inverse of M^T M, in place; efforts are the last entries."""
    motors, size = effort_rows.shape
    for i in range(motors):  # M^T y = c: the columns of the efforts are minus unit vectors
        pushed = -vector[size + i]
        for j in range(size):
            vector[j] -= effort_rows[i, j] * pushed
        vector[size + i] = pushed
    part = vector[:size]
    solve_transposed(robot, square, part, work, work.factors)
    solve(robot, square, part, work, work.factors)
    for i in range(motors):
        total = -vector[size + i]
        for j in range(size):
            total += effort_rows[i, j] * part[j]
        vector[size + i] = total
    for j in range(size):
        part[j] *= rigid[j]


@strict_part
def _use_angles(robot, rotation, tangent):
    """Turn the derivatives by world rotations into those by roll, pitch and yaw."""
    first = robot.platform_index
    angles = np.empty(3)
    roll_pitch_yaw_into(rotation, angles)
    cosine, sine = math.cos(angles[2]), math.sin(angles[2])
    for i in range(tangent.shape[0]):
        x, y, z = tangent[i, first], tangent[i, first + 1], tangent[i, first + 2]
        tangent[i, first] = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
        tangent[i, first + 1] = cosine * y - sine * x
        tangent[i, first + 2] = z
