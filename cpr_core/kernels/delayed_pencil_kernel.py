# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The pencil where legs are straight: multipliers with small pivots are delayed (`delayed_kernel`).

Factors of such tangents hide digits, or are not kept: K comes from the tangent as it was evaluated. M
does not see multipliers, so a delayed one needs no place in vectors; K has nothing between two of them.
To the lanes its slot is one the leg lacks. Its couplings to the leg are kept beside: one of every leg of
a group at a time, a round. What the legs leave of them stands behind the platform in a matrix that is
factored with exchanges.
"""

from __future__ import annotations

from .condensation_kernel import condense_delaying
from .delayed_kernel import GROUP, LANE, SLOT
from .inertia_kernel import eliminate
from .kernel_decorators import inlined, part
from .lanes import broadcast, get, load, put, store, total
from .lu_kernel import lu_factor, lu_solve
from .pencil_layout import pencil_column

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
        slot = factors.delayed[q, SLOT]
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
    pencil.rounds[:] = 0
    for q in range(count):
        number, slot, lane = (
            factors.delayed[q, GROUP],
            factors.delayed[q, SLOT],
            factors.delayed[q, LANE],
        )
        _set_aside(slots, number, slot, lane, q, pencil)
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
    for i in range(slots.inner_count):
        scale = (1.0 / robot.energy_unit) * load(units, (number, i))
        for j in range(i, slots.total):
            value = scale * load(units, (number, j)) * load(blocks, (number, i, j))
            if i == j:
                value += load(robot.missing, (number, i))
            store(pencil.blocks, (number, i, pencil_column(slots, pencil.layout, j)), value)


@inlined
def _gather_motor_rows(robot, number, blocks, pencil):
    """Rows of the motors of a group."""
    slots, units, layout = robot.slots, robot.units, pencil.layout
    motor_slot = slots.first_motor
    scale = (1.0 / robot.energy_unit) * load(units, (number, motor_slot))
    for slot in range(slots.first_platform, motor_slot + 1):
        value = scale * load(units, (number, slot)) * load(blocks, (number, slot, motor_slot))
        store(pencil.blocks, (number, layout.motor, pencil_column(slots, layout, slot)), value)
    for lane in range(robot.slot_index.shape[2]):
        if robot.motor_slot_index[number, 0, lane] < 0:
            put(pencil.blocks, (number, layout.motor, layout.motor), lane, 1.0)


@inlined
def _set_aside(slots, number, slot, lane, q, pencil):
    """Take the couplings of delayed slot q out of the rows of its leg, into its next round."""
    blocks, platform, width = pencil.blocks, pencil.layout.first_platform, slots.platform_count
    beside, beside_platform, places = pencil.beside, pencil.beside_platform, pencil.places
    count, r = pencil.rounds[number], 0
    while r < count and places[number, r, lane] >= 0:
        r += 1
    if r == count:
        pencil.rounds[number] = count + 1
        places[number, r, :] = -1
        for k in range(beside.shape[2]):
            store(beside, (number, r, k), 0.0)
        for j in range(width):
            store(beside_platform, (number, r, j), 0.0)
    places[number, r, lane] = q
    for k in range(beside.shape[2]):
        row, column = min(k, slot), max(k, slot)
        put(beside, (number, r, k), lane, get(blocks, (number, row, column), lane))
        put(blocks, (number, row, column), lane, 1.0 if k == slot else 0.0)
    for j in range(width):
        coupling = get(blocks, (number, slot, platform + j), lane)
        put(beside_platform, (number, r, j), lane, coupling)
        put(blocks, (number, slot, platform + j), lane, 0.0)


@part
def eliminate_delayed(pencil, size):
    """Eliminate platform and delayed slots, from what the legs have left of the platform.

    Args:
        pencil: Pencil, its legs eliminated.
        size: Rows of a leg that are eliminated.

    Returns:
        Number of negative pivots; -1 where the matrix has no inverse.
    """
    width, whole, factored = pencil.left.shape[0], pencil.whole, pencil.factored
    extent = width + pencil.delayed_count[0]
    for i in range(extent):
        for j in range(i, extent):
            value = pencil.left[i, j] if j < width else 0.0
            whole[i, j] = whole[j, i] = value
    for number in range(pencil.rounds.shape[0]):
        for r in range(pencil.rounds[number]):
            _eliminate_round(pencil, number, r, size)
    for i in range(extent):
        for j in range(extent):
            factored[i, j] = whole[i, j]
    begin = 0 * extent  # a constant would be compiled for on its own
    negative, _ = eliminate(whole, begin, extent, extent, 0.0)
    return negative if lu_factor(factored, extent, pencil.pivots, 0.0) else -1


@inlined
def _eliminate_round(pencil, number, r, size):
    """What the legs of a group leave of the delayed slots of a round."""
    upper, beyond, inverse, places = pencil.upper, pencil.beyond, pencil.inverse, pencil.places
    width, platform = pencil.left.shape[0], pencil.layout.first_platform
    whole, by_leg, lanes = pencil.whole, pencil.by_leg, places.shape[2]
    for k in range(size):
        value = load(pencil.beside, (number, r, k))
        for m in range(k):
            value -= load(upper, (number, m, k)) * load(beyond, (number, r, m))
        store(beyond, (number, r, k), value)
    for before in range(r + 1):
        value = broadcast(upper, 0.0)
        for k in range(size):
            own = load(inverse, (number, k)) * load(beyond, (number, r, k))
            value -= load(beyond, (number, before, k)) * own
        store(by_leg, 0, value)
        for lane in range(lanes):
            q, p = places[number, r, lane], places[number, before, lane]
            if q >= 0:
                entry = get(by_leg, 0, lane)
                whole[width + q, width + p] = whole[width + p, width + q] = entry
    for j in range(width):
        value = load(pencil.beside_platform, (number, r, j))
        for k in range(pencil.layout.first_coupled, size):
            value -= load(beyond, (number, r, k)) * load(upper, (number, k, platform + j))
        store(by_leg, 0, value)
        for lane in range(lanes):
            q = places[number, r, lane]
            if q >= 0:
                whole[width + q, j] = whole[j, width + q] = get(by_leg, 0, lane)


@inlined
def reduce_delayed(pencil, size):
    """Platform and delayed slots of a solve, from what the legs have left of their right sides.

    Right sides of delayed slots are zero, as all of multipliers.
    """
    width, part, places = pencil.left.shape[0], pencil.part, pencil.places
    for i in range(width):
        part[i] = pencil.border[i]
    for number in range(pencil.rounds.shape[0]):
        for r in range(pencil.rounds[number]):
            value = broadcast(pencil.upper, 0.0)
            for k in range(size):
                eliminated = load(pencil.inverse, (number, k)) * load(pencil.vector, (number, k))
                value -= load(pencil.beyond, (number, r, k)) * eliminated
            store(pencil.by_leg, 0, value)
            for lane in range(places.shape[2]):
                q = places[number, r, lane]
                if q >= 0:
                    part[width + q] = get(pencil.by_leg, 0, lane)
    lu_solve(pencil.factored, width + pencil.delayed_count[0], pencil.pivots, part)
    for i in range(width):
        pencil.border[i] = part[i]
    for number in range(pencil.rounds.shape[0]):
        for r in range(pencil.rounds[number]):
            for lane in range(places.shape[2]):
                q = places[number, r, lane]
                put(pencil.found, (number, r), lane, part[width + q] if q >= 0 else 0.0)


@inlined
def substitute_delayed(pencil, size):
    """What delayed slots do to the slots of their legs, D^-1 applied already."""
    vector = pencil.vector
    for number in range(pencil.rounds.shape[0]):
        for r in range(pencil.rounds[number]):
            found = load(pencil.found, (number, r))
            for k in range(size):
                taken = load(pencil.inverse, (number, k)) * load(pencil.beyond, (number, r, k))
                store(vector, (number, k), load(vector, (number, k)) - taken * found)


@inlined
def work_of_delayed(pencil, size):
    """What delayed slots, as they were solved for last, have in half of ``vector^T K vector``."""
    vector, border, work = pencil.vector, pencil.border, broadcast(pencil.upper, 0.0)
    for number in range(pencil.rounds.shape[0]):
        for r in range(pencil.rounds[number]):
            row = broadcast(pencil.upper, 0.0)
            for k in range(size):
                row += load(pencil.beside, (number, r, k)) * load(vector, (number, k))
            for j in range(border.shape[0]):
                row += load(pencil.beside_platform, (number, r, j)) * border[j]
            work += load(pencil.found, (number, r)) * row
    return total(work)


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
