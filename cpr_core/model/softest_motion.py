# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The motions of a smallest eigenvalue, motors held, with the multipliers they go with.

With them they are eigenvectors of the bordered pencil ``K v = mu M v``, which has no basis of admissible
motions in it. So ``v^T (K - mu M) v / v^T M v`` of a changed K and M, the vector as it is, tells to
first order how the eigenvalue changes, however near to it others are. Symmetric robots have several
motions of one eigenvalue: of ``V^T (K - mu M) V`` the eigenvalues tell how it parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread, on_one_numpy_thread
from .equilibrium import Equilibrium
from .stability import elastic_hessian, null_space_of

__all__ = ["SizeOfMotion", "SoftestMotion", "softest_motion"]

Floats = NDArray[np.float64]

#: Eigenvalues nearer to each other than this part of them are one.
_ONE = 1e-8

#: What the size of a motion is: that of the dimensionless motion, or its elastic energy (the margin).
SizeOfMotion = Literal["unit", "elastic"]


@dataclass(frozen=True, eq=False)
class SoftestMotion:
    """A smallest eigenvalue and its motions, K of them: more than one in robots that are symmetric.

    Attributes:
        size: What the eigenvalue is relative to.
        eigenvalue: It [J] (unit), or without dimension (elastic).
        motions: Legs and platform, world twist; multipliers beside them; motors are zero, (N, K).
    """

    size: SizeOfMotion
    eigenvalue: float
    motions: Floats

    @on_one_numpy_thread
    def change(self, nearby: Equilibrium) -> Floats:
        """How the eigenvalue is another one nearby, to first order, between its motions, (K, K)."""
        motions, squared = self.motions, _squared_size(nearby, self.size, self.motions)
        moved = motions.T @ (nearby.tangent @ motions)
        unit = np.linalg.inv(np.linalg.cholesky(squared))
        return np.asarray(unit @ (0.5 * (moved + moved.T)) @ unit.T) - self.eigenvalue * np.eye(
            len(squared)
        )


@on_one_blas_thread
def softest_motion(equilibrium: Equilibrium, size: SizeOfMotion) -> SoftestMotion | None:
    """The motions of the smallest eigenvalue; None where there is none, or one stores no energy."""
    robot = equilibrium.robot
    moving = robot.moving_indices
    held, unit = robot.multiplier_indices, robot.kernel_arrays.unit[moving]
    tangent = equilibrium.tangent
    stiffness, constraints = tangent[np.ix_(moving, moving)], tangent[np.ix_(held, moving)]
    stiffness = 0.5 * (stiffness + stiffness.T)
    measure = _measure(equilibrium, size)
    basis = unit[:, None] * null_space_of(constraints * unit)
    if not basis.shape[1]:
        return None
    own, weights = (basis.T @ matrix @ basis for matrix in (stiffness, measure))
    try:
        values, vectors = scipy.linalg.eigh(own, weights)
    except np.linalg.LinAlgError:
        return None
    count = int(np.sum(values - values[0] <= _ONE * abs(values[0])))
    motions, moved = np.zeros((len(equilibrium.state), count)), basis @ vectors[:, :count]
    left = values[0] * (measure @ moved) - stiffness @ moved
    motions[moving] = moved
    motions[held] = scipy.linalg.lstsq(unit[:, None] * constraints.T, unit[:, None] * left)[0]
    return SoftestMotion(size, float(values[0]), motions)


def _measure(equilibrium: Equilibrium, size: SizeOfMotion) -> Floats:
    """M of legs and platform."""
    robot = equilibrium.robot
    moving = robot.moving_indices
    own = np.ix_(moving, moving)
    if size == "elastic":
        return elastic_hessian(equilibrium)[own]
    inverse = np.linalg.inv(robot.unit_motions[own])
    return np.asarray(inverse.T @ inverse)


def _squared_size(equilibrium: Equilibrium, size: SizeOfMotion, motions: Floats) -> Floats:
    """``V^T M V``, without M where that takes longer, (K, K)."""
    robot = equilibrium.robot
    if size == "elastic":
        return np.asarray(motions.T @ (elastic_hessian(equilibrium) @ motions))
    moving = robot.moving_indices
    units = np.linalg.solve(robot.unit_motions[np.ix_(moving, moving)], motions[moving])
    return np.asarray(units.T @ units)
