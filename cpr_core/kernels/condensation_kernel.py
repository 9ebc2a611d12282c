# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The tangent, all its legs condensed at once onto platform and motors.

The tangent is block-arrow shaped: a leg touches its own block and the border (platform and its motor)
only, and both are symmetric. With ``S = L D L^T`` the block of a leg, B its coupling to the border and
H_0 what the border has of its own,

    H = H_0 - sum B^T S^-1 B,    H x_b = r_b - sum B^T S^-1 r,    x = S^-1 (r - B x_b).

Signs of D and of H are the stability indices (Sylvester's law), parts of H the kinemato-statics.
The solves are in `tangent_kernel`, the border in `border_kernel`.

Elimination is in a fixed order, strain before multipliers, without exchanges. Where a pivot is too small
(a straight leg, a rod about to buckle on its own), all begins again, and slots with small pivots are
delayed: left to the border, beside platform and motors (`delayed_kernel`). All numbers here are
dimensionless.
"""

from __future__ import annotations

import numpy as np

from .by_leg import PIVOT, PIVOT_INVERSE
from .delayed_kernel import (
    add_delayed,
    delay_small_pivots,
    scale_of_strain,
)
from .kernel_decorators import inlined, part
from .lanes import absolute, broadcast, get, highest, load, lower, store, total

__all__ = [
    "CONDENSED",
    "DELAYED",
    "NO_INVERSE",
    "SMALLEST_LEG_PIVOT",
    "UNKNOWN",
    "condense",
    "condense_delaying",
]

#: How a tangent was factored: all legs condensed, some slots left to the border; or there is no inverse,
#: or nobody knows its factors.
CONDENSED, DELAYED, NO_INVERSE, UNKNOWN = 0, 1, 2, 3

#: Pivots below this fraction of the largest strain stiffness of a leg are not divided by.
SMALLEST_LEG_PIVOT = 1e-8


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
