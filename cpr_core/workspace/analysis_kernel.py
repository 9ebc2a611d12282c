# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is known of one cell beyond its solution: eigenvalues of H_r, those of `model.stability`."""

from __future__ import annotations

import math

import numpy as np

from ..kernels.eigenvalue_kernel import count_below, eigenvalues_of_tridiagonal, tridiagonalise
from ..kernels.kernel_decorators import strict_allocating_part

__all__ = ["spectrum_of"]


@strict_allocating_part
def spectrum_of(problem, tangent, values):
    """Eigenvalues of H_r with the motors held, orthonormal basis of the admissible motions.

    Args:
        problem: CellProblem.
        tangent: Of the model at an equilibrium, (N, N).
        values: Result, (K,): the smallest eigenvalues, ascending [J]; NaN beyond their number.

    Returns:
        The smallest and the largest absolute eigenvalue [J]; infinite where nothing can move.
    """
    size = problem.moving.shape[0]
    slopes, hessian = np.empty((problem.multipliers.shape[0], size)), np.empty((size, size))
    _by_motions(problem, tangent, slopes, hessian)
    rank = _reflect_onto_null_space(slopes, hessian)
    free = size - rank
    for k in range(values.shape[0]):
        values[k] = np.nan
    if free == 0:
        return np.inf, np.inf
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
    return nearest, largest


@strict_allocating_part
def _by_motions(problem, tangent, slopes, hessian):
    """Constraint slopes and Hessian by the motions that close the joints.

    Args:
        problem: CellProblem.
        tangent: Of the model, (N, N).
        slopes: Result, (m, K).
        hessian: Result, (K, K).
    """
    moving, motions, span = problem.moving, problem.motions, problem.span
    size = moving.shape[0]
    half = np.empty((size, size))
    for j in range(size):
        for i in range(size):
            total = 0.0
            for k in range(span[j, 0], span[j, 1]):
                entry = tangent[moving[i], moving[k]] + tangent[moving[k], moving[i]]
                total += 0.5 * entry * motions[k, j]
            half[i, j] = total
        for i in range(slopes.shape[0]):
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


@strict_allocating_part
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
            target, vector_share, product_share = hessian[i], vector[i], product[i]
            for j in range(k, size):
                target[j] -= vector_share * product[j] + product_share * vector[j]
    return min(count, size)
