# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Smallest eigenvalue of H_r, from the tangent with its constraints: a symmetric pencil K v = mu M v.

K is the bordered Hessian, whose rows of multipliers M does not see; with the constraints of full rank
its finite eigenvalues are those of H_r on motions of unit size v^T M v. A leg touches itself and the
platform only, in K as in M. K - mu M is eliminated for all legs at once onto the platform; its negative
pivots, less the number of constraints, are the eigenvalues below mu (Sylvester). So whatever is found
by iteration is certified: none lies below it.

Rows of a leg are its inner slots (`slots`), then its motor; columns are the same and then the platform.
With the motors held their row and column are left out. Vectors are the rows of the legs, and the
platform's beside them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .condensation_kernel import CONDENSED
from .kept_factors import kept_border, kept_row, kept_status, recall_border
from .kernel_decorators import inlined, part
from .lanes import absolute, broadcast, get, highest, load, lower, put, store, total

__all__ = [
    "Measure",
    "eliminate_pencil",
    "is_diagonal",
    "recall_pencil",
    "smallest_eigenvalue",
    "squared_size",
]

#: What the condensation has left of platform and motors, dimensionless: entries beyond this (a leg
#: nearly straight) hide too many digits of others.
_LARGEST_BORDER = 5e6
#: A leg is put together again from its factors if no pivot is below this fraction of its largest strain
#: stiffness: beyond, too many digits of the rest are lost.
_SMALLEST_LEG_PIVOT = 1e-8
#: Shifts farther from zero than this are not tried: nothing has such a stiffness.
_FARTHEST_SHIFT = 1e18
#: Halvings of the interval of the smallest eigenvalue, and of the largest Ritz value as its first guess.
_HALVINGS, _RITZ_HALVINGS = 60, 10
#: Inverse iterations for the vector of a Ritz value, just above it by this fraction.
_RITZ_ITERATIONS, _RITZ_ABOVE = 4, 1e-12
#: Lanczos' method looks at its result from this step on, every so many steps; a vector shorter than this
#: fraction of the first entry has nothing new.
_FIRST_LOOK, _STEPS_BETWEEN, _NOTHING_NEW = 6, 3, 1e-12
#: Pivots of the platform nearer to zero are moved away from it.
_SMALLEST_PIVOT = 1e-18
#: How far below a value to look at first, and where no other eigenvalue may be at last.
_NEAR, _CERTAIN = 1e-5, 1e-11
#: Inverse iterations before all begins again elsewhere.
_ITERATIONS = 6
#: Relative residual at which Lanczos' method is left to inverse iteration.
_LANCZOS_RESIDUAL = 1e-3


class Measure(NamedTuple):
    """M of a pencil: what the size of a motion is, and which motions there are."""

    strain: Any  # M on strain coordinates, (G, S, S)
    diagonal: Any  # whether that is diagonal (orthogonal bases)
    others: Any  # M on the other slots of legs and on their motors, diagonal, (G, r)
    platform: Any  # M on the platform's coordinates: 1 or 0
    free: Any  # whether the motors move


@part
def recall_pencil(robot, kept, pencil):
    """K from the kept factors of a tangent: what was eliminated is put together again.

    The platform's part is made symmetric: loads without potential do no work on H_r. A leg has its motor
    to itself, or the rows of motors are left out, and with them what moves while motors are free.

    Returns:
        Whether enough digits are left.
    """
    corner, condensed = pencil.corner, pencil.condensed
    slots, lanes, groups = robot.slots, robot.slot_index.shape[2], robot.groups.shape[0]
    doubt = broadcast(pencil.rows, -1.0)
    if kept_status(kept) != CONDENSED:
        return False
    recall_border(kept, kept_border(slots, groups), condensed.shape[0], lanes, condensed)
    for i in range(condensed.shape[0]):
        for j in range(condensed.shape[0]):
            if not abs(condensed[i, j]) < _LARGEST_BORDER:
                return False
    for i in range(slots.platform_count):
        for j in range(slots.platform_count):
            corner[i, j] = 0.5 * (condensed[i, j] + condensed[j, i])
    for number in range(groups):
        doubt = -lower(-doubt, _recall_leg_rows(slots, number, kept, pencil))
        _recall_platform(slots, number, kept, pencil)
        if robot.one_slot_a_motor:
            _recall_motor_rows(robot, number, kept, pencil)
    return highest(doubt) < 0.0


@inlined
def _recall_leg_rows(slots, number, kept, pencil):
    """Rows of the inner slots of a group; returns what is positive where too few digits are left."""
    blocks, rows = pencil.blocks, pencil.rows
    inner, extent, first = slots.inner_count, slots.total, slots.first_coupled
    largest, smallest = broadcast(rows, 0.0), broadcast(rows, np.inf)
    for i in range(inner):
        # Stored in place of the unit diagonal: the inverse pivot.
        row = kept_row(slots, number, i)
        pivot = 1.0 / load(kept, row + i)
        store(rows, (i, i), pivot)
        smallest = lower(smallest, absolute(pivot))
        if i < slots.strain_count:
            largest = -lower(-largest, -absolute(pivot))
        for j in range(i + 1, extent):
            store(rows, (i, j), pivot * load(kept, row + j))
        for j in range(i, extent):
            begin = 0 if j < inner or j == extent - 1 else first
            value = broadcast(rows, 0.0)
            for k in range(begin, i):
                value += load(kept, kept_row(slots, number, k) + i) * load(rows, (k, j))
            if i >= begin:
                value += load(rows, (i, j))
            at = j if j < inner else (j + 1 if j < extent - 1 else inner)
            store(blocks, (number, i, at), value)
    return smallest - _SMALLEST_LEG_PIVOT * largest


@inlined
def _recall_platform(slots, number, kept, pencil):
    """Give back to the platform what a group had taken from it."""
    inner, width = slots.inner_count, slots.platform_count
    for i in range(width):
        for j in range(i, width):
            value = broadcast(pencil.rows, 0.0)
            for k in range(slots.first_coupled, inner):
                left = load(kept, kept_row(slots, number, k) + inner + i)
                value += left * load(pencil.rows, (k, inner + j))
            pencil.corner[i, j] += total(value)


@inlined
def _recall_motor_rows(robot, number, kept, pencil):
    """Rows of the motors of a group, with what the legs had taken from them."""
    slots, blocks, rows = robot.slots, pencil.blocks, pencil.rows
    inner, width, extent = slots.inner_count, slots.platform_count, slots.total
    for j in range(width + 1):
        value = broadcast(rows, 0.0)
        begin = slots.first_coupled if j < width else 0
        for k in range(begin, inner):
            left = load(kept, kept_row(slots, number, k) + inner + j)
            value += left * load(rows, (k, extent - 1))
        column = inner + 1 + j if j < width else inner
        store(blocks, (number, inner, column), value)
    for lane in range(robot.slot_index.shape[2]):
        motor = robot.motor_slot_index[number, 0, lane]
        if motor < 0:
            put(blocks, (number, inner, inner), lane, 1.0)
            continue
        m = motor - robot.platform_index
        for j in range(width + 1):
            column = inner + 1 + j if j < width else inner
            value = get(blocks, (number, inner, column), lane)
            value += pencil.condensed[m, j if j < width else m]
            put(blocks, (number, inner, column), lane, value)


@part
def eliminate_pencil(robot, pencil, measure, shift):
    """Eliminate all of ``K - shift M``.

    Args:
        robot: RobotArrays.
        pencil: Pencil.
        measure: Measure.
        shift: Number.

    Returns:
        Number of eigenvalues below the shift; -1 where a pivot of a leg was zero.
    """
    blocks, left, width = pencil.blocks, pencil.left, robot.slots.platform_count
    for i in range(width):
        for j in range(i, width):
            left[i, j] = pencil.corner[i, j]
        left[i, i] -= shift * measure.platform
    signs = broadcast(pencil.weights, 0.0)
    for number in range(blocks.shape[0]):
        signs += _eliminate_legs(robot.slots, number, measure, shift, pencil)
    balance = total(signs)
    if not math.isfinite(balance):
        return -1
    size = robot.slots.inner_count + (1 if measure.free else 0)
    pivots = blocks.shape[0] * robot.slot_index.shape[2] * size
    negative = round(0.5 * (pivots - balance)) - robot.constraint_count
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
def _eliminate_legs(slots, number, measure, shift, pencil):
    """Eliminate a group, and take it off the platform's part; returns the sum of its pivots' signs."""
    blocks, upper, rows, others = pencil.blocks, pencil.upper, pencil.rows, measure.others
    inner, width, strains = slots.inner_count, slots.platform_count, slots.strain_count
    first, size = slots.first_coupled, inner + (1 if measure.free else 0)
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
        for j in range(inner + 1, slots.total):
            value = load(blocks, (number, i, j))
            for k in range(first, i):
                value -= load(upper, (number, k, i)) * load(rows, (k, j))
            store(rows, (i, j), value)
            store(upper, (number, i, j), inverse * value)
    for i in range(inner + 1, inner + 1 + width):
        for j in range(i, inner + 1 + width):
            value = broadcast(others, 0.0)
            for k in range(first, size):
                value += load(upper, (number, k, i)) * load(rows, (k, j))
            pencil.left[i - inner - 1, j - inner - 1] -= total(value)
    return signs


@part
def _solve(upper, inverses, left, first, free, vector, border):
    """Solve with what was eliminated, in place."""
    inner, width = upper.shape[1] - 1, left.shape[0]
    size = inner + 1 if free else inner
    for number in range(upper.shape[0]):
        for k in range(size - 1):
            eliminated = load(vector, (number, k))
            for i in range(k + 1, size):
                value = load(vector, (number, i)) - load(upper, (number, k, i)) * eliminated
                store(vector, (number, i), value)
        for j in range(width):
            value = broadcast(vector, 0.0)
            for k in range(first, size):
                value += load(upper, (number, k, inner + 1 + j)) * load(vector, (number, k))
            border[j] -= total(value)
        for i in range(size):
            value = load(inverses, (number, i)) * load(vector, (number, i))
            store(vector, (number, i), value)
    for k in range(width):
        multiple = border[k] / left[k, k]
        for j in range(k + 1, width):
            border[j] -= multiple * left[k, j]
    for k in range(width - 1, -1, -1):
        rest = border[k]
        for j in range(k + 1, width):
            rest -= left[k, j] * border[j]
        border[k] = rest / left[k, k]
    for number in range(upper.shape[0]):
        for i in range(first, size):
            value = load(vector, (number, i))
            for j in range(width):
                value -= load(upper, (number, i, inner + 1 + j)) * border[j]
            store(vector, (number, i), value)
        for j in range(size - 1, 0, -1):
            found = load(vector, (number, j))
            for i in range(j):
                value = load(vector, (number, i)) - load(upper, (number, i, j)) * found
                store(vector, (number, i), value)


@part
def _multiply(measure, vector, border, result, border_result):
    """``result = M vector``."""
    mass, inner = measure.strain, vector.shape[1] - 1
    strains = mass.shape[1]
    for number in range(vector.shape[0]):
        for i in range(strains):
            value = load(mass, (number, i, i)) * load(vector, (number, i))
            if not measure.diagonal:
                for j in range(i):
                    value += load(mass, (number, j, i)) * load(vector, (number, j))
                for j in range(i + 1, strains):
                    value += load(mass, (number, i, j)) * load(vector, (number, j))
            store(result, (number, i), value)
        for i in range(strains, inner + 1):
            moves = 1.0 if i < inner or measure.free else 0.0
            value = load(measure.others, (number, i)) * load(vector, (number, i))
            store(result, (number, i), moves * value)
    for i in range(border.shape[0]):
        border_result[i] = measure.platform * border[i]


@part
def _inner_product(first, first_border, second, second_border):
    """Sum of products of two vectors."""
    value, rest = broadcast(first, 0.0), 0.0
    for number in range(first.shape[0]):
        for i in range(first.shape[1]):
            value += load(first, (number, i)) * load(second, (number, i))
    for i in range(first_border.shape[0]):
        rest += first_border[i] * second_border[i]
    return total(value) + rest


@part
def _add(factor, vector, border, result, border_result):
    """``result += factor vector``."""
    for number in range(vector.shape[0]):
        for i in range(vector.shape[1]):
            value = load(result, (number, i)) + factor * load(vector, (number, i))
            store(result, (number, i), value)
    for i in range(border.shape[0]):
        border_result[i] += factor * border[i]


@part
def _put_multiple(factor, vector, border, result, border_result):
    """``result = factor vector``."""
    for number in range(vector.shape[0]):
        for i in range(vector.shape[1]):
            store(result, (number, i), factor * load(vector, (number, i)))
    for i in range(border.shape[0]):
        border_result[i] = factor * border[i]


@part
def smallest_eigenvalue(robot, pencil, measure, guess):
    """Smallest eigenvalue of the pencil, M being positive definite on the admissible motions.

    Lanczos' method on ``(K - low M)^-1 M`` with no eigenvalue below ``low``, then inverse iteration;
    what that leads to is checked to be the smallest one, otherwise ``low`` is raised by halving and all
    begins again.

    Args:
        robot: RobotArrays.
        pencil: Pencil; on return its vector is the eigenvector.
        measure: Measure.
        guess: Rayleigh quotient of the vector of the pencil, from which inverse iteration is tried
            first; NaN: none.

    Returns:
        The eigenvalue, dimensionless; NaN where it was not found.
    """
    vector, border = pencil.vector, pencil.border
    if math.isfinite(guess):
        value, certain = _settle(robot, pencil, measure, guess - _NEAR)
        if certain:
            return value
    low, step, high = 0.0, 1.0, math.inf
    while True:
        below = eliminate_pencil(robot, pencil, measure, low)
        if below == 0:
            break
        high = low
        low, step = low - step, 4.0 * step
        if below < 0 or step > _FARTHEST_SHIFT:
            return math.nan
    _put_multiple(1.0, pencil.start, border, vector, border)
    for i in range(border.shape[0]):
        border[i] = measure.platform * (1.0 + 0.5 * math.sin(1.7 * i + 0.3))
    for _ in range(_HALVINGS):
        _lanczos(robot, pencil, measure)
        value = _iterate(robot, pencil, measure, low)
        value, certain = _settle(robot, pencil, measure, value - _NEAR)
        if certain or not math.isfinite(value):
            return value
        high = min(high, value)
        if high - low <= _CERTAIN:
            return high
        middle = 0.5 * (low + high)
        if eliminate_pencil(robot, pencil, measure, middle) == 0:
            low = middle
        else:
            high = middle
            eliminate_pencil(robot, pencil, measure, low)
        for i in range(border.shape[0]):
            border[i] += measure.platform * math.sin(2.9 * i + 100.0 * high)
    return math.nan


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
def squared_size(pencil, measure):
    """``v^T M v`` of the vector of the pencil."""
    vector, border = pencil.vector, pencil.border
    loaded, border_loaded = pencil.loaded, pencil.border_loaded
    _multiply(measure, vector, border, loaded, border_loaded)
    return _inner_product(vector, border, loaded, border_loaded)


@part
def _settle(robot, pencil, measure, shift):
    """Inverse iteration from the vector, first with this shift, until none is left below.

    Returns:
        The Rayleigh quotient (not finite: failed), and whether it is the smallest eigenvalue.
    """
    value = math.nan
    for k in range(_ITERATIONS):
        below = eliminate_pencil(robot, pencil, measure, shift)
        if k > 0 and below == 0:
            return value, True
        value = _iterate(robot, pencil, measure, shift)
        if not math.isfinite(value):
            break
        shift = value - _CERTAIN
    return value, False


@part
def _iterate(robot, pencil, measure, shift):
    """One step of inverse iteration, in place; returns the Rayleigh quotient of the new vector."""
    vector, border = pencil.vector, pencil.border
    loaded, border_loaded = pencil.loaded, pencil.border_loaded
    first = robot.slots.first_coupled
    _multiply(measure, vector, border, loaded, border_loaded)
    old = _inner_product(vector, border, loaded, border_loaded)
    scale = 1.0 / math.sqrt(old)
    _put_multiple(scale, loaded, border_loaded, vector, border)
    _solve(pencil.upper, pencil.inverse, pencil.left, first, measure.free, vector, border)
    work = scale * _inner_product(vector, border, loaded, border_loaded)
    _multiply(measure, vector, border, loaded, border_loaded)
    length = _inner_product(vector, border, loaded, border_loaded)
    return shift + work / length


@part
def _lanczos(robot, pencil, measure):
    """Replace the vector by one near the eigenvector of the smallest eigenvalue above the shift.

    Vectors are made orthogonal to the two before only: those further back they meet again when a Ritz
    value has converged, and then this ends.
    """
    vector, border = pencil.vector, pencil.border
    basis, border_basis = pencil.basis, pencil.border_basis
    loaded, border_loaded = pencil.loaded, pencil.border_loaded
    along, beside = pencil.tridiagonal[0], pencil.tridiagonal[1]
    parts, pivots = pencil.tridiagonal[2], pencil.tridiagonal[3]
    first = robot.slots.first_coupled
    most = basis.shape[0]
    largest = 0.0
    for step in range(most + 1):
        _multiply(measure, vector, border, loaded, border_loaded)
        length = math.sqrt(max(_inner_product(vector, border, loaded, border_loaded), 0.0))
        if step > 0:
            beside[step - 1] = length
            done = length <= _NOTHING_NEW * along[0] or step == most
            if done or (step >= _FIRST_LOOK and step % _STEPS_BETWEEN == 0):
                largest = _largest(along, beside, step, largest, parts, pivots)
                if done or length * abs(parts[step - 1]) <= _LANCZOS_RESIDUAL * largest:
                    _put_multiple(parts[0], basis[0], border_basis[0], vector, border)
                    for k in range(1, step):
                        _add(parts[k], basis[k], border_basis[k], vector, border)
                    return
        inverse = 1.0 / length
        _put_multiple(inverse, vector, border, basis[step], border_basis[step])
        _put_multiple(inverse, loaded, border_loaded, vector, border)
        _solve(pencil.upper, pencil.inverse, pencil.left, first, measure.free, vector, border)
        if step > 0:
            _add(-length, basis[step - 1], border_basis[step - 1], vector, border)
        along[step] = inverse * _inner_product(vector, border, loaded, border_loaded)
        _add(-along[step], basis[step], border_basis[step], vector, border)


@part
def _largest(diagonal, beside, size, low, weights, pivots):
    """Largest eigenvalue of a tridiagonal matrix and its unit eigenvector.

    Args:
        diagonal: (size,).
        beside: Entry i is beside the diagonal in rows i and i + 1, (size,).
        size: Rows.
        low: A bound from below.
        weights: Result, the eigenvector, (size,).
        pivots: Memory, (size,).
    """
    high = 0.0
    for i in range(size):
        reach = diagonal[i] + (beside[i - 1] if i > 0 else 0.0)
        if i < size - 1:
            reach += beside[i]
        high = max(high, reach)
        weights[i] = 1.0
    for _ in range(_RITZ_HALVINGS):
        middle = 0.5 * (low + high)
        pivot, above = 1.0, True
        for i in range(size):
            coupled = beside[i - 1] * beside[i - 1] / pivot if i > 0 else 0.0
            pivot = middle - diagonal[i] - coupled
            if pivot <= 0.0:
                above = False
                break
        if above:
            high = middle
        else:
            low = middle
    high += _RITZ_ABOVE * high
    value = high
    for _ in range(_RITZ_ITERATIONS):  # inverse iteration with high - T, positive definite
        for i in range(size):
            pivots[i] = high - diagonal[i]
            if i > 0:
                multiple = beside[i - 1] / pivots[i - 1]
                pivots[i] -= multiple * beside[i - 1]
                weights[i] += multiple * weights[i - 1]
        total, product = 0.0, 0.0
        for i in range(size - 1, -1, -1):
            if i < size - 1:
                weights[i] += beside[i] * weights[i + 1]
            weights[i] /= pivots[i]
            total += weights[i] * weights[i]
        scale = 1.0 / math.sqrt(total)
        for i in range(size):
            weights[i] *= scale
        for i in range(size):
            product += weights[i] * diagonal[i] * weights[i]
            if i > 0:
                product += 2.0 * weights[i] * beside[i - 1] * weights[i - 1]
        value = product
    return value
