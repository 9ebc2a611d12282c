# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where things are among the slots of a leg: the same for all legs of a robot, of which some lack some.

    strain by component | forces at tip | moments at tip | passive base coordinate | platform | motor

All up to the passive coordinate are inner slots: they are eliminated leg by leg.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["SlotLayout", "slot_layout"]


class SlotLayout(NamedTuple):
    """Numbers of slots and the first one of each kind; strain is first of all."""

    strain_count: int
    first_multiplier: int
    position_count: int  # multipliers that hold the position of the tip: forces
    first_orientation: int
    orientation_count: int  # multipliers that hold its orientation, the most a leg has: moments
    passive: int  # slot of the passive base coordinate; -1: no leg has one
    inner_count: int
    first_platform: int  # first column of the platform
    platform_count: int
    motor: int
    total: int
    first_coupled: (
        int  # where nothing holds orientations, strain does not meet the platform's columns
    )


def slot_layout(
    strain_count: int,
    position_count: int,
    orientation_count: int,
    passive: bool,
    platform_count: int,
) -> SlotLayout:
    """The layout for so many slots of each kind."""
    first_orientation = strain_count + position_count
    first_passive = first_orientation + orientation_count
    inner_count = first_passive + (1 if passive else 0)
    motor = inner_count + platform_count
    return SlotLayout(
        strain_count=strain_count,
        first_multiplier=strain_count,
        position_count=position_count,
        first_orientation=first_orientation,
        orientation_count=orientation_count,
        passive=first_passive if passive else -1,
        inner_count=inner_count,
        first_platform=inner_count,
        platform_count=platform_count,
        motor=motor,
        total=motor + 1,
        first_coupled=0 if orientation_count else strain_count,
    )
