# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where things are among the slots of a leg: the same for all legs of a robot, of which some lack some.

    strain by component | forces at tip | moments at tip | passive coordinates | platform | motors

All up to the passive coordinates are inner slots: they are eliminated leg by leg. One motor may be in
several legs, and in several slots of one.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["COMPONENTS", "SlotLayout", "slot_layout"]

#: Strain components of a rod: torsion, bending about d2 and about d3.
COMPONENTS = 3


class SlotLayout(NamedTuple):
    """Numbers of slots and the first one of each kind; strain is first of all."""

    strain_count: int
    first_multiplier: int
    position_count: int  # multipliers that hold the position of the tip: forces
    first_orientation: int
    orientation_count: int  # multipliers that hold its orientation, the most a leg has: moments
    first_passive: int  # passive coordinates of joints
    passive_count: int  # the most a leg has
    inner_count: int
    first_platform: int  # first column of the platform
    platform_count: int
    first_motor: int  # coordinates of joints that motors move
    motor_count: int  # the most a leg has
    total: int
    first_coupled: (
        int  # where nothing holds orientations, strain does not meet the platform's columns
    )


def slot_layout(
    strain_count: int,
    position_count: int,
    orientation_count: int,
    passive_count: int,
    platform_count: int,
    motor_count: int,
) -> SlotLayout:
    """The layout for so many slots of each kind."""
    first_orientation = strain_count + position_count
    first_passive = first_orientation + orientation_count
    inner_count = first_passive + passive_count
    first_motor = inner_count + platform_count
    return SlotLayout(
        strain_count=strain_count,
        first_multiplier=strain_count,
        position_count=position_count,
        first_orientation=first_orientation,
        orientation_count=orientation_count,
        first_passive=first_passive,
        passive_count=passive_count,
        inner_count=inner_count,
        first_platform=inner_count,
        platform_count=platform_count,
        first_motor=first_motor,
        motor_count=motor_count,
        total=first_motor + motor_count,
        first_coupled=0 if orientation_count else strain_count,
    )
