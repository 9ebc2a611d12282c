# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The geometrico-static model, Eq. (32), and its tangent at a state, for use from Python."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .kernel_arrays import LoadArrays
from .prepared_robot import evaluate_prepared

if TYPE_CHECKING:
    from .equilibrium import Equilibrium
    from .robot import Robot

__all__ = ["ModelValue", "evaluate", "tangent_at"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModelValue:
    """Residual and tangent at one state, in the state order of the robot.

    Attributes:
        residual: Derivative of the Lagrangian by every state; motor rows hold the efforts, (N,).
        tangent: Its derivative, (N, N); symmetric at equilibrium under conservative loads.
        energy: Potential energy [J].
    """

    residual: Floats
    tangent: Floats
    energy: float


def evaluate(
    robot: Robot,
    loads: LoadArrays,
    state: Floats,
    platform_rotation: Floats,
    platform_position: Floats,
) -> ModelValue:
    """The model at any state, in equilibrium or not (SI units, world frame)."""
    residual = np.empty(len(state))
    tangent = np.zeros((len(state), len(state)))
    # Copies: read-only arrays are another type to numba, for which it would compile all again.
    rotation, position = platform_rotation.copy(), platform_position.copy()
    energy = evaluate_prepared(
        robot.prepared, loads, state.copy(), rotation, position, residual, tangent
    )
    return ModelValue(residual, tangent, energy)


def tangent_at(equilibrium: Equilibrium) -> Floats:
    """Tangent of the model at an equilibrium, (N, N)."""
    return evaluate(
        equilibrium.robot,
        equilibrium.load_arrays,
        equilibrium.state,
        equilibrium.platform_rotation,
        equilibrium.platform_position,
    ).tangent
