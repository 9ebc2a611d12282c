# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Signs of the tangent: how many directions lose energy, without eigenvalues.

Sylvester's law: any symmetric elimination of a matrix shows its number of negative eigenvalues. The
solver has eliminated the legs onto the border (platform, motors, delayed slots); what is left there
tells the stability index for both readings of the motors, and on which side of an inverse singularity
the robot is. With n_Psi constraints of full rank, the bordered Hessian has n_Psi negative eigenvalues
more than H_r of Eq. (48).
"""

from __future__ import annotations

import numpy as np

from .border_kernel import rotation_unknowns
from .condensation_kernel import CONDENSED, condense_delaying
from .kernel_decorators import inlined, kernel, part
from .lanes import get
from .lu_kernel import lu_factor, lu_sign
from .record_layout import INDEX_FREE, INDEX_LOCKED, INVERSE_SIGN
from .twist_layout import FIRST_LINEAR

__all__ = ["eliminate", "signs_of"]

#: Pivots below this fraction of the largest entry of a matrix count as zero.
_SMALLEST_PIVOT = 1e-11
#: Above this fraction pivots leave a remainder whose signs can be trusted.
_SAFE_PIVOT = 1e-5
#: Larger entries of the border (a leg nearly straight) would hide signs of others: slots are delayed.
_LARGEST_BORDER = 1e5
#: Part of the largest off-diagonal entry above which a diagonal one is the pivot (Bunch and Parlett).
_GROWTH = (1.0 + np.sqrt(17.0)) / 8.0


@kernel
def eliminate(matrix, first, last, size, smallest):
    """Symmetric elimination with complete pivoting (Bunch and Parlett), in place.

    Args:
        matrix: Symmetric; what remains from ``last`` on is the Schur complement.
        first: First row and column to eliminate; those before are not touched.
        last: The one behind the last.
        size: Rows and columns that are read.
        smallest: Pivots not above this count as zero.

    Returns:
        Number of negative pivots and of pivots that are zero.
    """
    negative = 0
    while first < last:
        on_diagonal, anywhere, d, p, q = -1.0, -1.0, first, first, first
        for i in range(first, last):
            value = abs(matrix[i, i])
            if value > on_diagonal:
                on_diagonal, d = value, i
            for j in range(first, i):
                value = abs(matrix[i, j])
                if value > anywhere:
                    anywhere, p, q = value, i, j
        if max(on_diagonal, anywhere) <= smallest:
            return negative, last - first
        if on_diagonal >= _GROWTH * anywhere:
            _exchange(matrix, size, first, d)
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
            _exchange(matrix, size, first, q)
            _exchange(matrix, size, first + 1, p)
            a, b, c = matrix[first, first], matrix[first + 1, first], matrix[first + 1, first + 1]
            determinant = a * c - b * b  # negative: one pivot of either sign
            negative += 1
            for i in range(first + 2, size):
                u, v = matrix[i, first], matrix[i, first + 1]
                if u != 0.0 or v != 0.0:
                    by_first = (c * u - b * v) / determinant
                    by_second = (a * v - b * u) / determinant
                    for j in range(first + 2, size):
                        matrix[i, j] -= (
                            by_first * matrix[first, j] + by_second * matrix[first + 1, j]
                        )
            first += 2
    return negative, 0


@part
def _exchange(matrix, size, first, second):
    """Exchange two rows and the same columns."""
    if first == second:
        return
    for j in range(size):
        matrix[first, j], matrix[second, j] = matrix[second, j], matrix[first, j]
    for i in range(size):
        matrix[i, first], matrix[i, second] = matrix[i, second], matrix[i, first]


@inlined
def signs_of(robot, rotation, work, signs):
    """Count negative directions and find the sign of the inverse problem's determinant.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation, (3, 3).
        work: Workspace with the tangent at an equilibrium and its factors; those of a problem are lost.
        signs: Result, (3,), see `record_layout`; the last one is 0 where there is no inverse problem.
    """
    factors, left, square = work.factors, work.symmetric, work.square
    largest = _symmetric_border(robot, factors, left)
    if factors.status[0] == CONDENSED and not largest < _LARGEST_BORDER:
        condense_delaying(robot, work, work.delaying)
        factors = work.delaying
        largest = _symmetric_border(robot, factors, left)
    platform, below = robot.slots.platform_count, 0
    for number in range(robot.groups.shape[0]):
        for slot in range(robot.slots.inner_count):
            for lane in range(robot.slot_index.shape[2]):
                if get(factors.inverse, (number, slot), lane) < 0.0:
                    below += 1
    delayed = factors.delayed_count[0]
    size = delayed + robot.border_indices.shape[0]
    first = delayed + platform  # the motors
    signs[INVERSE_SIGN] = 0
    if robot.inverse_unknowns.shape[0] == platform:
        signs[INVERSE_SIGN] = _inverse_sign(robot, rotation, factors, below, work)
    smallest = _SMALLEST_PIVOT * largest
    # Platform first: what it leaves tells the motors', if it is not about to lose its stability.
    begin = 0 * size  # a constant would be compiled for on its own
    locked, uncertain = eliminate(left, begin, first, size, _SAFE_PIVOT * largest)
    if uncertain == 0:
        free, _ = eliminate(left, first, size, size, smallest)
        free += locked
    else:
        _symmetric_border(robot, factors, left)
        for i in range(first):
            for j in range(first):
                square[i, j] = left[i, j]
        locked, _ = eliminate(square, begin, first, first, smallest)
        free, _ = eliminate(left, begin, size, size, smallest)
    signs[INDEX_LOCKED] = below + locked - robot.constraint_count
    signs[INDEX_FREE] = below + free - robot.constraint_count


@inlined
def _inverse_sign(robot, rotation, factors, below, work):
    """Sign of the inverse problem's determinant; 0 where there is none.

    Of the tangent as it is: under loads without a potential the border is not symmetric.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation, (3, 3).
        factors: Factors of the tangent, delayed slots behind platform and motors.
        below: Number of negative pivots of the legs.
        work: Workspace.
    """
    matrix, square, delayed = factors.border, work.square, factors.delayed_count[0]
    inner, count = robot.platform_index, robot.border_indices.shape[0]
    size = delayed + robot.slots.platform_count
    inverse_unknowns, angles = robot.inverse_unknowns, robot.controls_angles == 1
    rotation_unknowns(rotation, angles, work.motions)
    for i in range(size):
        row = count + i if i < delayed else i - delayed
        for j in range(delayed):
            square[i, j] = matrix[row, count + j]
        for j in range(delayed, size):
            column = inverse_unknowns[j - delayed] - inner
            if angles and column < FIRST_LINEAR:
                value = 0.0
                for n in range(3):
                    value += matrix[row, n] * work.motions[n, column]
                square[i, j] = value
            else:
                square[i, j] = matrix[row, column]
    if not lu_factor(square, size, work.pivots, 0.0):
        return 0
    sign = lu_sign(square, size, work.pivots)
    return sign if below % 2 == 0 else -sign


@part
def _symmetric_border(robot, factors, result):
    """Symmetric part of the border, delayed slots before the platform; returns its largest entry."""
    matrix, count, delayed = factors.border, robot.border_indices.shape[0], factors.delayed_count[0]
    largest = 0.0
    for i in range(delayed + count):
        row = count + i if i < delayed else i - delayed
        for j in range(min(i + 1, delayed)):
            result[i, j] = result[j, i] = matrix[row, count + j]  # these are symmetric
            largest = max(largest, abs(result[i, j]))
        for j in range(delayed, i + 1):
            value = 0.5 * (matrix[row, j - delayed] + matrix[j - delayed, row])
            result[i, j] = result[j, i] = value
            largest = max(largest, abs(value))
    return largest
