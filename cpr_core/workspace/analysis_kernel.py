"""What is known of one cell beyond its solution: eigenvalues of H_r and distances from singularities.

The same numbers as `cpr_core.stability.spectrum` and `cpr_core.kinemato_statics`, without scipy. The
smallest singular value of a linear problem of Section V-C comes from Lanczos' method on its inverse:
the matrix M = [Z^T K_x, ..., J_x] needs no basis Z, for M x = b and M^T y = c are solved with the
Newton matrix F of the geometrico-static problem, condensed leg by leg, and with its transpose.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import compiled_strictly
from ..condensation_kernel import DENSE, NO_INVERSE, allocate, factor, solve
from ..newton_kernel import _use_angles
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


@compiled_strictly
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


@compiled_strictly
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


@compiled_strictly
def smallest_singular_value(problem, tangent, rotation, columns, forward, scratch, work):
    """Smallest singular value of a linear problem of Section V-C, dimensionless.

    Args:
        problem: CellProblem.
        tangent: Of the model at an equilibrium, (N, N).
        rotation: Platform rotation there.
        columns: Unknowns of the problem beside those of the legs.
        forward: Whether this is the forward problem, where world rotations are unknown.
        scratch: Memory, (N, N).
        work: Workspace.
    """
    robot = problem.robot
    for i in range(tangent.shape[0]):
        for j in range(tangent.shape[0]):
            scratch[i, j] = tangent[i, j]
    if problem.angles and not forward:
        _use_angles(robot, rotation, scratch, work)
    factors = allocate(robot, columns.shape[0])
    how = factor(robot, scratch, problem.platform_rows, columns, factors)
    if how == NO_INVERSE:
        return 0.0
    inner, motors = robot.platform_index, tangent.shape[0] - robot.motor_index
    size = inner + columns.shape[0]
    rigid = np.ones(size)  # zero where a multiplier is, which is no unknown of the linear problem
    for i in range(problem.multipliers.shape[0]):
        rigid[problem.multipliers[i]] = 0.0
    effort_rows = np.empty((motors, size))
    for i in range(motors):
        row = robot.motor_index + i
        for j in range(size):
            column = j if j < inner else columns[j - inner]
            scale = robot.unit[row] * robot.unit[column] / robot.energy_unit
            effort_rows[i, j] = scale * scratch[row, column]

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
        _apply_inverse_square(robot, factors, how, effort_rows, rigid, vector)
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


@compiled_strictly
def _length(vector):
    total = 0.0
    for i in range(vector.shape[0]):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@compiled_strictly
def _apply_inverse_square(robot, factors, how, effort_rows, rigid, vector):
    """Multiply by the inverse of M^T M, in place; efforts are the last entries."""
    motors, size = effort_rows.shape
    for i in range(motors):  # M^T y = c: the columns of the efforts are minus unit vectors
        pushed = -vector[size + i]
        for j in range(size):
            vector[j] -= effort_rows[i, j] * pushed
        vector[size + i] = pushed
    part = vector[:size]
    _solve_transposed(factors, how, part)
    solve(factors, how, part)
    for i in range(motors):
        total = -vector[size + i]
        for j in range(size):
            total += effort_rows[i, j] * part[j]
        vector[size + i] = total
    for j in range(size):
        part[j] *= rigid[j]


@compiled_strictly
def _solve_transposed(factors, how, vector):
    """Solve with the transpose of a factored matrix, in place."""
    if how == DENSE:
        _lu_solve_transposed(factors.whole, vector.shape[0], factors.whole_pivots, vector)
        return
    starts = factors.starts
    count = starts.shape[0] - 1
    border = vector[starts[count] :]
    size = border.shape[0]
    for leg in range(count):
        first = starts[leg]
        for n in range(starts[leg + 1] - first):
            for i in range(size):
                border[i] -= factors.right[leg, n, i] * vector[first + n]
    _lu_solve_transposed(factors.border, size, factors.border_pivots, border)
    for leg in range(count):
        first = starts[leg]
        extent = starts[leg + 1] - first
        part = vector[first : first + extent]
        for i in range(size):
            for n in range(extent):
                part[n] -= factors.left[leg, i, n] * border[i]
        _lu_solve_transposed(factors.blocks[leg], extent, factors.block_pivots[leg], part)


@compiled_strictly
def _lu_solve_transposed(matrix, size, pivots, vector):
    """Solve with the transpose of what ``lu_factor`` factored, in place."""
    for i in range(size):
        vector[i] /= matrix[i, i]
        for j in range(i + 1, size):
            vector[j] -= matrix[i, j] * vector[i]
    for i in range(size - 1, -1, -1):
        for j in range(i):
            vector[j] -= matrix[i, j] * vector[i]
    for k in range(size - 1, -1, -1):
        row = pivots[k]
        if row != k:
            vector[k], vector[row] = vector[row], vector[k]
