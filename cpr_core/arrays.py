"""The robot and its loads as the kernels see them: plain arrays.

Global state and equations share one order: for every leg its passive base coordinate (if any), its
strain coordinates and its multipliers; then the platform; then the motors. In this order the tangent
is block-arrow shaped, and the forward problem is a leading principal block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["LEG", "LoadArrays", "RobotArrays", "Workspace", "workspace"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: What is of fixed size for every leg. Frames and directions are in the world unless said otherwise.
LEG = np.dtype(
    [
        ("length", "f8"),  # rod length [m]; the nominal one where the leg is extensible
        ("rest_energy", "f8"),  # int kappa_rest^T H_a kappa_rest
        ("base_position", "f8", 3),  # base point at motor zero [m]
        ("base_rotation", "f8", (3, 3)),  # base frame at motor zero
        ("rotation_axis", "f8", 3),  # unit axis of the coordinate that turns the base
        ("translation_axis", "f8", 3),  # unit direction of the coordinate that shifts it
        ("tip_position", "f8", 3),  # tip joint in the platform frame [m]
        ("joint_rotation", "f8", (3, 3)),  # joint frame in the platform frame, R_c
        ("orientation", "f8", (3, 3, 3)),  # M_k of psi_k = tr((R_p R_c M_k)^T R_l)
        ("orientation_count", "i8"),  # how many of them
        ("rotation_index", "i8"),  # state index of the turn; -1: none
        ("translation_index", "i8"),  # state index of the shift; -1: none
        ("extensible", "i8"),  # 1: the shift is the rod length
        ("strain_index", "i8"),  # state index of the first strain coordinate
        ("strain_count", "i8"),
        ("multiplier_index", "i8"),  # state index of the first multiplier
    ],
    align=True,
)


class RobotArrays(NamedTuple):
    """Constants of L legs, at most M strain coordinates, K nodes and G rotation steps a leg."""

    legs: NDArray[np.void]  # (L,) of LEG
    direction: Integers  # (L, M) strain component: 0 torsion, 1 and 2 bending
    values: Floats  # (L, M, K) shape functions at the nodes
    step_values: Floats  # (L, M, 3, G) and at the Gauss points of the rotation steps
    stiffness: Floats  # (L, M, M) K_e at the nominal length
    rest_moment: Floats  # (L, M) int Phi^T H_a kappa_rest
    weights: Floats  # (K,)
    integration: Floats  # (K, K): [j, k] weight of node j in the integral from 0 to node k
    steps: Floats  # (G,) lengths of the rotation steps in sigma
    step_node: Integers  # (G,) node reached at the end of a step; -1: none
    position_axes: Integers  # world axes along which tips are held: (0, 1, 2), in the plane (0, 1)
    platform_axes: Integers  # components of the world twist [omega; v] the platform has
    unit: Floats  # (N,) natural unit of every state: dimensionless = state / unit
    energy_unit: float  # natural unit of energy, E J / l [J]
    platform_index: int  # state index of the first platform coordinate
    motor_index: int  # state index of the first motor


class LoadArrays(NamedTuple):
    """Loads in force, all linear in what the user gives, so that loads can be interpolated."""

    distributed: Floats  # (L, 3, K + 1) int_sigma^1 of the force per length; last: sigma = 0 [N/m]
    point: Floats  # (L, 3, K + 1) sum of the point forces beyond a node; last: sigma = 0 [N]
    platform: Floats  # (6, 3) weight, centre of mass, moment and force fixed in space, following


class Workspace(NamedTuple):
    """Memory of the kernels, allocated once for a whole solve."""

    fields: Floats  # (10, 3, 3, K)
    vectors: Floats  # (12, 3)
    matrices: Floats  # (8, 3, 3)
    densities: Floats  # (3 M + 3, K)
    integrals: Floats  # (3 M + 3, K)
    curvature: Floats  # (3, 3, G)
    vectors_of_steps: Floats  # (3, G)
    modes: Floats  # (M, M)
    elastic: Floats  # (M,)


def workspace(robot: RobotArrays) -> Workspace:
    """Memory for one thread."""
    modes, nodes = robot.values.shape[1:]
    steps = len(robot.steps)
    return Workspace(
        fields=np.empty((10, 3, 3, nodes)),
        vectors=np.empty((12, 3)),
        matrices=np.empty((8, 3, 3)),
        densities=np.zeros((3 * modes + 3, nodes)),
        integrals=np.empty((3 * modes + 3, nodes)),
        curvature=np.empty((3, 3, steps)),
        vectors_of_steps=np.empty((3, steps)),
        modes=np.empty((modes, modes)),
        elastic=np.empty(modes),
    )
