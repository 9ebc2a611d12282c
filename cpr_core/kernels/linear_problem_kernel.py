# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Solving the linear problems of Section V-C, efforts among the unknowns, with the condensed legs.

With F the Newton matrix of a square problem whose motor rows are no equations, and R these motor rows,

    M = [F 0; R -1],    M x = b,    M^T y = c.

The efforts need no rows of the whole tangent. With ``B_m`` the coupling of the legs to the motors and
``H_m`` the motor rows of the condensed border,

    R x = B_m^T S^-1 r + H_m x_b,

whose first part is what the legs leave of right side at the motors; and ``R^T p`` on the right side of
F^T is what the border does with ``p`` given in it at the motors.
"""

from __future__ import annotations

from .kernel_decorators import inlined
from .lu_kernel import lu_solve_transposed
from .tangent_kernel import expand_legs, reduce_legs, substitute_border
from .twist_layout import FIRST_LINEAR

__all__ = ["solve_with_efforts", "solve_with_efforts_transposed"]


@inlined
def solve_with_efforts(robot, problem, vector, work, factors):
    """Solve ``M x = b`` in place.

    Args:
        robot: RobotArrays.
        problem: SquareProblem without motors among its equations, factored (``factor_border``).
        vector: Right side in the order of the equations, then of the motors; on return unknowns, then
            efforts, all dimensionless.
        work: Workspace.
        factors: Factors.
    """
    inner, border, own = robot.platform_index, work.border, problem.equations.shape[0]
    count, first = robot.border_indices.shape[0], robot.motor_index - robot.platform_index
    size = inner + own
    for i in range(count):
        border[i] = 0.0
    for i in range(own):
        border[problem.equations[i] - inner] = vector[inner + i]
    reduce_legs(robot, vector, work, factors)
    for i in range(count - first):
        vector[size + i] = -vector[size + i] - border[first + i]
    expand_legs(robot, problem, vector, work, factors)
    for i in range(count - first):
        row, total = factors.border[first + i], 0.0
        for j in range(count + factors.delayed_count[0]):
            total += row[j] * border[j]
        vector[size + i] += total


@inlined
def solve_with_efforts_transposed(robot, problem, vector, work, factors):
    """Solve ``M^T y = c`` in place.

    Args:
        robot: RobotArrays.
        problem: SquareProblem without motors among its equations, factored (``factor_border``).
        vector: Right side in the order of the unknowns, then of the efforts; on return as many numbers
            as equations, then as motors, all dimensionless.
        work: Workspace.
        factors: Factors.
    """
    inner, border, chosen = robot.platform_index, work.border, work.part
    equations, unknowns, angles = problem.equations, problem.unknowns, problem.angles
    count, own, delayed = (
        robot.border_indices.shape[0],
        equations.shape[0],
        factors.delayed_count[0],
    )
    first, size = robot.motor_index - inner, inner + own
    for i in range(count):
        border[i] = 0.0
    reduce_legs(robot, vector, work, factors)
    for m in range(count - first):
        pushed, row = -vector[size + m], factors.border[first + m]
        vector[size + m] = pushed
        for j in range(count + delayed):
            border[j] -= row[j] * pushed
    for i in range(own):
        column = unknowns[i] - inner
        value = vector[inner + i]
        if angles and column < FIRST_LINEAR:
            for n in range(3):
                value += work.motions[n, column] * border[n]
        else:
            value += border[column]
        chosen[i] = value
    for i in range(delayed):
        chosen[own + i] = border[count + i]
    lu_solve_transposed(work.square, own + delayed, work.pivots, chosen)
    for i in range(count):
        border[i] = vector[size + i - first] if i >= first else 0.0
    for i in range(own):
        border[equations[i] - inner] = vector[inner + i] = chosen[i]
    for i in range(delayed):
        border[count + i] = chosen[own + i]
    substitute_border(robot, vector, work, factors)
