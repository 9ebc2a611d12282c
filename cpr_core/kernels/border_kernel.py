# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is left when the legs are condensed: platform, motors and delayed slots.

A square problem has some equations and some unknowns of them; where angles are imposed, the rates of
roll, pitch and yaw are unknowns in place of the world rotation.
"""

from __future__ import annotations

import math

from .kernel_decorators import inlined, part
from .lu_kernel import lu_factor, lu_solve
from .twist_layout import FIRST_LINEAR

__all__ = ["factor_border", "rotation_unknowns", "solve_border"]

_SMALLEST_PIVOT = 1e-14


@inlined
def factor_border(robot, rotation, problem, work, factors):
    """Factor the part of the border a problem has, into the workspace; whether it has an inverse."""
    rotation_unknowns(rotation, problem.angles, work.motions)
    inner, border, square = robot.platform_index, factors.border, work.square
    equations, unknowns, angles = problem.equations, problem.unknowns, problem.angles
    count, own = robot.border_indices.shape[0], equations.shape[0]
    size = own + factors.delayed_count[0]
    for i in range(size):
        row = equations[i] - inner if i < own else count + i - own
        for j in range(own):
            column = unknowns[j] - inner
            if angles and column < FIRST_LINEAR:
                value = 0.0
                for n in range(3):
                    value += border[row, n] * work.motions[n, column]
                square[i, j] = value
            else:
                square[i, j] = border[row, column]
        for j in range(own, size):
            square[i, j] = border[row, count + j - own]
    return lu_factor(square, size, work.pivots, _SMALLEST_PIVOT)


@part
def rotation_unknowns(rotation, angles, motions):
    """World rotations of the rotation unknowns, (3, 3): themselves, or roll, pitch and yaw rates."""
    for i in range(3):
        for j in range(3):
            motions[i, j] = 1.0 if i == j else 0.0
    if angles:
        yaw = math.atan2(rotation[1, 0], rotation[0, 0])
        for i in range(3):
            motions[i, 0] = rotation[i, 0]
        motions[0, 1], motions[1, 1] = -math.sin(yaw), math.cos(yaw)


@inlined
def solve_border(robot, problem, vector, work, factors):
    """Unknowns of the border, into the vector; twist, motors and delayed slots into the workspace."""
    inner, border, part, motions = robot.platform_index, work.border, work.part, work.motions
    equations, unknowns, angles = problem.equations, problem.unknowns, problem.angles
    count, own, delayed = (
        robot.border_indices.shape[0],
        equations.shape[0],
        factors.delayed_count[0],
    )
    for i in range(own):
        part[i] = border[equations[i] - inner]
    for i in range(delayed):
        part[own + i] = border[count + i]
    lu_solve(work.square, own + delayed, work.pivots, part)
    for i in range(count):
        border[i] = 0.0
    for i in range(own):
        vector[inner + i] = part[i]
        column = unknowns[i] - inner
        if angles and column < FIRST_LINEAR:
            for n in range(3):
                border[n] += motions[n, column] * part[i]
        else:
            border[column] = part[i]
    for i in range(delayed):
        border[count + i] = part[own + i]
