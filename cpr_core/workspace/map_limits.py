# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Strains and limit margins of many cells at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model.bending_strain import strains_in
from ..model.robot import Robot
from ..solving.limits import limits_of, with_strain_margins

__all__ = ["limit_margins", "limit_names", "map_strains"]

Floats = NDArray[np.float64]

#: States worked on at once, to save memory.
_AT_ONCE = 4096


def map_strains(robot: Robot, states: Floats) -> Floats:
    """Largest bending strain of every rod in states (M, N), (M, R); NaN where there is none."""
    known = np.flatnonzero(np.isfinite(states).all(axis=1))
    found = np.full((len(states), len(robot.rod_names)), np.nan)
    for begin in range(0, len(known), _AT_ONCE):
        some = known[begin : begin + _AT_ONCE]
        found[some] = strains_in(robot, states[some])
    return found


def limit_names(robot: Robot) -> tuple[str, ...]:
    """Names of the limits, (K,): both ends of a range have one."""
    return tuple(dict.fromkeys(_names_of_ends(robot)))


def _names_of_ends(robot: Robot) -> list[str]:
    """Of every limit, in the order of ``limits_of``."""
    rods, motors = robot.rod_names, robot.motor_names
    return [
        f"{limit.kind} {(rods if limit.kind == 'strain_limit' else motors)[limit.number]}"
        for limit in limits_of(robot)
    ]


def limit_margins(robot: Robot, states: Floats, efforts: Floats) -> Floats:
    """How far every limit is, the nearer end of a range, in the order of ``limit_names``, (M, K).

    Args:
        robot: The robot.
        states: (M, N).
        efforts: (M, n) [N m or N].
    """
    found = robot.motor_limits.left(states[:, robot.kernel_arrays.motor_index :], efforts)
    if robot.limits_strain:
        found = with_strain_margins(robot, found, map_strains(robot, states))
    ends = _names_of_ends(robot)
    ranges = [number for number, name in enumerate(ends) if name not in ends[:number]]
    nearest: Floats = np.minimum.reduceat(found, ranges, axis=1) if ranges else found
    return nearest
