# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A few eigenvalues of symmetric matrices, the same on every machine, thread and process.

LAPACK behind numpy may share a matrix between threads, and then rounds differently; maps have to be the
same however they are made.
"""

from __future__ import annotations

import math

import numpy as np

from .kernel_decorators import strict_allocating_part, strict_part

__all__ = [
    "count_below",
    "eigenvalues_of_tridiagonal",
    "largest_of_tridiagonal",
    "last_entry",
    "tridiagonalise",
]

#: Stands for a pivot of zero: its sign does not matter, but it is divided by.
_NO_PIVOT = 1e-300
#: Halvings of an interval of eigenvalues: from its width to the rounding of the matrix.
_HALVINGS = 54


@strict_part
def tridiagonalise(matrix, size, diagonal, beside, vector, product):
    """Reflect the leading square of a symmetric matrix to tridiagonal form (Householder), in place.

    Args:
        matrix: Symmetric, both triangles are read; destroyed.
        size: Rows of the square.
        diagonal: Result, the diagonal, (size,).
        beside: Result, entry i is beside the diagonal in rows i and i + 1, (size,).
        vector: Memory, (size,).
        product: Memory, (size,).
    """
    for last in range(size - 1, 0, -1):  # row `last` is reflected onto its last entry but one
        row = matrix[last]
        diagonal[last] = row[last]
        total = 0.0
        for j in range(last):
            total += row[j] * row[j]
        length = math.sqrt(total)
        beside[last - 1] = length
        if length == 0.0:
            continue
        for j in range(last):
            vector[j] = row[j]
            product[j] = 0.0
        sign = 1.0 if row[last - 1] >= 0.0 else -1.0
        vector[last - 1] += sign * length
        beside[last - 1] = -sign * length
        factor = 1.0 / (total + length * abs(row[last - 1]))
        for i in range(last):
            source, weight = matrix[i], vector[i]
            for j in range(last):
                product[j] += source[j] * weight
        inner = 0.0
        for j in range(last):
            product[j] *= factor
            inner += product[j] * vector[j]
        inner *= 0.5 * factor
        for j in range(last):
            product[j] -= inner * vector[j]
        for i in range(last):
            target, vector_share, product_share = matrix[i], vector[i], product[i]
            for j in range(last):
                target[j] -= vector_share * product[j] + product_share * vector[j]
    diagonal[0] = matrix[0, 0]
    beside[size - 1] = 0.0


@strict_part
def count_below(diagonal, beside, size, value):
    """Number of eigenvalues of a tridiagonal matrix below a value (Sturm)."""
    below, pivot = 0, 1.0
    for i in range(size):
        coupled = 0.0 if i == 0 else beside[i - 1] * beside[i - 1] / pivot
        pivot = diagonal[i] - value - coupled
        if pivot == 0.0:
            pivot = _NO_PIVOT
        if pivot < 0.0:
            below += 1
    return below


@strict_allocating_part
def eigenvalues_of_tridiagonal(diagonal, beside, size, wanted, values):
    """Some eigenvalues of a tridiagonal matrix by bisection, good to the rounding of the matrix.

    Args:
        diagonal: (size,).
        beside: (size,).
        size: Rows.
        wanted: Which ones, from 0, ascending, (K,).
        values: Result, (K,).
    """
    radius = 0.0
    for i in range(size):
        reach = abs(diagonal[i]) + abs(beside[i])
        if i > 0:
            reach += abs(beside[i - 1])
        radius = max(radius, reach)
    count = wanted.shape[0]
    low, high = np.full(count, -radius), np.full(count, radius)
    pivots, below = np.empty(count), np.empty(count)
    for _ in range(_HALVINGS):
        for k in range(count):
            values[k] = 0.5 * (low[k] + high[k])
            pivots[k] = 1.0
            below[k] = 0.0
        for i in range(size):
            squared = 0.0 if i == 0 else beside[i - 1] * beside[i - 1]
            entry = diagonal[i]
            for k in range(count):  # all intervals side by side
                pivot = entry - values[k] - squared / pivots[k]
                pivot = _NO_PIVOT if pivot == 0.0 else pivot
                pivots[k] = pivot
                below[k] += 1.0 if pivot < 0.0 else 0.0
        for k in range(count):
            if below[k] > wanted[k]:
                high[k] = values[k]
            else:
                low[k] = values[k]
    for k in range(count):
        values[k] = 0.5 * (low[k] + high[k])


@strict_part
def largest_of_tridiagonal(diagonal, beside, size, precision):
    """Largest eigenvalue of a tridiagonal matrix without negative ones.

    By Laguerre's method from above, which never passes it: of the logarithm of the characteristic
    polynomial it takes slope and bend, whose terms are those of the pivots of ``value - T``.

    Args:
        diagonal: (size,).
        beside: (size,).
        size: Rows.
        precision: Largest relative error.
    """
    value = 0.0
    for i in range(size):
        reach = abs(diagonal[i])
        if i > 0:
            reach += abs(beside[i - 1])
        if i < size - 1:
            reach += abs(beside[i])
        value = max(value, reach)
    while True:
        slope, bend = 0.0, 0.0
        pivot, pivot_rate, pivot_bend = 1.0, 0.0, 0.0
        for i in range(size):
            coupled = 0.0 if i == 0 else beside[i - 1] * beside[i - 1] / pivot
            rate = pivot_rate / pivot
            pivot_bend = coupled * (pivot_bend / pivot - 2.0 * rate * rate)
            pivot_rate = 1.0 + coupled * rate
            pivot = value - diagonal[i] - coupled
            if not pivot > 0.0:
                return value  # as near as rounding lets it come
            slope += pivot_rate / pivot
            bend += (pivot_rate / pivot) ** 2 - pivot_bend / pivot
        spread = (size - 1) * (size * bend - slope * slope)
        step = size / (slope + math.sqrt(max(0.0, spread)))
        value -= step
        if step <= precision * value:
            return value


@strict_part
def last_entry(diagonal, beside, size, value):
    """Size of the last entry of the unit eigenvector of a tridiagonal matrix to its largest eigenvalue.

    Args:
        diagonal: (size,).
        beside: None is zero, (size,).
        size: Rows.
        value: The eigenvalue.
    """
    entry, squares, pivot = 1.0, 1.0, value - diagonal[size - 1]
    for i in range(size - 1, 0, -1):
        entry *= pivot / beside[i - 1]
        squares += entry * entry
        pivot = value - diagonal[i - 1] - beside[i - 1] * beside[i - 1] / pivot
    return 1.0 / math.sqrt(squares)
