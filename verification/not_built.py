# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which robots are not built in other programs, and why."""

from __future__ import annotations

from cpr_core import load_robot
from cpr_core.description.description_file import shipped_robots

from .placed_robot import NotPossible, placed

__all__ = ["robots_not_built"]


def robots_not_built() -> tuple[str, ...]:
    """The shipped robots that are built in none of the programs, and what of them is not."""
    lines = []
    for name in shipped_robots():
        description = load_robot(name).description
        try:
            placed(description, description.home.motors)
        except NotPossible as reason:
            lines.append(f"{name}, in none of the programs: {reason}")
    return tuple(lines)
