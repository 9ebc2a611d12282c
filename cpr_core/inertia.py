"""Stability indices of an equilibrium from one symmetric elimination (Sylvester's law)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from .inertia_kernel import SINGULAR_LEG, signs_of
from .lie import angle_motions

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["Inertia", "inertia_of"]

Floats = NDArray[np.float64]

_NONE = np.zeros(0, np.int64)


class Inertia(NamedTuple):
    """Signs of the tangent at an equilibrium. Two neighbours of a branch differ where one vanishes.

    Attributes:
        index_locked: Negative eigenvalues of H_r with the motors held.
        index_free: With the motors at constant effort.
        inverse_sign: Sign of the determinant of the inverse problem; 0 where there is none.
    """

    index_locked: int
    index_free: int
    inverse_sign: int


def inertia_of(robot: Robot, tangent: Floats, platform_rotation: Floats) -> Inertia:
    """Signs of a tangent.

    Args:
        robot: The robot.
        tangent: Of the model, (N, N); its symmetric part is read.
        platform_rotation: R_p in the world, (3, 3).
    """
    columns = robot.problems["platform"][0] if len(robot.controlled_axes) else _NONE
    if robot.controls_angles:  # the unknown ones among roll, pitch, yaw are columns of their own
        turns = robot.platform_indices[:3]
        motions = angle_motions(platform_rotation)
        tangent = tangent.copy()
        tangent[:, turns] = tangent[:, turns] @ motions
        tangent[turns] = motions.T @ tangent[turns]
    signs = np.empty(3, np.int64)
    signs_of(robot.arrays, tangent, columns, signs)
    if signs[0] == SINGULAR_LEG:
        return _dense(robot, tangent, columns)
    return Inertia(*signs.tolist())


def _dense(robot: Robot, tangent: Floats, columns: NDArray[np.int64]) -> Inertia:
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
    return Inertia(index(scaled[:inner, :inner]), index(scaled), sign)
