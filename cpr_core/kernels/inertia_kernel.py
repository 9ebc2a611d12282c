# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Signs of the tangent: how many directions lose energy, without eigenvalues.

Sylvester's law: any symmetric elimination of a matrix shows its number of negative eigenvalues. The
solver has eliminated the legs onto the border (platform and motors); what is left of the border tells
the stability index for both readings of the motors, and on which side of an inverse singularity the
robot is. With n_Psi constraints of full rank, the bordered Hessian has n_Psi negative eigenvalues more
than H_r of Eq. (48).
"""

from __future__ import annotations

import numpy as np

from .condensation_kernel import DENSE, lu_factor, rotation_unknowns
from .kernel_decorators import kernel
from .lanes import get

__all__ = ["SINGULAR_LEG", "eliminate", "signs_of"]

#: Returned in place of a count where the legs were not condensed (a straight leg under no force).
SINGULAR_LEG = -1

#: Pivots below this fraction of the largest entry of a matrix count as zero.
_SMALLEST_PIVOT = 1e-11
#: Above this fraction pivots leave a remainder whose signs can be trusted.
_SAFE_PIVOT = 1e-5
_GROWTH = (1.0 + np.sqrt(17.0)) / 8.0


@kernel
def eliminate(matrix, pivot_count, smallest):
    """Symmetric elimination with complete pivoting (Bunch and Parlett), in place.

    Args:
        matrix: Symmetric (n, n); what remains beyond ``pivot_count`` is the Schur complement.
        pivot_count: Rows and columns to eliminate, the leading ones.
        smallest: Pivots not above this count as zero.

    Returns:
        Number of negative pivots and of pivots that are zero.
    """
    size = matrix.shape[0]
    negative, first = 0, 0
    while first < pivot_count:
        on_diagonal, anywhere, d, p, q = -1.0, -1.0, first, first, first
        for i in range(first, pivot_count):
            value = abs(matrix[i, i])
            if value > on_diagonal:
                on_diagonal, d = value, i
            for j in range(first, i):
                value = abs(matrix[i, j])
                if value > anywhere:
                    anywhere, p, q = value, i, j
        if max(on_diagonal, anywhere) <= smallest:
            return negative, pivot_count - first
        if on_diagonal >= _GROWTH * anywhere:
            _exchange(matrix, first, d)
            pivot = matrix[first, first]
            if pivot < 0.0:
                negative += 1
            for i in range(first + 1, size):
                multiple = matrix[i, first] / pivot
                if multiple != 0.0:
                    for j in range(first + 1, size):
                        matrix[i, j] -= multiple * matrix[first, j]
            first += 1
        else:
            _exchange(matrix, first, q)
            _exchange(matrix, first + 1, p)
            a, b, c = matrix[first, first], matrix[first + 1, first], matrix[first + 1, first + 1]
            determinant = a * c - b * b  # negative: one pivot of either sign
            negative += 1
            for i in range(first + 2, size):
                u, v = matrix[i, first], matrix[i, first + 1]
                if u != 0.0 or v != 0.0:
                    one, two = (c * u - b * v) / determinant, (a * v - b * u) / determinant
                    for j in range(first + 2, size):
                        matrix[i, j] -= one * matrix[first, j] + two * matrix[first + 1, j]
            first += 2
    return negative, 0


@kernel
def _exchange(matrix, one, two):
    """Exchange two rows and the same columns."""
    if one == two:
        return
    for j in range(matrix.shape[0]):
        matrix[one, j], matrix[two, j] = matrix[two, j], matrix[one, j]
    for i in range(matrix.shape[0]):
        matrix[i, one], matrix[i, two] = matrix[i, two], matrix[i, one]


@kernel
def signs_of(robot, rotation, factors, work, signs):
    """Count negative directions and find the sign of the inverse problem's determinant.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation, (3, 3).
        factors: Of the tangent at an equilibrium.
        work: Workspace; factors of a problem in it are lost.
        signs: Result, (3,): index with the motors locked, with the motors free, and the sign of the
            determinant of the inverse problem (0 where there is no such problem). The first entry is
            SINGULAR_LEG, and nothing else is set, where the legs were not condensed.
    """
    if factors.how[0] == DENSE:
        signs[0] = SINGULAR_LEG
        return
    inner, platform = robot.platform_index, robot.slots.platform_count
    inverse_columns, angles = robot.inverse_unknowns, robot.controls_angles == 1
    below = 0
    for number in range(robot.groups.shape[0]):
        for slot in range(robot.slots.inner_count):
            for lane in range(robot.slot_index.shape[2]):
                if get(factors.inverse, (number, slot), lane) < 0.0:
                    below += 1
    left, square = work.symmetric, work.square
    border = left.shape[0]
    largest = _symmetric_part(factors.border, left)

    signs[2] = 0
    if inverse_columns.shape[0] == platform:
        rotation_unknowns(rotation, angles, work.motions)
        for i in range(platform):
            for j in range(platform):
                column = inverse_columns[j] - inner
                if angles and column < 3:
                    value = 0.0
                    for n in range(3):
                        value += left[i, n] * work.motions[n, column]
                    square[i, j] = value
                else:
                    square[i, j] = left[i, column]
        if lu_factor(square, platform, work.pivots, 0.0):
            sign = 1 if below % 2 == 0 else -1
            for i in range(platform):
                if (square[i, i] < 0.0) != (work.pivots[i] != i):
                    sign = -sign
            signs[2] = sign
    smallest = _SMALLEST_PIVOT * largest
    # Platform first: what it leaves tells the motors', if it is not about to lose its stability.
    locked, uncertain = eliminate(left, platform, _SAFE_PIVOT * largest)
    if uncertain == 0:
        free, _ = eliminate(left[platform:, platform:], border - platform, smallest)
        free += locked
    else:
        _symmetric_part(factors.border, left)
        for i in range(platform):
            for j in range(platform):
                square[i, j] = left[i, j]
        locked, _ = eliminate(square[:platform, :platform], platform, smallest)
        free, _ = eliminate(left, border, smallest)
    signs[0] = below + locked - robot.constraint_count
    signs[1] = below + free - robot.constraint_count


@kernel
def _symmetric_part(matrix, result):
    """Symmetric part of a square matrix; returns its largest entry."""
    largest = 0.0
    for i in range(matrix.shape[0]):
        for j in range(i + 1):
            value = 0.5 * (matrix[i, j] + matrix[j, i])
            result[i, j] = result[j, i] = value
            largest = max(largest, abs(value))
    return largest
