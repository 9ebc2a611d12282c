# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Smallest singular value of a linear problem of Section V-C, from the condensed tangent.

It is one over the largest of the inverse, by Lanczos' method. The matrix M = [Z^T K_x, ..., J_x] needs
no basis Z: M x = b and M^T y = c are solved with the Newton matrix F of the geometrico-static problem,
condensed leg by leg, and with its transpose (`linear_problem_kernel`). In other units than the natural
ones rows and columns of F are scaled, those of the strains of a rod with its gram matrix; what that
changes of Z the multipliers bear, which are no unknowns of M.
"""

from __future__ import annotations

import math

from .border_kernel import factor_border
from .eigenvalue_kernel import largest_of_tridiagonal, last_entry
from .kernel_decorators import inlined, strict_part
from .linear_problem_kernel import solve_with_efforts, solve_with_efforts_transposed
from .workspace_arrays import LANCZOS_STEPS

__all__ = ["smallest_singular_value"]

#: Lanczos' method is done where an eigenvalue is within this part of what it has found.
_LANCZOS_PRECISION = 1e-7
#: Step of the first look at the result.
_FIRST_LOOK = 2
#: A vector shorter than this fraction of a Ritz value has nothing new.
_NOTHING_NEW = 1e-14
#: A vector that gets shorter than this part of itself is made orthogonal twice (Kahan).
_CANCELLED = 0.1
#: Relative error of the largest Ritz value.
_RITZ_PRECISION = 1e-10


@strict_part
def smallest_singular_value(robot, square, scales, rotation, work, factors):
    """Smallest singular value of a linear problem, dimensionless.

    Args:
        robot: RobotArrays.
        square: SquareProblem of the forward or the inverse problem.
        scales: ProblemScales: its units.
        rotation: Platform rotation at an equilibrium.
        work: Workspace.
        factors: Of the tangent there.

    Returns:
        The value; 0 where the problem has no inverse, or Lanczos' method wants more steps.
    """
    if not factor_border(robot, rotation, square, work, factors):
        return 0.0
    size = robot.platform_index + square.unknowns.shape[0]
    motors = robot.unit.shape[0] - robot.motor_index
    basis, vector = work.lanczos, work.linear_unknowns[: size + motors]
    diagonal, beside = work.lanczos_diagonal, work.lanczos_beside
    for i in range(size):  # zero where a multiplier is, which is no unknown of the linear problem
        vector[i] = 0.0 if scales.unknowns[i] == 0.0 else 1.0 + 0.5 * math.sin(1.7 * i + 0.3)
    for i in range(motors):
        vector[size + i] = 1.0 + 0.5 * math.cos(1.3 * i)
    length = _length(vector)
    for step in range(LANCZOS_STEPS):
        for i in range(size + motors):
            basis[step, i] = vector[i] / length
            vector[i] = basis[step, i]
        _apply_inverse_square(robot, square, scales, vector, work, factors)
        total = 0.0
        for i in range(size + motors):
            total += vector[i] * basis[step, i]
        diagonal[step] = total
        whole = _length(vector)
        _orthogonalise(basis, step + 1, vector)
        length = _length(vector)
        if length < _CANCELLED * whole:  # else what is left is partly rounding along them
            _orthogonalise(basis, step + 1, vector)
            length = _length(vector)
        beside[step] = length
        last = step + 1 == size + motors or length <= _NOTHING_NEW * diagonal[step]
        if not last and step < _FIRST_LOOK:
            continue
        largest = largest_of_tridiagonal(diagonal, beside, step + 1, _RITZ_PRECISION)
        away = 0.0 if last else length * last_entry(diagonal, beside, step + 1, largest)
        if largest > 0.0 and away <= _LANCZOS_PRECISION * largest:
            return 1.0 / math.sqrt(largest)
    return 0.0


@strict_part
def _orthogonalise(basis, count, vector):
    """Take the first vectors of a basis out of a vector, in place."""
    for k in range(count):
        known, total = basis[k], 0.0
        for i in range(vector.shape[0]):
            total += vector[i] * known[i]
        for i in range(vector.shape[0]):
            vector[i] -= total * known[i]


@strict_part
def _length(vector):
    total = 0.0
    for i in range(vector.shape[0]):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@inlined
def _apply_inverse_square(robot, square, scales, vector, work, factors):
    """Multiply by the inverse of M'^T M', in place; efforts are the last entries."""
    for i in range(vector.shape[0]):
        vector[i] *= scales.unknowns[i]
    _multiply_strains(scales, vector)
    solve_with_efforts_transposed(robot, square, vector, work, factors)
    _multiply_strains_transposed(scales, vector)
    for i in range(vector.shape[0]):
        vector[i] *= scales.squared_equations[i]
    _multiply_strains(scales, vector)
    solve_with_efforts(robot, square, vector, work, factors)
    _multiply_strains_transposed(scales, vector)
    for i in range(vector.shape[0]):
        vector[i] *= scales.unknowns[i]


@strict_part
def _multiply_strains(scales, vector):
    """Multiply the strains of every rod by its L, in place."""
    for rod in range(scales.first_strains.shape[0]):
        first, factor = scales.first_strains[rod], scales.gram_factors[rod]
        count = scales.strain_counts[rod]
        for i in range(count - 1, -1, -1):  # a row needs those above as they were
            total = 0.0
            for j in range(i + 1):
                total += factor[i, j] * vector[first + j]
            vector[first + i] = total


@strict_part
def _multiply_strains_transposed(scales, vector):
    """Multiply the strains of every rod by its L^T, in place."""
    for rod in range(scales.first_strains.shape[0]):
        first, factor = scales.first_strains[rod], scales.gram_factors[rod]
        count = scales.strain_counts[rod]
        for i in range(count):  # a row needs those below as they were
            total = 0.0
            for j in range(i, count):
                total += factor[j, i] * vector[first + j]
            vector[first + i] = total
