# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Linear solves with the tangent: all legs condensed at once onto platform and motors.

The tangent is block-arrow shaped: a leg touches its own block and the border (platform and its motor)
only, and both are symmetric. With ``S = L D L^T`` the block of a leg, B its coupling to the border and
H_0 what the border has of its own,

    H = H_0 - sum B^T S^-1 B,    H x_b = r_b - sum B^T S^-1 r,    x = S^-1 (r - B x_b).

Signs of D and of H are the stability indices (Sylvester's law), parts of H the kinemato-statics.
Elimination is in a fixed order, strain before multipliers, without exchanges. Where a pivot is too small
(a straight leg, a rod about to buckle on its own), all begins again, and slots with small pivots are
delayed: left to the border, beside platform and motors (`delayed_kernel`). All numbers here are
dimensionless.
"""

from __future__ import annotations

import math

import numpy as np

from .by_leg import PIVOT, PIVOT_INVERSE
from .delayed_kernel import (
    add_delayed,
    delay_small_pivots,
    gather_delayed,
    scale_of_strain,
    scatter_delayed,
)
from .kernel_decorators import inlined, part
from .lanes import absolute, broadcast, get, highest, load, lower, put, store, total
from .lu_kernel import lu_factor, lu_solve
from .twist_layout import FIRST_LINEAR

__all__ = [
    "CONDENSED",
    "DELAYED",
    "NO_INVERSE",
    "SMALLEST_LEG_PIVOT",
    "UNKNOWN",
    "condense",
    "condense_delaying",
    "expand_legs",
    "factor",
    "factor_border",
    "predict",
    "reduce_legs",
    "rotation_unknowns",
    "solve",
    "solve_inlined",
    "substitute_border",
]

#: How a tangent was factored: all legs condensed, some slots left to the border; or there is no inverse,
#: or nobody knows its factors.
CONDENSED, DELAYED, NO_INVERSE, UNKNOWN = 0, 1, 2, 3

#: Pivots below this fraction of the largest strain stiffness of a leg are not divided by.
SMALLEST_LEG_PIVOT = 1e-8
_SMALLEST_PIVOT = 1e-14


@inlined
def condense(robot, work, factors):
    """Eliminate the legs from the tangent in the workspace."""
    factors.status[0] = CONDENSED
    factors.delayed_count[0] = 0
    _begin_border(robot, work.platform_tangent, factors.border)
    regular = True
    for number in range(robot.groups.shape[0]):
        regular = _eliminate(robot, number, False, work, factors) and regular
        _add_border(robot, number, work, factors)
    if not regular:
        condense_delaying(robot, work, factors)


@part
def condense_delaying(robot, work, factors):
    """The same where some pivots are too small; apart, for what is called often has to be short."""
    factors.status[0] = DELAYED
    factors.delayed_count[0] = 0
    _begin_border(robot, work.platform_tangent, factors.border)
    inner, count = robot.platform_index, robot.border_indices.shape[0]
    for number in range(robot.groups.shape[0]):
        _eliminate(robot, number, True, work, factors)
        _add_border(robot, number, work, factors)
        motors = robot.motor_slot_index[number]
        add_delayed(robot.slots, motors, inner, count, number, work.rows, factors)


@inlined
def _begin_border(robot, platform_tangent, border):
    """What the platform has of its own; nothing else."""
    unit, inner, axes = robot.unit, robot.platform_index, robot.platform_axes
    per_energy, count = 1.0 / robot.energy_unit, robot.border_indices.shape[0]
    for i in range(count):
        for j in range(count):
            border[i, j] = 0.0
    for i in range(axes.shape[0]):
        for j in range(axes.shape[0]):
            value = platform_tangent[axes[i], axes[j]]
            border[i, j] = value * per_energy * unit[inner + i] * unit[inner + j]


@inlined
def _eliminate(robot, number, delaying, work, factors):
    """Factor the blocks of a group, delaying or not; whether no pivot was too small."""
    blocks, units, upper, rows = work.blocks, robot.units, factors.upper, work.rows
    slots = robot.slots
    inner, last, per_energy = slots.inner_count, slots.first_motor, 1.0 / robot.energy_unit
    largest = broadcast(units, 0.0)
    smallest = broadcast(units, np.inf)
    first = slots.first_coupled  # entries of the platform before stay zero
    if delaying:
        scale_of_strain(
            robot.units, work.blocks, number, slots.strain_count, per_energy, work.by_leg
        )
    for i in range(inner):
        scale = per_energy * load(units, (number, i))
        diagonal = scale * load(units, (number, i)) * load(blocks, (number, i, i))
        diagonal += load(robot.missing, (number, i))
        other = broadcast(units, 0.0)
        for k in range(1, i, 2):
            diagonal -= load(upper, (number, k - 1, i)) * load(rows, (k - 1, i))
            other -= load(upper, (number, k, i)) * load(rows, (k, i))
        if i % 2 == 1:
            diagonal -= load(upper, (number, i - 1, i)) * load(rows, (i - 1, i))
        diagonal += other
        inverse = 1.0 / diagonal
        if i < slots.strain_count:
            largest = -lower(-largest, -absolute(diagonal))
        smallest = lower(smallest, absolute(diagonal))
        store(factors.inverse, (number, i), inverse)
        if delaying:
            store(work.by_leg, PIVOT, diagonal)
            index, is_strain = robot.slot_index[number, i], i < slots.strain_count
            delay_small_pivots(
                index, is_strain, number, i, robot.border_indices.shape[0], work.by_leg, factors
            )
            inverse = load(work.by_leg, PIVOT_INVERSE)
        _eliminate_row(robot, number, i, 0, i + 1, inner, scale, inverse, work, factors)
        if i >= first:
            _eliminate_row(robot, number, i, first, inner, last, scale, inverse, work, factors)
        _eliminate_row(robot, number, i, 0, last, slots.total, scale, inverse, work, factors)
    return highest(SMALLEST_LEG_PIVOT * largest - smallest) < 0.0


@inlined
def _eliminate_row(robot, number, i, first, start, end, scale, inverse, work, factors):
    """Columns of row i, less what rows from ``first`` on have to do with them.

    The innermost loop of every solve: what it needs is handed on as numbers, ten of them.
    """
    blocks, units, upper, rows = work.blocks, robot.units, factors.upper, work.rows
    j = start
    while j + 4 <= end:
        v0 = scale * load(units, (number, j)) * load(blocks, (number, i, j))
        v1 = scale * load(units, (number, j + 1)) * load(blocks, (number, i, j + 1))
        v2 = scale * load(units, (number, j + 2)) * load(blocks, (number, i, j + 2))
        v3 = scale * load(units, (number, j + 3)) * load(blocks, (number, i, j + 3))
        for k in range(first, i):
            multiple = load(upper, (number, k, i))
            v0 -= multiple * load(rows, (k, j))
            v1 -= multiple * load(rows, (k, j + 1))
            v2 -= multiple * load(rows, (k, j + 2))
            v3 -= multiple * load(rows, (k, j + 3))
        store(rows, (i, j), v0)
        store(rows, (i, j + 1), v1)
        store(rows, (i, j + 2), v2)
        store(rows, (i, j + 3), v3)
        store(upper, (number, i, j), inverse * v0)
        store(upper, (number, i, j + 1), inverse * v1)
        store(upper, (number, i, j + 2), inverse * v2)
        store(upper, (number, i, j + 3), inverse * v3)
        j += 4
    while j < end:
        value = scale * load(units, (number, j)) * load(blocks, (number, i, j))
        for k in range(first, i):
            value -= load(upper, (number, k, i)) * load(rows, (k, j))
        store(rows, (i, j), value)
        store(upper, (number, i, j), inverse * value)
        j += 1


@inlined
def _add_border(robot, number, work, factors):
    """Add what is left of a group to the border."""
    border, upper, rows = factors.border, factors.upper, work.rows
    inner, first = robot.slots.inner_count, robot.slots.first_coupled
    platform, first_motor = robot.slots.platform_count, robot.slots.first_motor
    motors = robot.motor_slot_index[number]
    for i in range(platform):
        for j in range(i, platform):
            value = broadcast(robot.units, 0.0)
            for k in range(first, inner):
                value -= load(upper, (number, k, inner + i)) * load(rows, (k, inner + j))
            sum_of_legs = total(value)
            border[i, j] += sum_of_legs
            if i != j:
                border[j, i] += sum_of_legs
    for m in range(robot.slots.motor_count):
        column = first_motor + m
        scale = load(robot.units, (number, column)) * (1.0 / robot.energy_unit)
        for row in range(inner, column + 1):
            value = load(robot.units, (number, row)) * load(work.blocks, (number, row, column))
            value *= scale
            for k in range(first if row < first_motor else 0, inner):
                value -= load(upper, (number, k, row)) * load(rows, (k, column))
            store(work.motor_values, m, value)
            for lane in range(motors.shape[1]):
                if motors[m, lane] < 0:
                    continue
                at = motors[m, lane] - robot.platform_index
                other = row - inner
                if row >= first_motor:
                    other = motors[row - first_motor, lane] - robot.platform_index
                entry = get(work.motor_values, m, lane)
                border[at, other] += entry
                if row != column:  # one motor in both slots: twice on the diagonal
                    border[other, at] += entry


@part
def factor(robot, rotation, problem, work, factors):
    """Factor the tangent of a square problem, from the slots in the workspace.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation, (3, 3).
        problem: SquareProblem.
        work: Workspace.
        factors: Result.

    Returns:
        CONDENSED or DELAYED, how it was done, or NO_INVERSE.
    """
    condense(robot, work, factors)
    regular = factor_border(robot, rotation, problem, work, factors)
    return factors.status[0] if regular else NO_INVERSE


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


@part
def solve(robot, problem, vector, work, factors):
    """Solve in place: legs first, border last, in the order of the equations and the unknowns."""
    solve_inlined(robot, problem, vector, work, factors)


@inlined
def solve_inlined(robot, problem, vector, work, factors):
    """``solve`` as a part of what calls it."""
    border, count = work.border, robot.border_indices.shape[0]
    for i in range(count):
        border[i] = 0.0
    for i in range(problem.equations.shape[0]):
        border[problem.equations[i] - robot.platform_index] = vector[robot.platform_index + i]
    reduce_legs(robot, vector, work, factors)
    expand_legs(robot, problem, vector, work, factors)


@inlined
def reduce_legs(robot, vector, work, factors):
    """First half of a solve: the right side of the border, in the workspace, gets that of the legs."""
    for number in range(robot.groups.shape[0]):
        _forward(robot, number, vector, work, factors)
    gather_delayed(robot.slots, robot.border_indices.shape[0], work.solution, work.border, factors)


@inlined
def expand_legs(robot, problem, vector, work, factors):
    """Second half: the unknowns into the vector; twist, motors and delayed slots into the workspace."""
    _solve_border(robot, problem, vector, work, factors)
    substitute_border(robot, vector, work, factors)


@inlined
def substitute_border(robot, vector, work, factors):
    """Unknowns of the legs into the vector, from those of border and delayed slots in the workspace."""
    scatter_delayed(robot.slots, robot.border_indices.shape[0], work.solution, work.border, factors)
    for number in range(robot.groups.shape[0]):
        _backward(robot, number, vector, work, factors)


@part
def predict(robot, rotation, problem, known, efforts, vector, work, factors):
    """Change of the unknowns, to first order, with what is imposed.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation at the start of the change, (3, 3).
        problem: SquareProblem.
        known: Imposed change of the border, world twist and motors, dimensionless; zero where unknown.
        efforts: Imposed change of the efforts, dimensionless, (motors,).
        vector: Result, legs first.
        work: Workspace.
        factors: Of the tangent at the start of the change.

    Returns:
        Whether the problem has an inverse there.
    """
    if not factor_border(robot, rotation, problem, work, factors):
        return False
    border, count = work.border, robot.border_indices.shape[0]
    first_effort = count - efforts.shape[0]
    for i in range(count + factors.delayed_count[0]):
        value = efforts[i - first_effort] if first_effort <= i < count else 0.0
        for j in range(count):
            value -= factors.border[i, j] * known[j]
        border[i] = value
    zero = broadcast(work.solution, 0.0)
    for number in range(robot.groups.shape[0]):
        for slot in range(robot.slots.inner_count):
            store(work.solution, (number, slot), zero)
    _solve_border(robot, problem, vector, work, factors)
    for i in range(count):
        border[i] += known[i]
    substitute_border(robot, vector, work, factors)
    return True


@inlined
def _forward(robot, number, vector, work, factors):
    """``L^-1 r`` of a group into the workspace, and what it does to the border."""
    index, upper, solution = robot.slot_index[number], factors.upper, work.solution
    slots = robot.slots
    inner, first, first_motor = slots.inner_count, slots.first_coupled, slots.first_motor
    motors = robot.motor_slot_index[number]
    for slot in range(inner):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            put(solution, (number, slot), lane, vector[i] if i >= 0 else 0.0)
    for i in range(1, inner):
        value = load(solution, (number, i))
        for k in range(i):
            value -= load(upper, (number, k, i)) * load(solution, (number, k))
        store(solution, (number, i), value)
    for j in range(inner, robot.slots.total):
        value = broadcast(solution, 0.0)
        for k in range(first if j < first_motor else 0, inner):
            value -= load(upper, (number, k, j)) * load(solution, (number, k))
        if j < first_motor:
            work.border[j - inner] += total(value)
        else:
            m = j - first_motor
            store(work.motor_values, m, value)
            for lane in range(motors.shape[1]):
                if motors[m, lane] >= 0:
                    at = motors[m, lane] - robot.platform_index
                    work.border[at] += get(work.motor_values, m, lane)


@inlined
def _solve_border(robot, problem, vector, work, factors):
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


@inlined
def _backward(robot, number, vector, work, factors):
    """``L^-T (D^-1 y - ...)`` of a group, into the vector."""
    index, upper, solution = robot.slot_index[number], factors.upper, work.solution
    slots = robot.slots
    inner, first, first_motor = slots.inner_count, slots.first_coupled, slots.first_motor
    motors = robot.motor_slot_index[number]
    for m in range(motors.shape[0]):
        for lane in range(motors.shape[1]):
            at = motors[m, lane] - robot.platform_index
            put(work.motor_values, m, lane, work.border[at] if motors[m, lane] >= 0 else 0.0)
    for i in range(inner - 1, -1, -1):
        value = load(factors.inverse, (number, i)) * load(solution, (number, i))
        for m in range(motors.shape[0]):
            value -= load(upper, (number, i, first_motor + m)) * load(work.motor_values, m)
        for j in range(i + 1, inner):
            value -= load(upper, (number, i, j)) * load(solution, (number, j))
        if i >= first:
            for j in range(inner, first_motor):
                value -= load(upper, (number, i, j)) * work.border[j - inner]
        store(solution, (number, i), value)
    for slot in range(inner):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            if i >= 0:
                vector[i] = get(solution, (number, slot), lane)
