# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stability indices of an equilibrium from one symmetric elimination (Sylvester's law)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from .continuation_kernel import SIGNS
from .inertia_kernel import SINGULAR_LEG
from .lie import angle_motions
from .model import tangent_at

if TYPE_CHECKING:
    from .equilibrium import Equilibrium
    from .robot import Robot

__all__ = ["TangentSigns", "signs_at_equilibrium"]

Floats = NDArray[np.float64]


class TangentSigns(NamedTuple):
    """Signs of the tangent at an equilibrium. Two neighbours of a branch differ where one vanishes.

    Attributes:
        index_locked: Negative eigenvalues of H_r with the motors held.
        index_free: With the motors at constant effort.
        inverse_sign: Sign of the determinant of the inverse problem; 0 where there is none.
    """

    index_locked: int
    index_free: int
    inverse_sign: int


def signs_at_equilibrium(equilibrium: Equilibrium) -> TangentSigns:
    """The signs the kernels found, or all eigenvalues where the legs were not condensed."""
    robot = equilibrium.robot
    first = robot.state_size + SIGNS
    locked, free, inverse = equilibrium.record[first : first + 3].tolist()
    if locked != SINGULAR_LEG:
        return TangentSigns(int(locked), int(free), int(inverse))
    matrix = tangent_at(equilibrium)
    if robot.controls_angles:  # the unknown ones among roll, pitch, yaw are columns of their own
        turns = robot.platform_indices[:3]
        motions = angle_motions(equilibrium.platform_rotation)
        matrix[:, turns] = matrix[:, turns] @ motions
        matrix[turns] = motions.T @ matrix[turns]
    return _dense(robot, matrix, robot.arrays.inverse_unknowns)


def _dense(robot: Robot, tangent: Floats, columns: NDArray[np.int64]) -> TangentSigns:
    """The same from all eigenvalues, where a leg cannot be eliminated on its own."""
    unit, inner = robot.arrays.unit, robot.arrays.motor_index
    scaled = tangent * unit[:, None] * unit / robot.arrays.energy_unit
    scaled = 0.5 * (scaled + scaled.T)
    constraints = len(robot.multiplier_indices)

    def index(matrix: Floats) -> int:
        values = linalg.eigvalsh(matrix)
        return int(np.sum(values < -1e-11 * np.abs(values).max())) - constraints

    sign = 0
    if len(columns):
        legs = np.arange(robot.arrays.platform_index)
        rows = np.concatenate([legs, robot.problems["platform"][1]])
        sign = int(np.linalg.slogdet(scaled[np.ix_(rows, np.concatenate([legs, columns]))])[0])
    return TangentSigns(index(scaled[:inner, :inner]), index(scaled), sign)
