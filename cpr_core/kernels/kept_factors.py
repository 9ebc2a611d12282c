# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Condensed tangents as equilibria keep them: one array of lanes, packed.

    how it was factored | rows of L^T and D^-1 L^-1 B, slot by slot, D^-1 on the diagonal | border

Where slots were delayed nothing but that is kept: the tangent is found again where it is needed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .condensation_kernel import CONDENSED
from .kernel_arrays import Lanes, RobotArrays
from .kernel_decorators import inlined
from .lanes import get, lanes_dtype, load, put, store
from .slots import SlotLayout
from .workspace_arrays import Factors

__all__ = [
    "border_of",
    "keep",
    "kept_border",
    "kept_count",
    "kept_factors",
    "kept_row",
    "kept_status",
    "recall_border",
    "recalled",
]


Floats = NDArray[np.float64]


def kept_factors(robot: RobotArrays, count: int = 1) -> Lanes:
    """Memory in which factors are kept with an equilibrium, or with some, one after the other."""
    return np.empty(count * robot.kept_count, lanes_dtype(robot.slot_index.shape[2]))


def kept_count(group_count: int, slots: SlotLayout, border_count: int, width: int) -> int:
    """Lanes of it."""
    return _legs_count(group_count, slots) - (-(border_count**2) // width)


def _legs_count(group_count: int, slots: SlotLayout) -> int:
    """Lanes before the border, as `kept_border` has it."""
    return 1 + group_count * slots.inner_count * slots.total


def border_of(robot: RobotArrays, kept: Lanes) -> Floats | None:
    """The border of a kept tangent, dimensionless, (b + n, b + n); None: it was not condensed."""
    numbers, count = kept["lane"], len(robot.border_indices)
    if numbers[0, 0] != CONDENSED:
        return None
    border: Floats = numbers[_legs_count(len(robot.groups), robot.slots) :]
    return border.ravel()[: count**2].reshape(count, count)


@inlined
def kept_status(kept):
    """How the tangent was factored."""
    return int(get(kept, 0, 0))


@inlined
def kept_row(slots, number, slot):
    """Where column 0 of a slot's row is."""
    return 1 + (number * slots.inner_count + slot) * slots.total


@inlined
def kept_border(slots, group_count):
    """Where the border begins: entry after entry, lane after lane."""
    return kept_row(slots, group_count, 0)


@inlined
def keep(robot, factors, kept):
    """Copy factors to memory of their own (``kept_factors``)."""
    slots, upper, width = robot.slots, factors.upper, robot.slot_index.shape[2]
    put(kept, 0, 0, float(factors.status[0]))
    if factors.status[0] != CONDENSED:
        return
    for number in range(robot.groups.shape[0]):
        for i in range(slots.inner_count):
            row = kept_row(slots, number, i)
            # The unit diagonal of L^T is no news: the inverse pivots have its place.
            store(kept, row + i, load(factors.inverse, (number, i)))
            for j in range(i + 1, slots.total):
                store(kept, row + j, load(upper, (number, i, j)))
    at, lane = kept_border(slots, robot.groups.shape[0]), 0
    count = robot.border_indices.shape[0]
    for i in range(count):
        for j in range(count):
            put(kept, at, lane, factors.border[i, j])
            lane += 1
            if lane == width:
                at, lane = at + 1, 0


@inlined
def recalled(robot, kept, factors):
    """Kept factors read where they are; pivots and border alone are copied, into others' memory.

    For kernels, which count no references to arrays: these are borrowed.

    Args:
        robot: RobotArrays.
        kept: Kept factors.
        factors: Factors, whose memory is lent.
    """
    slots, groups = robot.slots, robot.groups.shape[0]
    factors.status[0] = kept_status(kept)
    begin = kept_border(slots, groups)
    upper = kept[kept_row(slots, 0, 0) : begin].reshape((groups, slots.inner_count, slots.total))
    if factors.status[0] == CONDENSED:
        factors.delayed_count[0] = 0
        for number in range(groups):
            for i in range(slots.inner_count):
                store(factors.inverse, (number, i), load(upper, (number, i, i)))
        count = robot.border_indices.shape[0]
        recall_border(kept, begin, count, robot.slot_index.shape[2], factors.border)
    return Factors(
        upper,
        factors.inverse,
        factors.border,
        factors.status,
        factors.delayed_count,
        factors.delayed,
        factors.beyond,
    )


@inlined
def recall_border(kept, at, count, width, border):
    """Copy the border alone back, from where it begins; ``width`` lanes."""
    lane = 0
    for i in range(count):
        for j in range(count):
            border[i, j] = get(kept, at, lane)
            lane += 1
            if lane == width:
                at, lane = at + 1, 0
