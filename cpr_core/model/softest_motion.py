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
        stiffness, measure = _pencil(nearby, self.size)
        weighed = measure @ self.motion
        rest = stiffness @ self.motion - self.eigenvalue * weighed
        return float(self.motion @ rest / (self.motion @ weighed))


@on_one_blas_thread
def softest_motion(equilibrium: Equilibrium, size: SizeOfMotion) -> SoftestMotion | None:
    """The motion of the smallest eigenvalue; None where there is none, or one stores no energy."""
    robot = equilibrium.robot
    moving = np.concatenate([robot.elastic_indices, robot.platform_indices])
    held, unit = robot.multiplier_indices, robot.arrays.unit[moving]
    stiffness, measure = _pencil(equilibrium, size)
    constraints = stiffness[np.ix_(held, moving)]
    basis = unit[:, None] * null_space_of(constraints * unit)
    if not basis.shape[1]:
        return None
    own, weights = (
        basis.T @ matrix[np.ix_(moving, moving)] @ basis for matrix in (stiffness, measure)
    )
    try:
        values, vectors = scipy.linalg.eigh(own, weights, subset_by_index=[0, 0])
    except np.linalg.LinAlgError:
        return None
    motion = np.zeros(len(equilibrium.state))
    motion[moving] = basis @ vectors[:, 0]
    left = values[0] * measure @ motion - stiffness @ motion
    balance = unit[:, None] * constraints.T
    motion[held] = scipy.linalg.lstsq(balance, unit * left[moving])[0]
    return SoftestMotion(size, float(values[0]), motion)


def _pencil(equilibrium: Equilibrium, size: SizeOfMotion) -> tuple[Floats, Floats]:
    """K and M in state order, (N, N) each; zero for motors."""
    robot = equilibrium.robot
    moving = np.concatenate([robot.elastic_indices, robot.platform_indices])
    tangent = equilibrium.model_state.tangent
    stiffness, measure = np.zeros_like(tangent), np.zeros_like(tangent)
    own, held = np.ix_(moving, moving), np.ix_(robot.multiplier_indices, moving)
    stiffness[own] = 0.5 * (tangent[own] + tangent[own].T)
    stiffness[held] = tangent[held]
    stiffness[np.ix_(moving, robot.multiplier_indices)] = tangent[held].T
    if size == "elastic":
        measure[own] = elastic_hessian(equilibrium.model_state)[own]
    else:
        inverse = np.linalg.inv(robot.unit_motions[own])
        measure[own] = inverse.T @ inverse
    return stiffness, measure
