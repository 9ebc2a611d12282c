# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The pencil K v = mu M v whose finite eigenvalues are those of H_r: elimination of K - mu M.

K is the bordered Hessian, whose rows of multipliers M does not see; with the constraints of full rank
its finite eigenvalues are those of H_r on motions of unit size v^T M v. A leg touches itself and the
platform only, in K as in M. K - mu M is eliminated for all legs at once onto the platform; its negative
pivots, less the number of constraints, are the eigenvalues below mu (Sylvester).

Rows and columns of a leg are those of `pencil_layout`; with the motors held theirs are left out. Vectors
are the rows of the legs, and the platform's beside them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .delayed_pencil_kernel import (
    eliminate_delayed,
    reduce_delayed,
    substitute_delayed,
    work_of_delayed,
)
from .kernel_decorators import inlined, part
from .lanes import absolute, broadcast, load, store, total
from .pencil_layout import eliminated_rows

__all__ = [
    "Measure",
    "eliminate_pencil",
    "is_diagonal",
    "multiply_measure",
    "solve_pencil",
    "work_of_stiffness",
]

#: Pivots of the platform nearer to zero are moved away from it.
_SMALLEST_PIVOT = 1e-18


class Measure(NamedTuple):
    """M of a pencil: what the size of a motion is, and which motions there are."""

    strain: Any  # M on strain coordinates, (G, S, S)
    diagonal: Any  # whether that is diagonal (orthogonal bases)
    others: Any  # M on the other slots of legs and on their motors, diagonal, (G, r)
    platform: Any  # M on the platform's coordinates: 1 or 0
    free: Any  # whether the motors move


@part
def is_diagonal(mass):
    """Whether M is diagonal in the strain coordinates (orthogonal bases)."""
    beside = broadcast(mass, 0.0)
    for number in range(mass.shape[0]):
        for i in range(mass.shape[1]):
            for j in range(i + 1, mass.shape[1]):
                beside += absolute(load(mass, (number, i, j)))
    return total(beside) == 0.0


@part
def eliminate_pencil(pencil, measure, shift):
    """Eliminate all of ``K - shift M``.

    Args:
        pencil: Pencil.
        measure: Measure.
        shift: Number.

    Returns:
        Number of eigenvalues below the shift; -1 where a pivot of a leg was zero.
    """
    layout, blocks, left = pencil.layout, pencil.blocks, pencil.left
    width = left.shape[0]
    for i in range(width):
        for j in range(i, width):
            left[i, j] = pencil.corner[i, j]
        left[i, i] -= shift * measure.platform
    signs = broadcast(pencil.weights, 0.0)
    for number in range(blocks.shape[0]):
        signs += _eliminate_legs(number, measure, shift, pencil)
    balance = total(signs)
    if not math.isfinite(balance):
        return -1
    size = eliminated_rows(layout, measure.free)
    pivots = blocks.shape[0] * pencil.places.shape[2] * size
    negative = round(0.5 * (pivots - balance)) - layout.constraint_count
    if pencil.delayed_count[0] > 0:
        rest = eliminate_delayed(pencil, size)
        return negative + rest if rest >= 0 else -1
    return negative + _eliminate_platform(left)


@inlined
def _eliminate_platform(left):
    """Eliminate what is left of the platform; returns the number of negative pivots."""
    width, negative = left.shape[0], 0
    for k in range(width):
        if abs(left[k, k]) < _SMALLEST_PIVOT:
            left[k, k] = _SMALLEST_PIVOT
        if left[k, k] < 0.0:
            negative += 1
        inverse_pivot = 1.0 / left[k, k]
        for i in range(k + 1, width):
            multiple = left[k, i] * inverse_pivot
            for j in range(i, width):
                left[i, j] -= multiple * left[k, j]
    return negative


@inlined
def _eliminate_legs(number, measure, shift, pencil):
    """Eliminate a group, and take it off the platform's part; returns the sum of its pivots' signs."""
    blocks, upper, rows, others = pencil.blocks, pencil.upper, pencil.rows, measure.others
    layout, strains = pencil.layout, measure.strain.shape[1]
    size, platform = eliminated_rows(layout, measure.free), layout.first_platform
    first = layout.first_coupled
    signs = broadcast(others, 0.0)
    for i in range(size):
        value = load(blocks, (number, i, i)) - shift * load(others, (number, i))
        if i < strains:
            value -= shift * load(measure.strain, (number, i, i))
        for k in range(i):
            value -= load(upper, (number, k, i)) * load(rows, (k, i))
        inverse = 1.0 / value
        signs += absolute(value) * inverse
        store(pencil.inverse, (number, i), inverse)
        for j in range(i + 1, size):
            value = load(blocks, (number, i, j))
            if j < strains:
                value -= shift * load(measure.strain, (number, i, j))
            for k in range(i):
                value -= load(upper, (number, k, i)) * load(rows, (k, j))
            store(rows, (i, j), value)
            store(upper, (number, i, j), inverse * value)
        if i < first:
            continue
        for j in range(platform, layout.column_count):
            value = load(blocks, (number, i, j))
            for k in range(first, i):
                value -= load(upper, (number, k, i)) * load(rows, (k, j))
            store(rows, (i, j), value)
            store(upper, (number, i, j), inverse * value)
    for i in range(platform, layout.column_count):
        for j in range(i, layout.column_count):
            value = broadcast(others, 0.0)
            for k in range(first, size):
                value += load(upper, (number, k, i)) * load(rows, (k, j))
            pencil.left[i - platform, j - platform] -= total(value)
    return signs


@inlined
def solve_pencil(pencil, free):
    """Solve with what was eliminated, in place of the vector.

    Args:
        pencil: Pencil.
        free: Whether the motors move.
    """
    upper, vector, border = pencil.upper, pencil.vector, pencil.border
    width, platform = border.shape[0], pencil.layout.first_platform
    size, first = eliminated_rows(pencil.layout, free), pencil.layout.first_coupled
    for number in range(upper.shape[0]):
        for k in range(size - 1):
            eliminated = load(vector, (number, k))
            for i in range(k + 1, size):
                value = load(vector, (number, i)) - load(upper, (number, k, i)) * eliminated
                store(vector, (number, i), value)
        for j in range(width):
            value = broadcast(vector, 0.0)
            for k in range(first, size):
                value += load(upper, (number, k, platform + j)) * load(vector, (number, k))
            border[j] -= total(value)
    if pencil.delayed_count[0] > 0:
        reduce_delayed(pencil, size)
    else:
        _solve_platform(pencil.left, border)
    for number in range(upper.shape[0]):
        for i in range(size):
            value = load(pencil.inverse, (number, i)) * load(vector, (number, i))
            if i >= first:
                for j in range(width):
                    value -= load(upper, (number, i, platform + j)) * border[j]
            store(vector, (number, i), value)
    if pencil.delayed_count[0] > 0:
        substitute_delayed(pencil, size)
    for number in range(upper.shape[0]):
        for j in range(size - 1, 0, -1):
            found = load(vector, (number, j))
            for i in range(j):
                value = load(vector, (number, i)) - load(upper, (number, i, j)) * found
                store(vector, (number, i), value)


@inlined
def _solve_platform(left, border):
    """Solve with the eliminated platform, in place."""
    width = border.shape[0]
    for k in range(width):
        multiple = border[k] / left[k, k]
        for j in range(k + 1, width):
            border[j] -= multiple * left[k, j]
    for k in range(width - 1, -1, -1):
        rest = border[k]
        for j in range(k + 1, width):
            rest -= left[k, j] * border[j]
        border[k] = rest / left[k, k]


@part
def multiply_measure(layout, measure, vector, border, result, border_result):
    """``result = M vector``."""
    mass, strains = measure.strain, measure.strain.shape[1]
    for number in range(vector.shape[0]):
        for i in range(strains):
            value = load(mass, (number, i, i)) * load(vector, (number, i))
            if not measure.diagonal:
                for j in range(i):
                    value += load(mass, (number, j, i)) * load(vector, (number, j))
                for j in range(i + 1, strains):
                    value += load(mass, (number, i, j)) * load(vector, (number, j))
            store(result, (number, i), value)
        for i in range(strains, layout.row_count):
            moves = 1.0 if i != layout.motor or measure.free else 0.0
            value = load(measure.others, (number, i)) * load(vector, (number, i))
            store(result, (number, i), moves * value)
    for i in range(border.shape[0]):
        border_result[i] = measure.platform * border[i]


@part
def work_of_stiffness(pencil, free):
    """``vector^T K vector``, of a vector that was solved for last: delayed slots are those of then."""
    blocks, corner, vector, border = pencil.blocks, pencil.corner, pencil.vector, pencil.border
    width, platform = border.shape[0], pencil.layout.first_platform
    size = eliminated_rows(pencil.layout, free)
    value, rest = broadcast(vector, 0.0), 0.0
    for number in range(blocks.shape[0]):
        for i in range(size):
            own = load(vector, (number, i))
            row = 0.5 * load(blocks, (number, i, i)) * own
            for j in range(i + 1, size):
                row += load(blocks, (number, i, j)) * load(vector, (number, j))
            for j in range(width):
                row += load(blocks, (number, i, platform + j)) * border[j]
            value += own * row
    for i in range(width):  # of symmetric matrices, the upper triangles
        row = 0.5 * corner[i, i] * border[i]
        for j in range(i + 1, width):
            row += corner[i, j] * border[j]
        rest += border[i] * row
    work = total(value) + rest
    if pencil.delayed_count[0] > 0:
        work += work_of_delayed(pencil, size)
    return 2.0 * work
