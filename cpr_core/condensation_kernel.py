"""Linear solves with the tangent: legs condensed one by one onto platform and motors.

The tangent is block-arrow shaped: a leg touches its own block and the border (platform and motors)
only. With S_i the block of leg i, B_i and C_i its couplings and D the border,

    (D - sum C_i S_i^-1 B_i) x_b = r_b - sum C_i S_i^-1 r_i,    x_i = S_i^-1 (r_i - B_i x_b).

A block can be singular where the whole is not (a straight leg); then the whole matrix is factored.
All numbers here are dimensionless.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled

__all__ = ["CONDENSED", "DENSE", "NO_INVERSE", "Factors", "allocate", "factor", "solve"]

CONDENSED, DENSE, NO_INVERSE = 0, 1, 2

#: Pivots below this fraction of the largest entry of a block count as zero.
_SMALLEST_BLOCK_PIVOT = 1e-6
_SMALLEST_PIVOT = 1e-14

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Factors(NamedTuple):
    """A factored matrix with L blocks of at most d rows and a border of b rows."""

    starts: Integers  # (L + 1,) state index of the first row of every block
    blocks: Floats  # (L, d, d) LU factors of S_i
    block_pivots: Integers  # (L, d)
    right: Floats  # (L, d, b) S_i^-1 B_i
    left: Floats  # (L, b, d) C_i
    border: Floats  # (b, b) LU factors of the condensed border
    border_pivots: Integers  # (b,)
    whole: Floats  # (n, n) LU factors of everything, where needed
    whole_pivots: Integers  # (n,)


@compiled
def allocate(robot, border_size):
    """Memory for the factors of a problem with a border of some size."""
    count = robot.legs.shape[0]
    starts = np.empty(count + 1, np.int64)
    starts[0] = 0
    largest = 0
    for i in range(count):
        leg = robot.legs[i]
        starts[i + 1] = leg.multiplier_index + robot.position_axes.shape[0] + leg.orientation_count
        largest = max(largest, starts[i + 1] - starts[i])
    size = robot.platform_index + border_size
    return Factors(
        starts,
        np.empty((count, largest, largest)),
        np.empty((count, largest), np.int64),
        np.empty((count, largest, border_size)),
        np.empty((count, border_size, largest)),
        np.empty((border_size, border_size)),
        np.empty(border_size, np.int64),
        np.empty((size, size)),
        np.empty(size, np.int64),
    )


@compiled
def factor(robot, tangent, rows, columns, factors):
    """Factor the tangent of a square problem.

    Args:
        robot: RobotArrays.
        tangent: Tangent of the model (N, N), SI units.
        rows: State indices of the equations beside those of the legs, (b,).
        columns: State indices of the unknowns beside those of the legs, (b,).
        factors: Result.

    Returns:
        CONDENSED or DENSE, how it was done, or NO_INVERSE.
    """
    unit, per_energy = robot.unit, 1.0 / robot.energy_unit
    starts, border = factors.starts, factors.border
    size = rows.shape[0]
    for i in range(size):
        scale = unit[rows[i]] * per_energy
        for j in range(size):
            border[i, j] = scale * tangent[rows[i], columns[j]] * unit[columns[j]]
    for leg in range(starts.shape[0] - 1):
        first = starts[leg]
        extent = starts[leg + 1] - first
        block, pivots = factors.blocks[leg], factors.block_pivots[leg]
        left, right = factors.left[leg], factors.right[leg]
        largest = 0.0
        for i in range(extent):
            scale = unit[first + i] * per_energy
            for j in range(extent):
                value = scale * tangent[first + i, first + j] * unit[first + j]
                block[i, j] = value
                largest = max(largest, abs(value))
            for j in range(size):
                right[i, j] = scale * tangent[first + i, columns[j]] * unit[columns[j]]
                left[j, i] = scale * tangent[rows[j], first + i] * unit[rows[j]]
        if not lu_factor(block, extent, pivots, _SMALLEST_BLOCK_PIVOT * largest):
            return _factor_whole(robot, tangent, rows, columns, factors)
        _lu_solve_rows(block, extent, pivots, right, size)
        for i in range(size):
            for n in range(extent):
                multiple = left[i, n]
                for j in range(size):
                    border[i, j] -= multiple * right[n, j]
    if not lu_factor(border, size, factors.border_pivots, _SMALLEST_PIVOT):
        return NO_INVERSE
    return CONDENSED


@compiled
def _factor_whole(robot, tangent, rows, columns, factors):
    unit, per_energy = robot.unit, 1.0 / robot.energy_unit
    inner, size = robot.platform_index, rows.shape[0]
    for i in range(inner + size):
        row = i if i < inner else rows[i - inner]
        for j in range(inner + size):
            column = j if j < inner else columns[j - inner]
            factors.whole[i, j] = per_energy * unit[row] * tangent[row, column] * unit[column]
    if not lu_factor(factors.whole, inner + size, factors.whole_pivots, _SMALLEST_PIVOT):
        return NO_INVERSE
    return DENSE


@compiled
def solve(factors, how, vector):
    """Solve in place: legs first, border last, in the order of the equations and the unknowns."""
    if how == DENSE:
        lu_solve(factors.whole, vector.shape[0], factors.whole_pivots, vector)
        return
    starts = factors.starts
    count = starts.shape[0] - 1
    border = vector[starts[count] :]
    for leg in range(count):
        first = starts[leg]
        extent = starts[leg + 1] - first
        part = vector[first : first + extent]
        lu_solve(factors.blocks[leg], extent, factors.block_pivots[leg], part)
        for i in range(border.shape[0]):
            total = 0.0
            for n in range(extent):
                total += factors.left[leg, i, n] * part[n]
            border[i] -= total
    lu_solve(factors.border, border.shape[0], factors.border_pivots, border)
    for leg in range(count):
        first = starts[leg]
        for n in range(starts[leg + 1] - first):
            total = 0.0
            for i in range(border.shape[0]):
                total += factors.right[leg, n, i] * border[i]
            vector[first + n] -= total


@compiled
def lu_factor(matrix, size, pivots, smallest):
    """Factor the leading square of a matrix in place, rows exchanged.

    Returns:
        False where no pivot exceeds ``smallest``.
    """
    for k in range(size):
        best, row = 0.0, k
        for i in range(k, size):
            value = abs(matrix[i, k])
            if value > best:
                best, row = value, i
        pivots[k] = row
        if not best > smallest:
            return False
        pivot = matrix[k]
        if row != k:
            other = matrix[row]
            for j in range(size):
                pivot[j], other[j] = other[j], pivot[j]
        inverse = 1.0 / pivot[k]
        for i in range(k + 1, size):
            target = matrix[i]
            if target[k] != 0.0:
                multiple = target[k] * inverse
                target[k] = multiple
                for j in range(k + 1, size):
                    target[j] -= multiple * pivot[j]
    return True


@compiled
def _lu_solve_rows(matrix, size, pivots, right, count):
    """Solve for many right-hand sides at once, the columns of ``right``, in place."""
    for k in range(size):
        row = pivots[k]
        if row != k:
            for j in range(count):
                right[k, j], right[row, j] = right[row, j], right[k, j]
    for i in range(size):
        target = right[i]
        for n in range(i):
            multiple, source = matrix[i, n], right[n]
            for j in range(count):
                target[j] -= multiple * source[j]
    for i in range(size - 1, -1, -1):
        target = right[i]
        for n in range(i + 1, size):
            multiple, source = matrix[i, n], right[n]
            for j in range(count):
                target[j] -= multiple * source[j]
        inverse = 1.0 / matrix[i, i]
        for j in range(count):
            target[j] *= inverse


@compiled
def lu_solve(matrix, size, pivots, vector):
    """Solve with the result of ``lu_factor``, in place."""
    for k in range(size):
        row = pivots[k]
        if row != k:
            vector[k], vector[row] = vector[row], vector[k]
    for i in range(size):
        total = vector[i]
        for j in range(i):
            total -= matrix[i, j] * vector[j]
        vector[i] = total
    for i in range(size - 1, -1, -1):
        total = vector[i]
        for j in range(i + 1, size):
            total -= matrix[i, j] * vector[j]
        vector[i] = total / matrix[i, i]
