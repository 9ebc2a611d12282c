# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Strains and limit margins of many cells at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model.robot import Robot
from ..solving.limits import motor_margins

__all__ = ["limit_margins", "map_strains"]

Floats = NDArray[np.float64]

#: States worked on at once, to save memory.
_AT_ONCE = 4096


def map_strains(robot: Robot, states: Floats) -> Floats:
    """Largest bending strain of every rod, as ``bending_strains``, (M, R).

    Args:
        robot: The robot.
        states: (M, N); NaN where there is none.
    """
    strains = np.full((len(states), len(robot.strain_limits)), np.nan)
    for number, (rod, values, rest) in enumerate(
        zip(robot.numbers.rods, *robot.curvature_stations, strict=True)
    ):
        described = rod.element.rod
        for begin in range(0, len(states), _AT_ONCE):
            some = states[begin : begin + _AT_ONCE]
            curvature = np.einsum("pcm,bm->bpc", values, some[:, rod.strain]) - rest
            if rod.length_index is not None:
                curvature *= (described.length / some[:, rod.length_index])[:, None, None]
            bending = described.bending_strain_at(robot.curvature_sigma, curvature)
            strains[begin : begin + _AT_ONCE, number] = bending.max(axis=1)
    return strains


def limit_margins(robot: Robot, states: Floats, efforts: Floats) -> Floats:
    """How far every limit is, as ``limits.margins``, (M, K).

    Args:
        robot: The robot.
        states: (M, N).
        efforts: (M, n) [N m or N].
    """
    found = motor_margins(robot, states[:, robot.arrays.motor_index :], efforts)
    if not robot.limits_strain:
        return found
    left = 1.0 - map_strains(robot, states) / robot.strain_limits
    return np.concatenate([found, left[:, np.isfinite(robot.strain_limits)]], axis=1)
