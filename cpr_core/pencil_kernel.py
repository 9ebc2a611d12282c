"""Smallest eigenvalue of a symmetric pencil H v = mu M v shaped like an arrow.

A leg touches itself and the platform only, in H as in M. H - mu M is eliminated leg by leg onto the
platform; the number of negative pivots is the number of eigenvalues below mu (Sylvester), so whatever is
found by iteration is certified: none lies below it, one not above.

A matrix is stored as the upper triangles of its leg blocks and, beside them from column R on, their
couplings to the platform, (L, R, R + b), and the platform's own block, the corner, (b, b). Vectors hold
R entries a leg, then the platform.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled

__all__ = ["eliminate_corner", "eliminate_legs", "smallest_eigenvalue"]

#: Pivots nearer to zero, relative to the matrix, are moved away from it.
_SMALLEST_PIVOT = 1e-18
#: Change of a Rayleigh quotient whose third power is rounding, relative to the matrix.
_CHANGE = 1e-6
#: Relative distance below an eigenvalue where no other one may be.
_CERTAIN = 1e-12
#: Steps of Lanczos' method, and the relative residual at which it is left to Rayleigh quotients.
_STEPS = 40
_LANCZOS_RESIDUAL = 1e-3


@compiled
def eliminate_legs(blocks, masses, corner, corner_mass, sizes, pivots, shift, least, factors, left):
    """Eliminate leg rows of ``H - shift M``.

    Args:
        blocks: Legs of H, (L, R, R + b).
        masses: Legs of M, (L, R, R + b).
        corner: Platform block of H, (b, b).
        corner_mass: Platform block of M, (b, b).
        sizes: Rows a leg has, (L,).
        pivots: Rows of it to eliminate, the first ones, (L,).
        shift: Number.
        least: Smallest pivot.
        factors: Result: pivot rows, and rows that are left, (L, R, R + b).
        left: Result: upper triangle of what is left of the platform, (b, b).

    Returns:
        Number of negative pivots.
    """
    width, first = corner.shape[0], blocks.shape[1]
    for i in range(width):
        for j in range(i, width):
            left[i, j] = corner[i, j] - shift * corner_mass[i, j]
    negative = 0
    for leg in range(sizes.shape[0]):
        size, source, mass, target = sizes[leg], blocks[leg], masses[leg], factors[leg]
        for i in range(size):
            for j in range(i, size):
                target[i, j] = source[i, j] - shift * mass[i, j]
            for j in range(first, first + width):
                target[i, j] = source[i, j] - shift * mass[i, j]
        for k in range(pivots[leg]):
            row = target[k]
            if abs(row[k]) < least:
                row[k] = least
            if row[k] < 0.0:
                negative += 1
            inverse = 1.0 / row[k]
            for i in range(k + 1, size):
                other, multiple = target[i], row[i] * inverse
                for j in range(i, size):
                    other[j] -= multiple * row[j]
                for j in range(first, first + width):
                    other[j] -= multiple * row[j]
            for i in range(width):
                other, multiple = left[i], row[first + i] * inverse
                for j in range(i, width):
                    other[j] -= multiple * row[first + j]
    return negative


@compiled
def eliminate_corner(left, least):
    """Eliminate what is left of the platform, in place; returns the number of negative pivots."""
    width, negative = left.shape[0], 0
    for k in range(width):
        if abs(left[k, k]) < least:
            left[k, k] = least
        if left[k, k] < 0.0:
            negative += 1
        inverse = 1.0 / left[k, k]
        for i in range(k + 1, width):
            multiple = left[k, i] * inverse
            for j in range(i, width):
                left[i, j] -= multiple * left[k, j]
    return negative


@compiled
def _solve(factors, left, sizes, vector):
    """Solve with what was eliminated, in place."""
    width, first = left.shape[0], factors.shape[1]
    border = vector[sizes.shape[0] * first :]
    for leg in range(sizes.shape[0]):
        size, matrix = sizes[leg], factors[leg]
        part = vector[leg * first : leg * first + size]
        for k in range(size):
            row, multiple = matrix[k], part[k] / matrix[k, k]
            for i in range(k + 1, size):
                part[i] -= multiple * row[i]
            for j in range(width):
                border[j] -= multiple * row[first + j]
    for k in range(width):
        multiple = border[k] / left[k, k]
        for j in range(k + 1, width):
            border[j] -= multiple * left[k, j]
    for k in range(width - 1, -1, -1):
        total = border[k]
        for j in range(k + 1, width):
            total -= left[k, j] * border[j]
        border[k] = total / left[k, k]
    for leg in range(sizes.shape[0]):
        size, matrix = sizes[leg], factors[leg]
        part = vector[leg * first : leg * first + size]
        for k in range(size - 1, -1, -1):
            row, total = matrix[k], part[k]
            for j in range(width):
                total -= row[first + j] * border[j]
            for i in range(k + 1, size):
                total -= row[i] * part[i]
            part[k] = total / row[k]


@compiled
def _multiply(masses, corner_mass, sizes, vector, result):
    """``result = M vector``."""
    width, first = corner_mass.shape[0], masses.shape[1]
    border = vector[sizes.shape[0] * first :]
    border_result = result[sizes.shape[0] * first :]
    for i in range(width):
        total = 0.0
        for j in range(width):
            total += corner_mass[min(i, j), max(i, j)] * border[j]
        border_result[i] = total
    for leg in range(sizes.shape[0]):
        size, matrix = sizes[leg], masses[leg]
        part = vector[leg * first : leg * first + size]
        part_result = result[leg * first : leg * first + size]
        for i in range(size):
            part_result[i] = 0.0
        for i in range(size):
            row, here = matrix[i], part[i]
            total = row[i] * here
            for j in range(i + 1, size):
                total += row[j] * part[j]
                part_result[j] += row[j] * here
            for j in range(width):
                total += row[first + j] * border[j]
                border_result[j] += row[first + j] * here
            part_result[i] += total


@compiled
def smallest_eigenvalue(blocks, masses, corner, corner_mass, sizes, scale, stretch):
    """Smallest eigenvalue of a pencil with positive definite M.

    Lanczos' method on ``(H - low M)^-1 M`` with no eigenvalue below ``low``, then Rayleigh quotients;
    what they lead to is checked to be the smallest one, otherwise ``low`` is raised by halving and all
    begins again.

    Args:
        blocks: Legs of H, (L, R, R + b).
        masses: Legs of M, (L, R, R + b).
        corner: Platform block of H, (b, b).
        corner_mass: Platform block of M, (b, b).
        sizes: Rows a leg has, (L,).
        scale: Size of the eigenvalues, roughly.
        stretch: Loss of digits where large entries of the matrices cancel; 1: none.

    Returns:
        The eigenvalue; NaN where it was not found.
    """
    count, first, width = sizes.shape[0], blocks.shape[1], corner.shape[0]
    factors, left = np.empty(blocks.shape), np.empty((width, width))
    extent = count * first + width
    basis, loaded = np.zeros((_STEPS + 1, extent)), np.zeros((_STEPS + 1, extent))
    vector = np.zeros(extent)
    for i in range(width):
        vector[count * first + i] = 1.0 + 0.5 * math.sin(1.7 * i + 0.3)
    for leg in range(count):
        for i in range(sizes[leg]):
            vector[leg * first + i] = 1.0 + 0.5 * math.sin(1.3 * i + 2.1 * leg)
    least, margin = _SMALLEST_PIVOT * scale, _CERTAIN * stretch * scale

    low, step, high = 0.0, scale, math.inf
    while _below(blocks, masses, corner, corner_mass, sizes, low, least, factors, left) > 0:
        high = low
        low, step = low - step, 4.0 * step
        if step > 1e18 * scale:
            return math.nan
    for _ in range(60):
        _lanczos(factors, left, masses, corner_mass, sizes, vector, basis, loaded)
        value, settled = low, False
        for k in range(5):
            shift = value
            if k > 0:
                _below(blocks, masses, corner, corner_mass, sizes, shift, least, factors, left)
            value = _iterate(factors, left, masses, corner_mass, sizes, shift, vector, loaded[0])
            if not math.isfinite(value):
                return math.nan
            if abs(value - shift) <= _CHANGE * scale:
                settled = True
                break
        if settled:
            shift = value - margin
            if not _below(blocks, masses, corner, corner_mass, sizes, shift, least, factors, left):
                return value
        high = min(high, value)
        if high - low <= margin:
            return high
        middle = 0.5 * (low + high)
        if _below(blocks, masses, corner, corner_mass, sizes, middle, least, factors, left) == 0:
            low = middle
        else:
            high = middle
            _below(blocks, masses, corner, corner_mass, sizes, low, least, factors, left)
        for i in range(width):
            vector[count * first + i] += math.sin(2.9 * i + 100.0 * high / scale)
    return math.nan


@compiled
def _lanczos(factors, left, masses, corner_mass, sizes, vector, basis, loaded):
    """Replace a vector by one near the eigenvector of the smallest eigenvalue above the shift."""
    extent = vector.shape[0]
    diagonal, beside = np.empty(_STEPS), np.empty(_STEPS)
    weights, pivots = np.empty(_STEPS), np.empty(_STEPS)
    largest = 0.0
    for step in range(_STEPS + 1):
        _multiply(masses, corner_mass, sizes, vector, loaded[step])
        total = 0.0
        for i in range(extent):
            total += vector[i] * loaded[step, i]
        length = math.sqrt(max(total, 0.0))
        if step > 0:
            beside[step - 1] = length
            done = length <= 1e-12 * diagonal[0] or step == _STEPS
            if done or (step >= 6 and step % 3 == 0):
                largest = _largest(diagonal, beside, step, largest, weights, pivots)
                if done or length * abs(weights[step - 1]) <= _LANCZOS_RESIDUAL * largest:
                    for i in range(extent):
                        vector[i] = 0.0
                    for k in range(step):
                        for i in range(extent):
                            vector[i] += weights[k] * basis[k, i]
                    return
        for i in range(extent):
            basis[step, i] = vector[i] / length
            loaded[step, i] /= length
            vector[i] = loaded[step, i]
        _solve(factors, left, sizes, vector)
        for k in range(step, -1, -1):
            total = 0.0
            for i in range(extent):
                total += vector[i] * loaded[k, i]
            if k == step:
                diagonal[step] = total
            for i in range(extent):
                vector[i] -= total * basis[k, i]


@compiled
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
    for _ in range(14):
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
    high += 1e-12 * high
    value = high
    for _ in range(6):  # inverse iteration with high - T, positive definite
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


@compiled
def _below(blocks, masses, corner, corner_mass, sizes, shift, least, factors, left):
    """Eliminate everything; returns the number of eigenvalues below the shift."""
    negative = eliminate_legs(
        blocks, masses, corner, corner_mass, sizes, sizes, shift, least, factors, left
    )
    return negative + eliminate_corner(left, least)


@compiled
def _iterate(factors, left, masses, corner_mass, sizes, shift, vector, loaded):
    """One step of inverse iteration, in place; returns the Rayleigh quotient of the new vector."""
    _multiply(masses, corner_mass, sizes, vector, loaded)
    old = 0.0
    for i in range(vector.shape[0]):
        old += vector[i] * loaded[i]
    scale = 1.0 / math.sqrt(old)
    for i in range(vector.shape[0]):
        loaded[i] *= scale
        vector[i] = loaded[i]
    _solve(factors, left, sizes, vector)
    work = 0.0
    for i in range(vector.shape[0]):
        work += vector[i] * loaded[i]
    _multiply(masses, corner_mass, sizes, vector, loaded)
    length = 0.0
    for i in range(vector.shape[0]):
        length += vector[i] * loaded[i]
    return shift + work / length
