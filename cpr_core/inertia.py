"""Stability indices of an equilibrium from one symmetric elimination (Sylvester's law)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from .inertia_kernel import SINGULAR_LEG, signs_of
from .lie import angle_motions
from .model_kernel import assemble

if TYPE_CHECKING:
    from .arrays import Factors, Workspace
    from .robot import Robot

__all__ = ["Inertia", "inertia_from", "inertia_of"]

Floats = NDArray[np.float64]


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


def inertia_of(
    robot: Robot, platform_rotation: Floats, work: Workspace, factors: Factors
) -> Inertia:
    """Signs of the tangent at an equilibrium.

    Args:
        robot: The robot.
        platform_rotation: R_p in the world, (3, 3), writeable.
        work: Workspace with the tangent there.
        factors: Its factors.
    """
    signs = np.empty(3, np.int64)
    columns, angles = robot.inverse_unknowns
    signs_of(robot.arrays, platform_rotation, factors, columns, angles, work, signs)
    return inertia_from(robot, signs, platform_rotation, work)


def inertia_from(
    robot: Robot, signs: NDArray[np.int64], platform_rotation: Floats, work: Workspace
) -> Inertia:
    """The result of ``signs_of``, or all eigenvalues where the legs were not condensed."""
    if signs[0] != SINGULAR_LEG:
        return Inertia(*signs.tolist())
    tangent = np.zeros_like(work.tangent)
    assemble(robot.arrays, work, tangent)
    if robot.controls_angles:  # the unknown ones among roll, pitch, yaw are columns of their own
        turns = robot.platform_indices[:3]
        motions = angle_motions(platform_rotation)
        tangent[:, turns] = tangent[:, turns] @ motions
        tangent[turns] = motions.T @ tangent[turns]
    return _dense(robot, tangent, robot.inverse_unknowns[0])


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
