# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The geometrico-static model, Eq. (32), and its tangent at a state, for use from Python."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.prepared_robot import evaluate_prepared
from ..kernels.record_layout import POSITION, ROTATION
from ..kernels.square_problem import Configuration
from ..validation import cached_property, read_only
from .robot import Robot

__all__ = ["ModelState", "ModelValue", "configuration_of", "evaluate"]

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


@dataclass(frozen=True, eq=False)
class ModelState:
    """A state of the model under loads, in equilibrium or not.

    Attributes:
        robot: The robot.
        loads: Loads in force.
        load_arrays: The same as the kernels see them.
        record: It begins as that of an equilibrium does, see `record_layout`; never to be written.
    """

    robot: Robot
    loads: Loads
    load_arrays: LoadArrays
    record: Floats

    def _part(self, first: int, count: int) -> Floats:
        """Numbers behind the state, read-only."""
        start = self.robot.state_size + first
        return read_only(self.record[start : start + count])

    @cached_property
    def state(self) -> Floats:
        """Motor, leg and multiplier values in the order of the kernels, read-only, (N,)."""
        size = self.robot.state_size
        return self._part(-size, size)

    @cached_property
    def platform_rotation(self) -> Floats:
        """R_p in the world, (3, 3)."""
        return self._part(ROTATION, 9).reshape(3, 3)

    @cached_property
    def platform_position(self) -> Floats:
        """p_p in the world, (3,) [m]."""
        return self._part(POSITION, 3)

    @property
    def tangent(self) -> Floats:
        """Tangent of the model, in the state order of the robot, (N, N)."""
        return evaluate(self.robot, self.load_arrays, *configuration_of(self)).tangent


def configuration_of(found: ModelState) -> Configuration:
    """Where the robot is there, apart from the loads it bears."""
    return Configuration(found.state, found.platform_rotation, found.platform_position)


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
