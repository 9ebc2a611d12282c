# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""K of the pencil of an equilibrium, put together again from the factors of its tangent that were kept.

What was eliminated is multiplied out: nothing of the model is evaluated again.
"""

from __future__ import annotations

import numpy as np

from .condensation_kernel import CONDENSED, SMALLEST_LEG_PIVOT
from .kept_factors import kept_border, kept_row, kept_status, recall_border
from .kernel_decorators import inlined
from .lanes import absolute, broadcast, get, highest, load, lower, put, store, total
from .pencil_layout import pencil_column

__all__ = ["recall_pencil"]


@inlined
def recall_pencil(robot, kept, pencil, largest):
    """K from the kept factors of a tangent: what was eliminated is put together again.

    The platform's part is made symmetric: loads without potential do no work on H_r. A leg has its motor
    to itself, or the rows of motors are left out, and with them what moves while motors are free.

    Args:
        robot: RobotArrays.
        kept: Factors of its tangent (``keep``).
        pencil: Pencil.
        largest: Entry of platform and motors, dimensionless, that is not exceeded.

    Returns:
        Whether enough digits are left.
    """
    corner, condensed, count = pencil.corner, pencil.condensed, robot.border_indices.shape[0]
    slots, lanes, groups = robot.slots, robot.slot_index.shape[2], robot.groups.shape[0]
    doubt, pencil.delayed_count[0] = broadcast(pencil.rows, -1.0), 0
    if kept_status(kept) != CONDENSED:
        return False
    recall_border(kept, kept_border(slots, groups), count, lanes, condensed)
    for i in range(count):
        for j in range(count):
            if not abs(condensed[i, j]) < largest:
                return False
    for i in range(slots.platform_count):
        for j in range(slots.platform_count):
            corner[i, j] = 0.5 * (condensed[i, j] + condensed[j, i])
    for number in range(groups):
        doubt = -lower(-doubt, _recall_leg_rows(slots, number, kept, pencil))
        _recall_platform(slots, number, kept, pencil)
        if robot.one_slot_a_motor:
            _recall_motor_rows(robot, number, kept, pencil)
    return highest(doubt) < 0.0


@inlined
def _recall_leg_rows(slots, number, kept, pencil):
    """Rows of the inner slots of a group; returns what is positive where too few digits are left."""
    blocks, rows = pencil.blocks, pencil.rows
    inner, extent, first = slots.inner_count, slots.total, slots.first_coupled
    largest, smallest = broadcast(rows, 0.0), broadcast(rows, np.inf)
    for i in range(inner):
        # Stored in place of the unit diagonal: the inverse pivot.
        row = kept_row(slots, number, i)
        pivot = 1.0 / load(kept, row + i)
        store(rows, (i, i), pivot)
        smallest = lower(smallest, absolute(pivot))
        if i < slots.strain_count:
            largest = -lower(-largest, -absolute(pivot))
        for j in range(i + 1, extent):
            store(rows, (i, j), pivot * load(kept, row + j))
        for j in range(i, extent):
            begin = 0 if j < inner or j >= slots.first_motor else first
            value = broadcast(rows, 0.0)
            for k in range(begin, i):
                value += load(kept, kept_row(slots, number, k) + i) * load(rows, (k, j))
            if i >= begin:
                value += load(rows, (i, j))
            store(blocks, (number, i, pencil_column(slots, pencil.layout, j)), value)
    # Beyond, too many digits of the rest are lost, as in what was eliminated.
    return smallest - SMALLEST_LEG_PIVOT * largest


@inlined
def _recall_platform(slots, number, kept, pencil):
    """Give back to the platform what a group had taken from it."""
    inner, width = slots.inner_count, slots.platform_count
    for i in range(width):
        for j in range(i, width):
            value = broadcast(pencil.rows, 0.0)
            for k in range(slots.first_coupled, inner):
                left = load(kept, kept_row(slots, number, k) + inner + i)
                value += left * load(pencil.rows, (k, inner + j))
            pencil.corner[i, j] += total(value)


@inlined
def _recall_motor_rows(robot, number, kept, pencil):
    """Rows of the motors of a group, with what the legs had taken from them."""
    slots, blocks, rows, layout = robot.slots, pencil.blocks, pencil.rows, pencil.layout
    platform, motor_slot = slots.first_platform, slots.first_motor
    for slot in range(platform, motor_slot + 1):
        value = broadcast(rows, 0.0)
        begin = slots.first_coupled if slot < motor_slot else 0
        for k in range(begin, slots.inner_count):
            left = load(kept, kept_row(slots, number, k) + slot)
            value += left * load(rows, (k, motor_slot))
        store(blocks, (number, layout.motor, pencil_column(slots, layout, slot)), value)
    for lane in range(robot.slot_index.shape[2]):
        motor = robot.motor_slot_index[number, 0, lane]
        if motor < 0:
            put(blocks, (number, layout.motor, layout.motor), lane, 1.0)
            continue
        m = motor - robot.platform_index
        for slot in range(platform, motor_slot + 1):
            column = pencil_column(slots, layout, slot)
            value = get(blocks, (number, layout.motor, column), lane)
            value += pencil.condensed[m, slot - platform if slot < motor_slot else m]
            put(blocks, (number, layout.motor, column), lane, value)
