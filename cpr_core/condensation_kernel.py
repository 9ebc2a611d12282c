# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Linear solves with the tangent: all legs condensed at once onto platform and motors.

The tangent is block-arrow shaped: a leg touches its own block and the border (platform and its motor)
only, and both are symmetric. With ``S = L D L^T`` the block of a leg, B its coupling to the border and
H_0 what the border has of its own,

    H = H_0 - sum B^T S^-1 B,    H x_b = r_b - sum B^T S^-1 r,    x = S^-1 (r - B x_b).

Signs of D and of H are the stability indices (Sylvester's law), parts of H the kinemato-statics.
Elimination is in a fixed order, strain before multipliers, without exchanges: a pivot that is too small
(a straight leg, a rod about to buckle on its own) is refused, and the whole matrix is factored with
exchanges instead. All numbers here are dimensionless.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import inlined, kernel, part
from .lanes import absolute, broadcast, get, highest, load, lower, put, store, total
from .model_kernel import assemble

__all__ = [
    "CONDENSED",
    "DENSE",
    "NO_INVERSE",
    "condense",
    "factor",
    "factor_border",
    "factor_here",
    "keep",
    "lu_factor",
    "lu_solve",
    "lu_solve_transposed",
    "predict",
    "recall",
    "rotation_unknowns",
    "solve",
    "solve_here",
    "solve_transposed",
]

CONDENSED, DENSE, NO_INVERSE = 0, 1, 2

#: Pivots below this fraction of the largest strain stiffness of a leg are not divided by.
_SMALLEST_LEG_PIVOT = 1e-8
_SMALLEST_PIVOT = 1e-14


@inlined
def condense(robot, work, factors):
    """Eliminate the legs from the tangent in the workspace.

    Returns:
        Whether no pivot was too small.
    """
    border, unit, inner = factors.border, robot.unit, robot.platform_index
    per_energy = 1.0 / robot.energy_unit
    axes = robot.platform_axes
    for i in range(border.shape[0]):
        for j in range(border.shape[1]):
            border[i, j] = 0.0
    for i in range(axes.shape[0]):
        for j in range(axes.shape[0]):
            value = work.platform_tangent[axes[i], axes[j]]
            border[i, j] = value * per_energy * unit[inner + i] * unit[inner + j]
    regular = True
    for number in range(robot.groups.shape[0]):
        regular = _eliminate(robot, number, per_energy, work, factors) and regular
        _add_border(robot, number, per_energy, work, factors)
    return regular


@inlined
def _eliminate(robot, number, per_energy, work, factors):
    """Factor the blocks of a group; whether no pivot was too small."""
    blocks, units, upper, rows = work.blocks, robot.units, factors.upper, work.rows
    slots = robot.slots
    inner, last = slots.inner_count, slots.motor
    largest = broadcast(units, 0.0)
    smallest = broadcast(units, np.inf)
    first = slots.first_coupled  # entries of the platform before stay zero
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
        _eliminate_row(robot, number, i, 0, i + 1, inner, scale, inverse, work, factors)
        if i >= first:
            _eliminate_row(robot, number, i, first, inner, last, scale, inverse, work, factors)
        _eliminate_row(robot, number, i, 0, last, slots.total, scale, inverse, work, factors)
    return highest(_SMALLEST_LEG_PIVOT * largest - smallest) < 0.0


@inlined
def _eliminate_row(robot, number, i, first, start, end, scale, inverse, work, factors):
    """Columns of row i, less what rows from ``first`` on have to do with them."""
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
def _add_border(robot, number, per_energy, work, factors):
    """Add what is left of a group to the border."""
    border, upper, rows = factors.border, factors.upper, work.rows
    inner, last = robot.slots.inner_count, robot.slots.motor
    first, platform = robot.slots.first_coupled, robot.slots.platform_count
    motors = robot.groups[number].motor_index
    for i in range(platform):
        for j in range(i, platform):
            value = broadcast(robot.units, 0.0)
            for k in range(first, inner):
                value -= load(upper, (number, k, inner + i)) * load(rows, (k, inner + j))
            sum_of_legs = total(value)
            border[i, j] += sum_of_legs
            if i != j:
                border[j, i] += sum_of_legs
    scale = per_energy * load(robot.units, (number, last))
    for i in range(platform + 1):
        row = inner + i
        value = scale * load(robot.units, (number, row)) * load(work.blocks, (number, row, last))
        for k in range(first if i < platform else 0, inner):
            value -= load(upper, (number, k, row)) * load(rows, (k, last))
        store(work.by_leg, 0, value)
        for lane in range(motors.shape[0]):
            if motors[lane] >= 0:
                m = motors[lane] - robot.platform_index
                if i < platform:
                    border[i, m] = border[m, i] = get(work.by_leg, 0, lane)
                else:
                    border[m, m] = get(work.by_leg, 0, lane)


@kernel
def factor(robot, rotation, rows, columns, angles, work, factors):
    """Factor the tangent of a square problem, from the slots in the workspace.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation, (3, 3).
        rows: State indices of the equations beside those of the legs, (s,).
        columns: State indices of the unknowns beside those of the legs, (s,).
        angles: Whether the rotation unknowns are roll, pitch and yaw, not world rotations.
        work: Workspace.
        factors: Result.

    Returns:
        CONDENSED or DENSE, how it was done, or NO_INVERSE.
    """
    return factor_here(robot, rotation, rows, columns, angles, work, factors)


@inlined
def factor_here(robot, rotation, rows, columns, angles, work, factors):
    """``factor`` as a part of what calls it."""
    rotation_unknowns(rotation, angles, work.motions)
    if condense(robot, work, factors):
        factors.how[0] = CONDENSED
        regular = factor_border(robot, rows, columns, angles, work, factors)
        return CONDENSED if regular else NO_INVERSE
    factors.how[0] = DENSE
    _whole_problem(robot, rows, columns, angles, work)
    size = robot.platform_index + rows.shape[0]
    regular = lu_factor(work.whole, size, work.whole_pivots, _SMALLEST_PIVOT)
    return DENSE if regular else NO_INVERSE


@inlined
def factor_border(robot, rows, columns, angles, work, factors):
    """Factor the part of the border a problem has, into the workspace; whether it has an inverse."""
    inner, size, square = robot.platform_index, rows.shape[0], work.square
    for i in range(size):
        row = rows[i] - inner
        for j in range(size):
            column = columns[j] - inner
            if angles and column < 3:
                value = 0.0
                for n in range(3):
                    value += factors.border[row, n] * work.motions[n, column]
                square[i, j] = value
            else:
                square[i, j] = factors.border[row, column]
    return lu_factor(square, size, work.pivots, _SMALLEST_PIVOT)


@kernel
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
def _whole_problem(robot, rows, columns, angles, work):
    """The dimensionless matrix of a problem, into the workspace."""
    unit, per_energy = robot.unit, 1.0 / robot.energy_unit
    inner, size, whole, tangent = robot.platform_index, rows.shape[0], work.whole, work.tangent
    motions = work.motions
    assemble(robot, work, tangent)
    for i in range(inner + size):
        row = i if i < inner else rows[i - inner]
        for j in range(inner + size):
            column = j if j < inner else columns[j - inner]
            value = tangent[row, column]
            if angles and inner <= column < inner + 3:
                value = 0.0
                for n in range(3):
                    value += tangent[row, inner + n] * motions[n, column - inner]
            whole[i, j] = per_energy * unit[row] * value * unit[column]


@kernel
def solve(robot, rows, columns, angles, vector, work, factors):
    """Solve in place: legs first, border last, in the order of the equations and the unknowns."""
    solve_here(robot, rows, columns, angles, vector, work, factors)


@inlined
def solve_here(robot, rows, columns, angles, vector, work, factors):
    """``solve`` as a part of what calls it."""
    inner, size = robot.platform_index, rows.shape[0]
    if factors.how[0] == DENSE:
        lu_solve(work.whole, inner + size, work.whole_pivots, vector)
        return
    border = work.border
    for i in range(border.shape[0]):
        border[i] = 0.0
    for i in range(size):
        border[rows[i] - inner] = vector[inner + i]
    for number in range(robot.groups.shape[0]):
        _forward(robot, number, vector, work, factors)
    _solve_border(robot, rows, columns, angles, vector, work)
    for number in range(robot.groups.shape[0]):
        _backward(robot, number, vector, work, factors)


@kernel
def solve_transposed(robot, rows, columns, angles, vector, work, factors):
    """Solve with the transpose, in place: in the order of the unknowns and the equations."""
    inner, size, border = robot.platform_index, rows.shape[0], work.border
    if factors.how[0] == DENSE:
        lu_solve_transposed(work.whole, inner + size, work.whole_pivots, vector)
        return
    for i in range(border.shape[0]):
        border[i] = 0.0
    for number in range(robot.groups.shape[0]):
        _forward(robot, number, vector, work, factors)
    part = vector[inner:]
    for i in range(size):
        column = columns[i] - inner
        if angles and column < 3:
            for n in range(3):
                part[i] += work.motions[n, column] * border[n]
        else:
            part[i] += border[column]
    lu_solve_transposed(work.square, size, work.pivots, part)
    for i in range(border.shape[0]):
        border[i] = 0.0
    for i in range(size):
        border[rows[i] - inner] = part[i]
    for number in range(robot.groups.shape[0]):
        _backward(robot, number, vector, work, factors)


@kernel
def predict(robot, rows, columns, angles, known, efforts, vector, work, factors):
    """Change of the unknowns, to first order, with what is imposed.

    Args:
        robot: RobotArrays.
        rows: Equations beside those of the legs, (s,).
        columns: Unknowns beside those of the legs, (s,).
        angles: Whether the rotation unknowns are roll, pitch and yaw.
        known: Imposed change of the border, world twist and motors, dimensionless; zero where unknown.
        efforts: Imposed change of the efforts, dimensionless, (motors,).
        vector: Result, legs first.
        work: Workspace.
        factors: Of the tangent at the start of the change, CONDENSED; its rotation unknowns are in the
            workspace.

    Returns:
        Whether the problem has an inverse there.
    """
    if not factor_border(robot, rows, columns, angles, work, factors):
        return False
    border = work.border
    count = border.shape[0]
    for i in range(count):
        value = efforts[i - count + efforts.shape[0]] if i >= count - efforts.shape[0] else 0.0
        for j in range(count):
            value -= factors.border[i, j] * known[j]
        border[i] = value
    zero = broadcast(work.solution, 0.0)
    for number in range(robot.groups.shape[0]):
        for slot in range(robot.slots.inner_count):
            store(work.solution, (number, slot), zero)
    _solve_border(robot, rows, columns, angles, vector, work)
    for i in range(count):
        border[i] += known[i]
    for number in range(robot.groups.shape[0]):
        _backward(robot, number, vector, work, factors)
    return True


@inlined
def _forward(robot, number, vector, work, factors):
    """``L^-1 r`` of a group into the workspace, and what it does to the border."""
    index, upper, solution = robot.slot_index[number], factors.upper, work.solution
    inner, last, first = robot.slots.inner_count, robot.slots.motor, robot.slots.first_coupled
    for slot in range(inner):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            put(solution, (number, slot), lane, vector[i] if i >= 0 else 0.0)
    for i in range(1, inner):
        value = load(solution, (number, i))
        for k in range(i):
            value -= load(upper, (number, k, i)) * load(solution, (number, k))
        store(solution, (number, i), value)
    for j in range(inner, last + 1):
        value = broadcast(solution, 0.0)
        for k in range(first if j < last else 0, inner):
            value -= load(upper, (number, k, j)) * load(solution, (number, k))
        if j < last:
            work.border[j - inner] += total(value)
        else:
            motors = robot.groups[number].motor_index
            store(work.by_leg, 0, value)
            for lane in range(motors.shape[0]):
                if motors[lane] >= 0:
                    at = motors[lane] - robot.platform_index
                    work.border[at] += get(work.by_leg, 0, lane)


@inlined
def _solve_border(robot, rows, columns, angles, vector, work):
    """Unknowns of the border, into the vector; world twist and motors into the workspace."""
    inner, size, border, motions = robot.platform_index, rows.shape[0], work.border, work.motions
    part = vector[inner:]
    for i in range(size):
        part[i] = border[rows[i] - inner]
    lu_solve(work.square, size, work.pivots, part)
    for i in range(border.shape[0]):
        border[i] = 0.0
    for i in range(size):
        column = columns[i] - inner
        if angles and column < 3:
            for n in range(3):
                border[n] += motions[n, column] * part[i]
        else:
            border[column] = part[i]


@inlined
def _backward(robot, number, vector, work, factors):
    """``L^-T (D^-1 y - ...)`` of a group, into the vector."""
    index, upper, solution = robot.slot_index[number], factors.upper, work.solution
    inner, last, first = robot.slots.inner_count, robot.slots.motor, robot.slots.first_coupled
    motors = robot.groups[number].motor_index
    for lane in range(motors.shape[0]):
        at = motors[lane] - robot.platform_index
        put(work.by_leg, 0, lane, work.border[at] if motors[lane] >= 0 else 0.0)
    motor = load(work.by_leg, 0)
    for i in range(inner - 1, -1, -1):
        value = load(factors.inverse, (number, i)) * load(solution, (number, i))
        value -= load(upper, (number, i, last)) * motor
        for j in range(i + 1, inner):
            value -= load(upper, (number, i, j)) * load(solution, (number, j))
        if i >= first:
            for j in range(inner, last):
                value -= load(upper, (number, i, j)) * work.border[j - inner]
        store(solution, (number, i), value)
    for slot in range(inner):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            if i >= 0:
                vector[i] = get(solution, (number, slot), lane)


@kernel
def keep(robot, factors, kept):
    """Copy factors to memory of their own (``kept_factors``)."""
    upper, border = factors.upper, factors.border
    put(kept, 0, 0, float(factors.how[0]))
    at = 1
    for number in range(upper.shape[0]):
        for i in range(upper.shape[1]):
            # The unit diagonal of L^T is no news: the inverse pivots have its place.
            store(kept, at + i, load(factors.inverse, (number, i)))
            for j in range(i + 1, upper.shape[2]):
                store(kept, at + j, load(upper, (number, i, j)))
            at += upper.shape[2]
    width, lane = robot.slot_index.shape[2], 0
    for i in range(border.shape[0]):
        for j in range(border.shape[1]):
            put(kept, at, lane, border[i, j])
            lane += 1
            if lane == width:
                at, lane = at + 1, 0


@kernel
def recall(robot, kept, factors):
    """Copy them back."""
    upper, border = factors.upper, factors.border
    factors.how[0] = int(get(kept, 0, 0))
    if factors.how[0] != CONDENSED:
        return
    at = 1
    for number in range(upper.shape[0]):
        for i in range(upper.shape[1]):
            store(factors.inverse, (number, i), load(kept, at + i))
            for j in range(i + 1, upper.shape[2]):
                store(upper, (number, i, j), load(kept, at + j))
            at += upper.shape[2]
    width, lane = robot.slot_index.shape[2], 0
    for i in range(border.shape[0]):
        for j in range(border.shape[1]):
            border[i, j] = get(kept, at, lane)
            lane += 1
            if lane == width:
                at, lane = at + 1, 0


@kernel
def lu_factor(matrix, size, pivots, smallest):
    """Factor the leading square of a matrix in place, rows exchanged.

    Returns:
        False where no pivot exceeds ``smallest``.
    """
    for k in range(size):
        best, row = 0.0, k
        for i in range(k, size):
            value = abs(matrix[i, k])
            if value > best:
                best, row = value, i
        pivots[k] = row
        if not best > smallest:
            return False
        pivot = matrix[k]
        if row != k:
            other = matrix[row]
            for j in range(size):
                pivot[j], other[j] = other[j], pivot[j]
        inverse = 1.0 / pivot[k]
        for i in range(k + 1, size):
            target = matrix[i]
            if target[k] != 0.0:
                multiple = target[k] * inverse
                target[k] = multiple
                for j in range(k + 1, size):
                    target[j] -= multiple * pivot[j]
    return True


@kernel
def lu_solve(matrix, size, pivots, vector):
    """Solve with the result of ``lu_factor``, in place."""
    for k in range(size):
        row = pivots[k]
        if row != k:
            vector[k], vector[row] = vector[row], vector[k]
    for i in range(size):
        total_of_row = vector[i]
        for j in range(i):
            total_of_row -= matrix[i, j] * vector[j]
        vector[i] = total_of_row
    for i in range(size - 1, -1, -1):
        total_of_row = vector[i]
        for j in range(i + 1, size):
            total_of_row -= matrix[i, j] * vector[j]
        vector[i] = total_of_row / matrix[i, i]


@kernel
def lu_solve_transposed(matrix, size, pivots, vector):
    """Solve with the transpose of what ``lu_factor`` factored, in place."""
    for i in range(size):
        vector[i] /= matrix[i, i]
        for j in range(i + 1, size):
            vector[j] -= matrix[i, j] * vector[i]
    for i in range(size - 1, -1, -1):
        for j in range(i):
            vector[j] -= matrix[i, j] * vector[i]
    for k in range(size - 1, -1, -1):
        row = pivots[k]
        if row != k:
            vector[k], vector[row] = vector[row], vector[k]
