# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Delayed slots: those of a leg that cannot be eliminated with the others, and are left to the border.

A straight leg cannot move its tip along itself, so its force there does not follow from the leg alone;
nor does a strain of a rod about to buckle on its own. Multifrontal solvers call such pivots delayed. To
the lanes a delayed slot is one the leg lacks: its rows are zero, its pivot is 1. Its couplings to the
slots after it, which these have to eliminate, are kept beside, and what is left of it stands in the
border behind platform and motors.

These functions are given what they read, not a robot and a workspace: every function that takes
those two takes a second to compile.
"""

from __future__ import annotations

from .by_leg import PIVOT, PIVOT_INVERSE, PIVOT_SCALE
from .kernel_decorators import inlined
from .lanes import absolute, broadcast, get, load, lower, put, store

__all__ = [
    "GROUP",
    "LANE",
    "SLOT",
    "add_delayed",
    "delay_small_pivots",
    "gather_delayed",
    "scale_of_strain",
    "scatter_delayed",
]

#: Columns of ``factors.delayed``: where a delayed slot is from.
GROUP, SLOT, LANE = 0, 1, 2
#: Pivots not above this fraction of the largest strain stiffness of a leg are delayed. Multipliers are
#: few: delaying one costs little, and spares digits.
_SMALLEST_STRAIN_PIVOT, _SMALLEST_PIVOT = 1e-8, 1e-4


@inlined
def scale_of_strain(units, blocks, number, strain_count, per_energy, by_leg):
    """Largest strain stiffness of every leg of a group, into ``by_leg``."""
    scale = broadcast(blocks, 0.0)
    for i in range(strain_count):
        unit = load(units, (number, i))
        stiffness = absolute(unit * unit * load(blocks, (number, i, i)))
        scale = -lower(-scale, -stiffness)
    store(by_leg, PIVOT_SCALE, per_energy * scale)


@inlined
def delay_small_pivots(index, is_strain, number, i, border_count, by_leg, factors):
    """Delay slot ``i`` in the legs whose pivot is too small: zero takes the place of its inverse.

    Args:
        index: State indices of the slot, leg by leg; -1: a leg lacks it.
        is_strain: Whether it is a strain coordinate.
        number: The group.
        i: The slot.
        border_count: Rows of the border without delayed slots.
        by_leg: Numbers by leg, with the pivots.
        factors: Factors.
    """
    border, delayed = factors.border, factors.delayed
    smallest = _SMALLEST_STRAIN_PIVOT if is_strain else _SMALLEST_PIVOT
    for lane in range(index.shape[0]):
        pivot = get(by_leg, PIVOT, lane)
        put(by_leg, PIVOT_INVERSE, lane, 1.0 / pivot)
        exists = index[lane] >= 0
        if not exists or abs(pivot) > smallest * get(by_leg, PIVOT_SCALE, lane):
            continue
        put(by_leg, PIVOT_INVERSE, lane, 0.0)
        put(factors.inverse, (number, i), lane, 1.0)
        count = factors.delayed_count[0]
        delayed[count, GROUP], delayed[count, SLOT], delayed[count, LANE] = number, i, lane
        at = border_count + count
        for j in range(at):
            border[at, j] = border[j, at] = 0.0
        border[at, at] = pivot
        factors.delayed_count[0] = count + 1


@inlined
def add_delayed(slots, motors, platform_index, width, number, rows, factors):
    """Eliminate the slots of a group from its delayed ones; what is left goes into the border.

    Args:
        slots: SlotLayout.
        motors: State indices of the motors of the group, by motor slots and legs.
        platform_index: State index of the first platform coordinate.
        width: Rows of the border without delayed slots.
        number: The group.
        rows: Rows of its D L^T.
        factors: Factors.
    """
    upper, beyond, border, delayed = factors.upper, factors.beyond, factors.border, factors.delayed
    first, count = 0, factors.delayed_count[0]
    while first < count and delayed[first, GROUP] < number:
        first += 1
    for q in range(first, count):
        slot, lane = delayed[q, SLOT], delayed[q, LANE]
        for k in range(slot + 1, slots.inner_count):
            value = get(rows, (slot, k), lane)
            for m in range(slot + 1, k):
                value -= get(upper, (number, m, k), lane) * beyond[q, m]
            beyond[q, k] = value
        for p in range(q + 1, count):
            if delayed[p, LANE] == lane:
                border[width + q, width + p] = beyond[q, delayed[p, SLOT]]
                beyond[q, delayed[p, SLOT]] = 0.0
    for q in range(first, count):
        slot, lane = delayed[q, SLOT], delayed[q, LANE]
        for p in range(first, q + 1):
            if delayed[p, LANE] != lane:
                continue
            value = border[width + p, width + q]
            for m in range(slot + 1, slots.inner_count):
                value -= beyond[p, m] * get(factors.inverse, (number, m), lane) * beyond[q, m]
            border[width + p, width + q] = border[width + q, width + p] = value
        for column in range(slots.first_platform, slots.total):
            is_motor = column >= slots.first_motor
            motor = motors[column - slots.first_motor, lane] if is_motor else 0
            if motor < 0:
                continue
            begin = 0 if is_motor else slots.first_coupled
            value = get(rows, (slot, column), lane) if slot >= begin else 0.0
            for m in range(max(begin, slot + 1), slots.inner_count):
                value -= beyond[q, m] * get(upper, (number, m, column), lane)
            at = motor - platform_index if is_motor else column - slots.first_platform
            border[width + q, at] += value
            border[at, width + q] += value


@inlined
def gather_delayed(slots, width, solution, border, factors):
    """What the slots after them leave of the right sides of delayed slots, into the border's vector."""
    beyond = factors.beyond
    for q in range(factors.delayed_count[0]):
        number, slot, lane = (
            factors.delayed[q, GROUP],
            factors.delayed[q, SLOT],
            factors.delayed[q, LANE],
        )
        value = get(solution, (number, slot), lane)
        for m in range(slot + 1, slots.inner_count):
            eliminated = get(factors.inverse, (number, m), lane) * get(solution, (number, m), lane)
            value -= beyond[q, m] * eliminated
        border[width + q] = value


@inlined
def scatter_delayed(slots, width, solution, border, factors):
    """Delayed slots from the border's vector, and what they do to right sides of slots after them."""
    beyond = factors.beyond
    for q in range(factors.delayed_count[0]):
        number, slot, lane = (
            factors.delayed[q, GROUP],
            factors.delayed[q, SLOT],
            factors.delayed[q, LANE],
        )
        found = border[width + q]
        put(solution, (number, slot), lane, found)
        for m in range(slot + 1, slots.inner_count):
            value = get(solution, (number, m), lane) - beyond[q, m] * found
            put(solution, (number, m), lane, value)
