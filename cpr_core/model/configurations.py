# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far configurations are apart, dimensionless, and when they are the same equilibrium.

Configurations are rows as ``Equilibrium.configuration``: state, R_p row by row and p_p.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..description.chain import Turn
from ..validation import read_only
from .robot import Robot, kept_with_robot

__all__ = [
    "SAME_EQUILIBRIUM",
    "configuration_distance",
    "configuration_rows",
    "leg_distance",
    "leg_units",
]

Floats = NDArray[np.float64]

#: Equilibria that differ by less, dimensionless, are the same.
SAME_EQUILIBRIUM = 1e-5


def configuration_rows(state: Floats, rotation: Floats, position: Floats) -> Floats:
    """B configurations as rows, (B, N + 12)."""
    return np.concatenate([state, rotation.reshape(-1, 9), position], axis=1)


def configuration_distance(robot: Robot, first: Floats, last: Floats) -> Floats:
    """Largest dimensionless difference of configurations, of multipliers and motors too, (...).

    Passive joints without a spring that differ by whole turns are where they were.

    Args:
        robot: Their robot.
        first: Configurations, (..., N + 12).
        last: As many.
    """
    return _distance(robot, first, last, _whole_units(robot))


def leg_distance(robot: Robot, first: Floats, last: Floats) -> Floats:
    """The same of leg coordinates and the platform alone."""
    return _distance(robot, first, last, leg_units(robot))


def _distance(robot: Robot, first: Floats, last: Floats, units: Floats) -> Floats:
    difference, free = first - last, _free_turns(robot)
    if free:
        turns = np.round(difference[..., free] / (2.0 * np.pi))
        difference[..., free] -= 2.0 * np.pi * turns
    apart: Floats = np.abs(difference / units).max(axis=-1)
    return apart


@kept_with_robot
def _free_turns(robot: Robot) -> list[int]:
    """State indices of the passive joints that turn and have no spring."""
    return [
        index
        for joint, index in robot.passive_joints
        if isinstance(joint, Turn) and joint.stiffness == 0.0
    ]


@kept_with_robot
def leg_units(robot: Robot) -> Floats:
    """Units of a configuration, (N + 12,), of which only leg coordinates and the platform count.

    The other units are infinite: motors are given, multipliers follow.
    """
    state = np.full(robot.state_size, np.inf)
    state[robot.elastic_indices] = robot.kernel_arrays.unit[robot.elastic_indices]
    return _units(robot, state)


@kept_with_robot
def _whole_units(robot: Robot) -> Floats:
    return _units(robot, robot.kernel_arrays.unit)


def _units(robot: Robot, state: Floats) -> Floats:
    return read_only(np.concatenate([state, np.ones(9), np.full(3, robot.mean_length)]))
