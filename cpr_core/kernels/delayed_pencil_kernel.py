# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The pencil where legs are straight: multipliers with small pivots are delayed (`delayed_kernel`).

Factors of such tangents hide digits, or are not kept: K comes from the tangent as it was evaluated. M
does not see multipliers, so a delayed one needs no place in vectors; K has nothing between two of them.
To the lanes its slot is one the leg lacks. Its couplings to the leg are kept beside, and what the leg
leaves of them stands behind the platform in a matrix that is factored with exchanges.
"""

from __future__ import annotations

from .condensation_kernel import condense_delaying
from .inertia_kernel import eliminate
from .kernel_decorators import inlined, part
from .lanes import get, load, put, store
from .lu_kernel import lu_factor, lu_solve

__all__ = [
    "compliance_of_platform",
    "eliminate_delayed",
    "gather_pencil",
    "reduce_delayed",
    "substitute_delayed",
    "work_of_delayed",
]


@part
def gather_pencil(robot, work, pencil):
    """K from the tangent in the workspace; a multiplier with a small pivot is delayed.

    Returns:
        Whether nothing else has a small pivot.
    """
    slots, factors, corner = robot.slots, work.factors, pencil.corner
    condense_delaying(robot, work, factors)
    count = factors.delayed_count[0]
    for q in range(count):
        slot = factors.delayed[q, 1]
        if slot < slots.first_multiplier or slot >= slots.first_passive:
            return False
    pencil.delayed_count[0] = count
    _gather_condensed(robot, factors, pencil.condensed)
    width, inner, per_energy = slots.platform_count, robot.platform_index, 1.0 / robot.energy_unit
    for i in range(width):
        for j in range(width):
            row, column = robot.platform_axes[i], robot.platform_axes[j]
            value = 0.5 * (work.platform_tangent[row, column] + work.platform_tangent[column, row])
            corner[i, j] = value * per_energy * robot.unit[inner + i] * robot.unit[inner + j]
    for number in range(robot.groups.shape[0]):
        _gather_leg_rows(robot, number, work.blocks, pencil)
        if robot.one_slot_a_motor:
            _gather_motor_rows(robot, number, work.blocks, pencil)
    for q in range(count):
        for column in range(3):
            pencil.delayed[q, column] = factors.delayed[q, column]
        _set_aside(slots, q, pencil)
    return True


@inlined
def _gather_condensed(robot, factors, condensed):
    """What the legs have left of platform, delayed slots and motors, in this order."""
    width, last = robot.slots.platform_count, robot.border_indices.shape[0]
    count = factors.delayed_count[0]
    for i in range(last + count):
        row = i if i < width else (last + i - width if i < width + count else i - count)
        for j in range(last + count):
            column = j if j < width else (last + j - width if j < width + count else j - count)
            condensed[i, j] = factors.border[row, column]


@inlined
def _gather_leg_rows(robot, number, blocks, pencil):
    """Rows of the inner slots of a group."""
    slots, units = robot.slots, robot.units
    inner, last = slots.inner_count, slots.first_motor
    for i in range(inner):
        scale = (1.0 / robot.energy_unit) * load(units, (number, i))
        for j in range(i, slots.total):
            value = scale * load(units, (number, j)) * load(blocks, (number, i, j))
            if i == j:
                value += load(robot.missing, (number, i))
            at = j if j < inner else (j + 1 if j < last else inner)
            store(pencil.blocks, (number, i, at), value)


@inlined
def _gather_motor_rows(robot, number, blocks, pencil):
    """Rows of the motors of a group."""
    slots, units = robot.slots, robot.units
    inner, motor = slots.inner_count, slots.first_motor
    scale = (1.0 / robot.energy_unit) * load(units, (number, motor))
    for row in range(inner, motor + 1):
        value = scale * load(units, (number, row)) * load(blocks, (number, row, motor))
        at = row + 1 if row < motor else inner
        store(pencil.blocks, (number, inner, at), value)
    for lane in range(robot.slot_index.shape[2]):
        if robot.motor_slot_index[number, 0, lane] < 0:
            put(pencil.blocks, (number, inner, inner), lane, 1.0)


@inlined
def _set_aside(slots, q, pencil):
    """Take the couplings of delayed slot q out of the rows of its leg."""
    number, slot, lane = pencil.delayed[q, 0], pencil.delayed[q, 1], pencil.delayed[q, 2]
    blocks, beside, inner = pencil.blocks, pencil.beside, slots.inner_count
    for k in range(beside.shape[1]):
        row, column = min(k, slot), max(k, slot)
        beside[q, k] = get(blocks, (number, row, column), lane)
        put(blocks, (number, row, column), lane, 1.0 if k == slot else 0.0)
    for j in range(slots.platform_count):
        pencil.beside_platform[q, j] = get(blocks, (number, slot, inner + 1 + j), lane)
        put(blocks, (number, slot, inner + 1 + j), lane, 0.0)


@part
def eliminate_delayed(pencil, first, size):
    """Eliminate platform and delayed slots, from what the legs have left of the platform.

    Args:
        pencil: Pencil, its legs eliminated.
        first: First slot that meets the platform's columns.
        size: Rows of a leg that are eliminated.

    Returns:
        Number of negative pivots; -1 where the matrix has no inverse.
    """
    width, count = pencil.left.shape[0], pencil.delayed_count[0]
    whole, factored, beyond = pencil.whole, pencil.factored, pencil.beyond
    for i in range(width):
        for j in range(i, width):
            whole[i, j] = whole[j, i] = pencil.left[i, j]
    for q in range(count):
        number, lane = pencil.delayed[q, 0], pencil.delayed[q, 2]
        for k in range(size):
            value = pencil.beside[q, k]
            for m in range(k):
                value -= get(pencil.upper, (number, m, k), lane) * beyond[q, m]
            beyond[q, k] = value
        for p in range(q + 1):
            value = 0.0
            if pencil.delayed[p, 0] == number and pencil.delayed[p, 2] == lane:
                for k in range(size):
                    value -= beyond[p, k] * get(pencil.inverse, (number, k), lane) * beyond[q, k]
            whole[width + p, width + q] = whole[width + q, width + p] = value
        for j in range(width):
            value = pencil.beside_platform[q, j]
            for k in range(first, size):
                value -= beyond[q, k] * get(
                    pencil.upper, (number, k, pencil.beside.shape[1] + j), lane
                )
            whole[width + q, j] = whole[j, width + q] = value
    extent = width + count
    for i in range(extent):
        for j in range(extent):
            factored[i, j] = whole[i, j]
    negative, _ = eliminate(whole, 0, extent, extent, 0.0)
    return negative if lu_factor(factored, extent, pencil.pivots, 0.0) else -1


@inlined
def reduce_delayed(pencil, size):
    """Platform and delayed slots of a solve, from what the legs have left of their right sides.

    Right sides of delayed slots are zero, as all of multipliers.
    """
    width, part = pencil.left.shape[0], pencil.part
    for i in range(width):
        part[i] = pencil.border[i]
    for q in range(pencil.delayed_count[0]):
        number, lane = pencil.delayed[q, 0], pencil.delayed[q, 2]
        value = 0.0
        for k in range(size):
            eliminated = get(pencil.inverse, (number, k), lane) * get(
                pencil.vector, (number, k), lane
            )
            value -= pencil.beyond[q, k] * eliminated
        part[width + q] = value
    lu_solve(pencil.factored, width + pencil.delayed_count[0], pencil.pivots, part)
    for i in range(width):
        pencil.border[i] = part[i]


@inlined
def substitute_delayed(pencil, size):
    """What delayed slots do to the slots of their legs, D^-1 applied already."""
    width = pencil.left.shape[0]
    for q in range(pencil.delayed_count[0]):
        number, lane, found = pencil.delayed[q, 0], pencil.delayed[q, 2], pencil.part[width + q]
        for k in range(size):
            taken = get(pencil.inverse, (number, k), lane) * pencil.beyond[q, k] * found
            put(pencil.vector, (number, k), lane, get(pencil.vector, (number, k), lane) - taken)


@inlined
def work_of_delayed(pencil, size):
    """What delayed slots, as they were solved for last, have in half of ``vector^T K vector``."""
    vector, border, width, work = pencil.vector, pencil.border, pencil.left.shape[0], 0.0
    for q in range(pencil.delayed_count[0]):
        number, lane, row = pencil.delayed[q, 0], pencil.delayed[q, 2], 0.0
        for k in range(size):
            row += pencil.beside[q, k] * get(vector, (number, k), lane)
        for j in range(width):
            row += pencil.beside_platform[q, j] * border[j]
        work += pencil.part[width + q] * row
    return work


@part
def compliance_of_platform(pencil):
    """The largest number on the diagonal of the platform's part of the inverse."""
    width, part, largest = pencil.left.shape[0], pencil.part, 0.0
    extent = width + pencil.delayed_count[0]
    for j in range(width):
        for i in range(extent):
            part[i] = 1.0 if i == j else 0.0
        lu_solve(pencil.factored, extent, pencil.pivots, part)
        largest = max(largest, part[j])
    return largest
