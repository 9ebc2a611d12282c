# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The motion of a smallest eigenvalue, motors held, with the multipliers it goes with.

With them it is an eigenvector of the bordered pencil ``K v = mu M v``, which has no basis of admissible
motions in it. So ``v^T (K - mu M) v / v^T M v`` of a changed K and M, the vector as it is, tells to
first order how the eigenvalue changes, however near to it others are.
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

#: What the size of a motion is: that of the dimensionless motion, or its elastic energy (the margin).
SizeOfMotion = Literal["unit", "elastic"]


@dataclass(frozen=True, eq=False)
class SoftestMotion:
    """A smallest eigenvalue and its motion.

    Attributes:
        size: What the eigenvalue is relative to.
        eigenvalue: It [J] (unit), or without dimension (elastic).
        motion: Legs and platform, world twist; multipliers beside them; motors are zero, (N,).
    """

    size: SizeOfMotion
    eigenvalue: float
    motion: Floats

    @on_one_numpy_thread
    def change(self, nearby: Equilibrium) -> float:
        """By how much the eigenvalue is another one nearby, to first order."""
        motion, squared = self.motion, _squared_size(nearby, self.size, self.motion)
        return float(motion @ (nearby.tangent @ motion)) / squared - self.eigenvalue


@on_one_blas_thread
def softest_motion(equilibrium: Equilibrium, size: SizeOfMotion) -> SoftestMotion | None:
    """The motion of the smallest eigenvalue; None where there is none, or one stores no energy."""
    robot = equilibrium.robot
    moving = robot.moving_indices
    held, unit = robot.multiplier_indices, robot.arrays.unit[moving]
    tangent = equilibrium.tangent
    stiffness, constraints = tangent[np.ix_(moving, moving)], tangent[np.ix_(held, moving)]
    stiffness = 0.5 * (stiffness + stiffness.T)
    measure = _measure(equilibrium, size)
    basis = unit[:, None] * null_space_of(constraints * unit)
    if not basis.shape[1]:
        return None
    own, weights = (basis.T @ matrix @ basis for matrix in (stiffness, measure))
    try:
        values, vectors = scipy.linalg.eigh(own, weights, subset_by_index=[0, 0])
    except np.linalg.LinAlgError:
        return None
    motion, moved = np.zeros(len(equilibrium.state)), basis @ vectors[:, 0]
    left = values[0] * (measure @ moved) - stiffness @ moved
    motion[moving] = moved
    motion[held] = scipy.linalg.lstsq(unit[:, None] * constraints.T, unit * left)[0]
    return SoftestMotion(size, float(values[0]), motion)


def _measure(equilibrium: Equilibrium, size: SizeOfMotion) -> Floats:
    """M of legs and platform."""
    robot = equilibrium.robot
    moving = robot.moving_indices
    own = np.ix_(moving, moving)
    if size == "elastic":
        return elastic_hessian(equilibrium)[own]
    inverse = np.linalg.inv(robot.unit_motions[own])
    return np.asarray(inverse.T @ inverse)


def _squared_size(equilibrium: Equilibrium, size: SizeOfMotion, motion: Floats) -> float:
    """``v^T M v``, without M where that takes longer."""
    robot = equilibrium.robot
    if size == "elastic":
        return float(motion @ (elastic_hessian(equilibrium) @ motion))
    moving = robot.moving_indices
    units = np.linalg.solve(robot.unit_motions[np.ix_(moving, moving)], motion[moving])
    return float(units @ units)
