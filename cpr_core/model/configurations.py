# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far configurations are apart, dimensionless, and when they are the same equilibrium.

Configurations are rows as ``Equilibrium.configuration``: state, R_p row by row and p_p.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..validation import read_only
from .robot import Robot

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
    units = robot.kept("units of a configuration", lambda: _units(robot, robot.arrays.unit))
    apart: Floats = np.abs((first - last) / units).max(axis=-1)
    return apart


def leg_units(robot: Robot) -> Floats:
    """Units of a configuration, (N + 12,), of which only leg coordinates and the platform count.

    The other units are infinite: motors are given, multipliers follow.
    """
    return robot.kept("units of legs and platform", lambda: _leg_units(robot))


def _leg_units(robot: Robot) -> Floats:
    state = np.full(robot.state_size, np.inf)
    state[robot.elastic_indices] = robot.arrays.unit[robot.elastic_indices]
    return _units(robot, state)


def _units(robot: Robot, state: Floats) -> Floats:
    return read_only(np.concatenate([state, np.ones(9), np.full(3, robot.mean_length)]))
