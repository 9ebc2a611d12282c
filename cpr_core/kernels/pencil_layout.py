# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where things are among the rows and columns that a leg has in a pencil.

    inner slots | motor | platform

Rows end with the motor, columns with the platform. In `slots` the motor is last: here it is eliminated
with its leg, or left out where it is held.
"""

from __future__ import annotations

from typing import NamedTuple

from .kernel_decorators import inlined
from .slots import SlotLayout

__all__ = ["PencilLayout", "eliminated_rows", "pencil_column", "pencil_layout"]


class PencilLayout(NamedTuple):
    """Numbers of rows and columns; inner slots are first of all."""

    first_coupled: int  # first row that meets the platform's columns
    motor: int  # row and column of the motor
    row_count: int
    first_platform: int  # column
    column_count: int
    constraint_count: int  # number of multipliers of all legs


def pencil_layout(slots: SlotLayout, constraint_count: int) -> PencilLayout:
    """The layout of legs with these slots, and so many multipliers in all."""
    motor = slots.inner_count
    first_platform = motor + 1
    return PencilLayout(
        first_coupled=slots.first_coupled,
        motor=motor,
        row_count=first_platform,
        first_platform=first_platform,
        column_count=first_platform + slots.platform_count,
        constraint_count=constraint_count,
    )


@inlined
def pencil_column(slots, layout, slot):
    """The column of a slot."""
    if slot < slots.first_platform:
        return slot
    if slot < slots.first_motor:
        return layout.first_platform + slot - slots.first_platform
    return layout.motor


@inlined
def eliminated_rows(layout, free):
    """How many rows of a leg are eliminated: that of the motor is not, unless motors are free."""
    return layout.row_count if free else layout.motor
