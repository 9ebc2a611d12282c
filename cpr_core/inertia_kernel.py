"""Signs of the tangent: how many directions lose energy, without eigenvalues.

Sylvester's law: any symmetric elimination of a matrix shows its number of negative eigenvalues. The
legs are eliminated one by one onto the border (platform and motors); what is left of the border tells
the stability index for both readings of the motors, and on which side of an inverse singularity the
robot is. With n_Psi constraints of full rank, the bordered Hessian has n_Psi negative eigenvalues more
than H_r of Eq. (48).
"""

from __future__ import annotations

import numpy as np

from .compiled import compiled
from .condensation_kernel import lu_factor

__all__ = ["SINGULAR_LEG", "eliminate", "signs_of"]

#: Returned in place of a count where a leg block has no inverse (a straight leg under no force).
SINGULAR_LEG = -1

#: Pivots below this fraction of the largest entry of a matrix count as zero.
_SMALLEST_PIVOT = 1e-11
#: The same for a leg block, which has to be inverted.
_SMALLEST_LEG_PIVOT = 1e-9
_GROWTH = (1.0 + np.sqrt(17.0)) / 8.0


@compiled
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


@compiled
def _exchange(matrix, one, two):
    """Exchange two rows and the same columns."""
    if one == two:
        return
    for j in range(matrix.shape[0]):
        matrix[one, j], matrix[two, j] = matrix[two, j], matrix[one, j]
    for i in range(matrix.shape[0]):
        matrix[i, one], matrix[i, two] = matrix[i, two], matrix[i, one]


@compiled
def signs_of(robot, tangent, inverse_columns, signs):
    """Count negative directions and find the sign of the inverse problem's determinant.

    Args:
        robot: RobotArrays.
        tangent: Tangent of the model at an equilibrium, (N, N); its symmetric part is read.
        inverse_columns: State indices of the unknowns of the inverse problem; none where there is none.
        signs: Result, (3,): index with the motors locked, with the motors free, and the sign of the
            determinant of the inverse problem (0 where there is no such problem). The first entry is
            SINGULAR_LEG, and nothing else is set, where a leg block has no inverse.
    """
    unit, per_energy = robot.unit, 1.0 / robot.energy_unit
    inner, size = robot.platform_index, tangent.shape[0]
    border = size - inner
    platform = robot.platform_axes.shape[0]
    left = np.zeros((border, border))
    for i in range(border):
        for j in range(i + 1):
            value = 0.5 * (tangent[inner + i, inner + j] + tangent[inner + j, inner + i])
            left[i, j] = left[j, i] = per_energy * value * unit[inner + i] * unit[inner + j]
    below, constraints = 0, 0
    for number in range(robot.legs.shape[0]):
        leg = robot.legs[number]
        held = robot.position_axes.shape[0] + leg.orientation_count
        last = leg.multiplier_index + held
        first = 0
        if number > 0:
            before = robot.legs[number - 1]
            first = (
                before.multiplier_index + robot.position_axes.shape[0] + before.orientation_count
            )
        count = last - first
        block = np.zeros((count + border, count + border))
        largest = 0.0
        for i in range(count):
            for j in range(i + 1):
                value = 0.5 * (tangent[first + i, first + j] + tangent[first + j, first + i])
                value *= per_energy * unit[first + i] * unit[first + j]
                block[i, j] = block[j, i] = value
                largest = max(largest, abs(value))
            for j in range(border):
                value = 0.5 * (tangent[first + i, inner + j] + tangent[inner + j, first + i])
                value *= per_energy * unit[first + i] * unit[inner + j]
                block[i, count + j] = block[count + j, i] = value
        negative, zero = eliminate(block, count, _SMALLEST_LEG_PIVOT * largest)
        if zero > 0:
            signs[0] = SINGULAR_LEG
            return
        below += negative
        constraints += held
        for i in range(border):
            for j in range(border):
                left[i, j] += block[count + i, count + j]
    largest = 0.0
    for i in range(border):
        for j in range(border):
            largest = max(largest, abs(left[i, j]))

    signs[2] = 0
    if inverse_columns.shape[0] == platform:
        square, pivots = np.empty((platform, platform)), np.empty(platform, np.int64)
        for i in range(platform):
            for j in range(platform):
                square[i, j] = left[i, inverse_columns[j] - inner]
        if lu_factor(square, platform, pivots, 0.0):
            sign = 1 if below % 2 == 0 else -1
            for i in range(platform):
                if (square[i, i] < 0.0) != (pivots[i] != i):
                    sign = -sign
            signs[2] = sign
    # Platform first: what it leaves tells the motors'.
    locked, _ = eliminate(left[:platform, :platform].copy(), platform, _SMALLEST_PIVOT * largest)
    free, _ = eliminate(left, border, _SMALLEST_PIVOT * largest)
    signs[0] = below + locked - constraints
    signs[1] = below + free - constraints
