# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Triangular factors of small dense matrices, rows exchanged."""

from __future__ import annotations

from .kernel_decorators import kernel, part

__all__ = ["lu_factor", "lu_sign", "lu_solve", "lu_solve_transposed"]


@kernel
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


@part
def lu_sign(matrix, size, pivots):
    """Sign of the determinant of what ``lu_factor`` factored."""
    sign = 1
    for i in range(size):
        if (matrix[i, i] < 0.0) != (pivots[i] != i):
            sign = -sign
    return sign


@kernel
def lu_solve(matrix, size, pivots, vector):
    """Solve with the result of ``lu_factor``, in place."""
    for k in range(size):
        row = pivots[k]
        if row != k:
            vector[k], vector[row] = vector[row], vector[k]
    for i in range(size):
        total_of_row = vector[i]
        for j in range(i):
            total_of_row -= matrix[i, j] * vector[j]
        vector[i] = total_of_row
    for i in range(size - 1, -1, -1):
        total_of_row = vector[i]
        for j in range(i + 1, size):
            total_of_row -= matrix[i, j] * vector[j]
        vector[i] = total_of_row / matrix[i, i]


@kernel
def lu_solve_transposed(matrix, size, pivots, vector):
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
