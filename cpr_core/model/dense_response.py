# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour from the whole tangent: of every coordinate, and where legs are straight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..validation import ReadOnlyArrays
from .linearisation import Response
from .model_state import ModelState

__all__ = ["DenseResponse", "body_tangent", "dense_response", "platform_turn"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DenseResponse(ReadOnlyArrays):
    """What motors and wrench change, the platform's part as body twist and body wrench.

    Attributes:
        moved: Legs, multipliers and platform by motors, then wrench, (N - n, n + platform).
        efforts: Efforts by the same, (n, n + platform).
    """

    moved: Floats
    efforts: Floats

    def of_platform(self, platform: NDArray[np.int64]) -> Response:
        """Without legs and multipliers; ``platform`` are the state indices of the platform."""
        return Response(np.vstack([self.moved[platform], self.efforts]), len(self.efforts))


def platform_turn(solution: ModelState) -> Floats:
    """Twists of the platform in the world by its body twists, (platform, platform)."""
    turn = np.zeros((6, 6))
    turn[ANGULAR, ANGULAR] = turn[LINEAR, LINEAR] = solution.platform_rotation
    axes = solution.robot.platform_axes
    return turn[np.ix_(axes, axes)]


def body_tangent(solution: ModelState) -> Floats:
    """Tangent of the model with the platform in body coordinates, in state order, (N, N)."""
    platform, turn = solution.robot.platform_indices, platform_turn(solution)
    tangent = solution.tangent
    tangent[:, platform] = tangent[:, platform] @ turn
    tangent[platform, :] = turn.T @ tangent[platform, :]
    return tangent


@on_one_blas_thread
def dense_response(solution: ModelState) -> DenseResponse:
    """Solve with the tangent at an equilibrium, for every motor and every wrench."""
    robot, tangent = solution.robot, body_tangent(solution)
    inner = robot.kernel_arrays.motor_index
    motors, platform = robot.motor_indices, robot.platform_indices
    right = np.zeros((inner, len(motors) + len(platform)))
    right[:, : len(motors)] = -tangent[:inner, motors]
    right[platform, len(motors) + np.arange(len(platform))] = 1.0
    unit = robot.kernel_arrays.unit[:inner]
    scaled = tangent[:inner, :inner] * unit[:, None] * unit
    moved = unit[:, None] * scipy.linalg.solve(scaled, unit[:, None] * right)
    efforts = tangent[motors, :inner] @ moved
    efforts[:, : len(motors)] += tangent[np.ix_(motors, motors)]
    return DenseResponse(moved, efforts)
