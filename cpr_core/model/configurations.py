# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far configurations are apart, dimensionless, and when they are the same equilibrium.

Configurations are rows as ``Equilibrium.configuration``: state, R_p row by row and p_p.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..validation import read_only
from .robot import Robot, kept_with_robot

__all__ = ["SAME_EQUILIBRIUM", "configuration_distance", "configuration_rows", "leg_units"]

Floats = NDArray[np.float64]

#: Equilibria that differ by less, dimensionless, are the same.
SAME_EQUILIBRIUM = 1e-5


def configuration_rows(state: Floats, rotation: Floats, position: Floats) -> Floats:
    """B configurations as rows, (B, N + 12)."""
    return np.concatenate([state, rotation.reshape(-1, 9), position], axis=1)


def configuration_distance(robot: Robot, first: Floats, last: Floats) -> Floats:
    """Largest dimensionless difference of configurations, of multipliers and motors too, (...).

    Args:
        robot: Their robot.
        first: Configurations, (..., N + 12).
        last: As many.
    """
    apart: Floats = np.abs((first - last) / _whole_units(robot)).max(axis=-1)
    return apart


@kept_with_robot
def leg_units(robot: Robot) -> Floats:
    """Units of a configuration, (N + 12,), of which only leg coordinates and the platform count.

    The other units are infinite: motors are given, multipliers follow.
    """
    state = np.full(robot.state_size, np.inf)
    state[robot.elastic_indices] = robot.arrays.unit[robot.elastic_indices]
    return _units(robot, state)


@kept_with_robot
def _whole_units(robot: Robot) -> Floats:
    return _units(robot, robot.arrays.unit)


def _units(robot: Robot, state: Floats) -> Floats:
    return read_only(np.concatenate([state, np.ones(9), np.full(3, robot.mean_length)]))
