"""The geometrico-static model, Eq. (32), and its exact tangent for the whole robot."""

from __future__ import annotations

import numpy as np

from .compiled import compiled
from .leg_kernel import evaluate_leg
from .lie import rotate

__all__ = ["evaluate_model"]


@compiled
def evaluate_model(
    robot, loads, state, platform_rotation, platform_position, residual, tangent, work
):
    """Residual and tangent of the model at any state, in equilibrium or not.

    The equations are the derivatives of the Lagrangian ``U + Psi . lambda`` (Eq. (49)) by the state:
    balance of passive and strain coordinates, constraints Psi, balance of the platform in the world
    frame at its origin, and in the motor rows the efforts tau_a the motors have to give.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        state: Shape (N,); the platform entries are not read.
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,).
        residual: Result, (N,).
        tangent: Result, (N, N): derivative of the residual by the state, the platform moved by small
            world rotations and translations. Entries that are always zero are not written.
        work: Workspace.

    Returns:
        Potential energy without the work of motors and of non-conservative loads [J].
    """
    platform_residual = np.zeros(6)
    platform_tangent = np.zeros((6, 6))
    slot = np.full(6, -1, np.int64)
    for row in range(robot.platform_axes.shape[0]):
        slot[robot.platform_axes[row]] = robot.platform_index + row

    energy = 0.0
    for leg in range(robot.legs.shape[0]):
        energy += evaluate_leg(
            robot, loads, leg, state, platform_rotation, platform_position,
            residual, tangent, platform_residual, platform_tangent, slot, work,
        )  # fmt: skip
    energy += _add_platform_loads(
        loads, platform_rotation, platform_position, platform_residual, platform_tangent, work
    )
    for i in range(6):
        if slot[i] >= 0:
            residual[slot[i]] = platform_residual[i]
            for j in range(6):
                if slot[j] >= 0:
                    tangent[slot[i], slot[j]] = platform_tangent[i, j]
    return energy


@compiled
def _add_platform_loads(loads, rotation, position, residual, tangent, work):
    """Weight and wrench of the platform; returns their potential [J]."""
    weight, moment_world, force_world = loads.platform[0], loads.platform[2], loads.platform[3]
    center, moment_body, force_body = work.vectors[0], work.vectors[1], work.vectors[2]
    rotate(rotation, loads.platform[1], center)
    rotate(rotation, loads.platform[4], moment_body)
    rotate(rotation, loads.platform[5], force_body)
    energy = 0.0
    dot = center[0] * weight[0] + center[1] * weight[1] + center[2] * weight[2]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        residual[i] -= (
            moment_world[i] + moment_body[i] + center[j] * weight[k] - center[k] * weight[j]
        )
        residual[3 + i] -= force_world[i] + force_body[i] + weight[i]
        energy -= force_world[i] * position[i] + weight[i] * (position[i] + center[i])
        for n in range(3):
            tangent[i, n] -= center[i] * weight[n]
        tangent[i, i] += dot
        # Small rotations turn following loads: -(omega x m), -(omega x f).
        tangent[i, j] -= moment_body[k]
        tangent[i, k] += moment_body[j]
        tangent[3 + i, j] -= force_body[k]
        tangent[3 + i, k] += force_body[j]
    return energy
