# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Smallest eigenvalue of a pencil, certified: by Sylvester's law none lies below what is found."""

from __future__ import annotations

import math

from .kernel_decorators import inlined, part
from .lanes import broadcast, load, store, total
from .pencil_kernel import eliminate_pencil, multiply_measure, solve_pencil, work_of_stiffness

__all__ = ["smallest_eigenvalue"]

#: Shifts farther from zero than this are not tried: nothing has such a stiffness.
_FARTHEST_SHIFT = 1e18
#: An eigenvalue of this size is none: constraints leave nothing to move.
_LARGEST = 1e15
#: How far below to go on if an eigenvalue is below where to begin.
_FIRST_STEP = 0.5
#: Halvings of the interval of the smallest eigenvalue, and of the largest Ritz value as its first guess.
_HALVINGS, _RITZ_HALVINGS = 60, 10
#: Inverse iterations for the vector of a Ritz value, and from one of fewer rows, just above it by this
#: fraction.
_RITZ_ITERATIONS, _KNOWN_ITERATIONS, _RITZ_ABOVE = 4, 2, 1e-12
#: Lanczos' method looks at its result from this step on, every so many steps; a vector shorter than this
#: fraction of the first entry has nothing new.
_FIRST_LOOK, _STEPS_BETWEEN, _NOTHING_NEW = 6, 3, 1e-12
#: How far below a value to look at first, and where no other eigenvalue may be at last.
_NEAR, _CERTAIN = 1e-5, 1e-11
#: How far what was solved for may be from the quotient: more than rounding may have moved it.
_WITHIN = 1e-7
#: Where something is below a value all the same, it is looked for this far below (of a value beyond one,
#: this part of it), and ever farther.
_FIRST_REACH, _REACH_GROWTH = 1e-8, 100.0
#: Squared residual up to which nothing but the number of eigenvalues below has to tell: there rounding
#: may tell it wrongly.
_SMALL_RESIDUAL = 1e-12
#: Inverse iterations before all begins again elsewhere.
_ITERATIONS = 6
#: Relative residual at which Lanczos' method is left to inverse iteration.
_LANCZOS_RESIDUAL = 1e-4


@part
def smallest_eigenvalue(pencil, measure, low, guided):
    """Smallest eigenvalue of the pencil, M being positive definite on the admissible motions.

    Lanczos' method on ``(K - low M)^-1 M`` with no eigenvalue below ``low``; what that leads to is
    checked to be the smallest one, after inverse iteration if it is not close enough; otherwise ``low``
    is raised to where what lies below it begins, and all begins again.

    Args:
        pencil: Pencil; on return its vector is the eigenvector.
        measure: Measure.
        low: Where to begin: the nearer to the eigenvalue, and below it, the better.
        guided: Whether the vector may be near the eigenvector: then inverse iteration is tried first.

    Returns:
        The eigenvalue, dimensionless; NaN where it was not found.
    """
    vector, border = pencil.vector, pencil.border
    if guided:
        value, certain = _settle(pencil, measure, _quotient(pencil, measure) - _NEAR)
        if certain and abs(value) < _LARGEST:
            return value
    step, high = _FIRST_STEP, math.inf
    while True:
        below = eliminate_pencil(pencil, measure, low)
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
        _lanczos(pencil, measure)
        value, residual = _iterate(pencil, measure, low)
        if not math.isfinite(value):
            return math.nan
        below = 1
        if not residual > _SMALL_RESIDUAL:  # else it is not the eigenvalue to so many digits yet
            below = eliminate_pencil(pencil, measure, value - _CERTAIN)
        if below == 1:
            value, certain = _settle(pencil, measure, max(low, value - _NEAR))
            below = 0 if certain else 1
        if not abs(value) < _LARGEST:
            return math.nan
        if below == 0:
            return value
        high = min(high, value)
        reach = _FIRST_REACH * max(1.0, abs(high))
        while True:  # what lies below is near, as a rule: others like it
            nearest = max(high - reach, 0.5 * (low + high))
            if high - low <= _CERTAIN or not low < nearest < high:
                return _near(pencil, measure, low)
            if eliminate_pencil(pencil, measure, nearest) == 0:
                low = nearest
                break
            high = nearest
            reach *= _REACH_GROWTH
        _add(1.0, pencil.start, border, vector, border)  # it may have had no part of what is below
    return math.nan


@part
def _near(pencil, measure, shift):
    """The eigenvalue beside a shift, by inverse iteration from a vector that may have none of it."""
    vector, border, value = pencil.vector, pencil.border, shift
    eliminate_pencil(pencil, measure, shift)
    _add(1.0, pencil.start, border, vector, border)
    for _ in range(_ITERATIONS):
        value, _ = _iterate(pencil, measure, shift)
    return value


@part
def _settle(pencil, measure, shift):
    """Inverse iteration from the vector, first with this shift, until none is left below.

    If several are below that shift, it would lead to any of them: nothing is tried.

    Returns:
        The Rayleigh quotient, or the shift where nothing was tried (not finite: failed), and whether it
        is the smallest eigenvalue.
    """
    value = math.nan
    for k in range(_ITERATIONS):
        below = eliminate_pencil(pencil, measure, shift)
        if k > 0 and below == 0:
            return value, True
        if k == 0 and below > 1:
            return shift, False
        before = value
        value, _ = _iterate(pencil, measure, shift)
        if not math.isfinite(value) or abs(value - before) <= _CERTAIN:
            break
        shift = value - _CERTAIN
    return value, False


@part
def _quotient(pencil, measure):
    """Rayleigh quotient of the vector."""
    vector, border = pencil.vector, pencil.border
    loaded, border_loaded = pencil.loaded, pencil.border_loaded
    multiply_measure(pencil.layout, measure, vector, border, loaded, border_loaded)
    length = _inner_product(vector, border, loaded, border_loaded)
    return work_of_stiffness(pencil, measure.free) / length


@part
def _iterate(pencil, measure, shift):
    """One step of inverse iteration, in place.

    Returns:
        The Rayleigh quotient of the new vector, and the square of its residual. Close to an eigenvalue
        of a leg on its own, pivots near zero take half of the digits of what was eliminated; the
        quotient with K itself has them all. NaN where both differ by more: a pivot was nothing but
        rounding.
    """
    vector, border = pencil.vector, pencil.border
    loaded, border_loaded = pencil.loaded, pencil.border_loaded
    multiply_measure(pencil.layout, measure, vector, border, loaded, border_loaded)
    old = _inner_product(vector, border, loaded, border_loaded)
    scale = 1.0 / math.sqrt(old)
    _put_multiple(scale, loaded, border_loaded, vector, border)
    solve_pencil(pencil, measure.free)
    work = scale * _inner_product(vector, border, loaded, border_loaded)
    multiply_measure(pencil.layout, measure, vector, border, loaded, border_loaded)
    length = _inner_product(vector, border, loaded, border_loaded)
    solved, quotient = shift + work / length, work_of_stiffness(pencil, measure.free) / length
    residual = (1.0 - work * work / length) / length
    if not abs(quotient - solved) <= _WITHIN * max(1.0, abs(solved)):
        quotient = math.nan
    return quotient, residual


@inlined
def _lanczos(pencil, measure):
    """Replace the vector by one near the eigenvector of the smallest eigenvalue above the shift.

    Vectors are made orthogonal to the two before only: those further back they meet again when a Ritz
    value has converged, and then this ends.
    """
    vector, border = pencil.vector, pencil.border
    basis, border_basis = pencil.basis, pencil.border_basis
    loaded, border_loaded = pencil.loaded, pencil.border_loaded
    along, beside = pencil.along_diagonal, pencil.beside_diagonal
    parts, pivots = pencil.ritz_vector, pencil.ritz_pivots
    most = basis.shape[0]
    largest, known = 0.0, 0 * most  # a constant would be compiled for on its own
    for step in range(most + 1):
        multiply_measure(pencil.layout, measure, vector, border, loaded, border_loaded)
        length = math.sqrt(max(_inner_product(vector, border, loaded, border_loaded), 0.0))
        if step > 0:
            beside[step - 1] = length
            done = length <= _NOTHING_NEW * along[0] or step == most
            if done or (step >= _FIRST_LOOK and step % _STEPS_BETWEEN == 0):
                largest = _largest_ritz_value(along, beside, step, largest, known, parts, pivots)
                known = step
                if done or length * abs(parts[step - 1]) <= _LANCZOS_RESIDUAL * largest:
                    _put_multiple(parts[0], basis[0], border_basis[0], vector, border)
                    for k in range(1, step):
                        _add(parts[k], basis[k], border_basis[k], vector, border)
                    return
        inverse = 1.0 / length
        _put_multiple(inverse, vector, border, basis[step], border_basis[step])
        _put_multiple(inverse, loaded, border_loaded, vector, border)
        solve_pencil(pencil, measure.free)
        if step > 0:
            _add(-length, basis[step - 1], border_basis[step - 1], vector, border)
        along[step] = inverse * _inner_product(vector, border, loaded, border_loaded)
        _add(-along[step], basis[step], border_basis[step], vector, border)


@part
def _largest_ritz_value(diagonal, beside, size, low, known, weights, pivots):
    """Largest eigenvalue of a tridiagonal matrix and its unit eigenvector.

    Args:
        diagonal: (size,).
        beside: Entry i is beside the diagonal in rows i and i + 1, (size,).
        size: Rows.
        low: A bound from below: the largest eigenvalue of the leading square of ``known`` rows.
        known: Rows of which the eigenvector is known, into ``weights``; 0: of none.
        weights: Result, the eigenvector, (size,).
        pivots: Memory, (size,).
    """
    for i in range(known, size):
        weights[i] = 0.0 if known > 0 else 1.0
    # The vector known before is as far from one of all rows as what couples it to those after it.
    high = low + beside[known - 1] * abs(weights[known - 1]) if known > 0 else low
    iterations = _KNOWN_ITERATIONS
    if known == 0 or not _is_above(diagonal, beside, size, high):
        high, iterations = _bound_from_above(diagonal, beside, size, low), _RITZ_ITERATIONS
    high += _RITZ_ABOVE * high
    value = high
    for _ in range(iterations):  # inverse iteration with high - T, positive definite
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


@part
def _bound_from_above(diagonal, beside, size, low):
    """A bound of the largest eigenvalue of a tridiagonal matrix from above, near it."""
    high = 0.0
    for i in range(size):
        reach = diagonal[i] + (beside[i - 1] if i > 0 else 0.0)
        if i < size - 1:
            reach += beside[i]
        high = max(high, reach)
    for _ in range(_RITZ_HALVINGS):
        middle = 0.5 * (low + high)
        if _is_above(diagonal, beside, size, middle):
            high = middle
        else:
            low = middle
    return high


@part
def _is_above(diagonal, beside, size, value):
    """Whether all eigenvalues of a tridiagonal matrix are below a value."""
    pivot = 1.0
    for i in range(size):
        coupled = beside[i - 1] * beside[i - 1] / pivot if i > 0 else 0.0
        pivot = value - diagonal[i] - coupled
        if pivot <= 0.0:
            return False
    return True


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
