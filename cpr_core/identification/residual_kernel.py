# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured less modelled, of efforts and the platform's pose, in compiled code.

In Python it takes a tenth of an estimate of a wrench, and is asked for two times in each.
"""

from __future__ import annotations

from ..kernels.kernel_decorators import kernel
from ..kernels.record_layout import EFFORT, POSITION, ROTATION
from ..kernels.rotation_matrices import rotation_log_into

__all__ = ["residual_into"]


@kernel
def residual_into(efforts, position, rotation, axes, weights, record, behind, twist, residual):
    """Residual in standard deviations into an array (M,): of efforts, then of platform coordinates.

    Nine arrays by themselves, as taking tuples from Python apart takes a microsecond.

    Args:
        efforts: Measured, (n,) [N m or N]; empty where they are not.
        position: Of the platform in the world, (3,) [m]; read where a pose is measured.
        rotation: Of the platform in the world, (3, 3).
        axes: Platform coordinates, (b,).
        weights: One over standard deviations, (M,).
        record: Record of the equilibrium.
        behind: Where the numbers behind the state begin in it.
        twist: Memory, (2, 3, 3): the turn between the rotations, and its logarithm over a shift.
        residual: Overwritten.
    """
    count = efforts.shape[0]
    for motor in range(count):
        residual[motor] = weights[motor] * (efforts[motor] - record[behind + EFFORT + motor])
    if residual.shape[0] == count:
        return
    turn, moved = twist[0], twist[1]
    for i in range(3):
        for j in range(3):
            turn[i, j] = 0.0
            for k in range(3):
                turn[i, j] += rotation[i, k] * record[behind + ROTATION + 3 * j + k]
        moved[1, i] = position[i] - record[behind + POSITION + i]
    rotation_log_into(turn, moved[0])
    for row in range(axes.shape[0]):
        axis = axes[row]
        residual[count + row] = weights[count + row] * moved[axis // 3, axis % 3]
