# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Memory that kernels work in, allocated once for many solves, and that of a factored tangent."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .kernel_arrays import RobotArrays
from .lanes import empty_lanes, zeros_lanes

__all__ = ["LANCZOS_STEPS", "Factors", "Workspace", "factors_of", "workspace"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Lanes = NDArray[np.void]

#: Most steps of Lanczos' method that a workspace has memory for.
LANCZOS_STEPS = 100


class Factors(NamedTuple):
    """A tangent with its legs condensed: n inner slots, m in all, a border of B = b + motors.

    It does not depend on the problem. Slots that were delayed, D of them, are left to the border.
    """

    upper: Lanes  # (G, n, m) rows of L^T, and of D^-1 L^-1 B
    inverse: Lanes  # (G, n) D^-1
    border: Floats  # (N, N), (B + D, B + D) of it H, world rotations, delayed slots last
    status: Integers  # (1,) CONDENSED, DELAYED or UNKNOWN of `condensation_kernel`
    delayed_count: Integers  # (1,) D
    delayed: Integers  # (N, 3) group, slot and lane of each
    beyond: Floats  # (N, n) their rows of D L^T, behind their own slots


class Workspace(NamedTuple):
    """Memory of the kernels, allocated once for a whole solve. m = n + b + m_a slots."""

    blocks: Lanes  # (G, m, m) tangent of the legs by slots, upper triangle
    residuals: Lanes  # (G, m) residual by slots, SI units
    platform_residual: Floats  # (6,) of the world twist
    platform_tangent: Floats  # (6, 6)
    coordinates: Lanes  # (m,) state by slots, that of motors times the ratio; not of the platform
    by_leg: Lanes  # (6,) written or read leg by leg, see `by_leg`
    motor_values: Lanes  # (m_a,) of motor slots, leg by leg
    rotation_vectors: Lanes  # (H, 3) of the steps
    element_position: Lanes  # (E + 1, 3) where the elements begin; the tip
    element_axis: Lanes  # (E, 3) axes of joints, in the world; where links lead
    element_center: Lanes  # (E, 3) centres of mass of links from where they begin
    slot_turn: Lanes  # (m, 3) T: turn of everything behind a coordinate
    slot_carried: Lanes  # (m, 3) w: what a turn T before takes from a coordinate's balance, T . w
    frames: Lanes  # (R, 3, K, 3) directions d_c = R e_c at the nodes; the first is the tangent t
    arm: Lanes  # (R, K + 1, 3) int_sigma^1 t: (p(l) - p) / l; last: sigma = 0, as with other fields
    point: Lanes  # (K + 1, 3) forces of the rods, as in LoadArrays
    distributed: Lanes  # (K + 1, 3)
    load_source: Lanes  # (3, K, 3) rows of l t n^T, n of the loads on the rods alone
    load_field: Lanes  # (3, K + 1, 3) rows of D, of the loads on the rods alone
    joint_moments: Lanes  # (3, 3) [condition, component] c of a multiplier of one
    density: Lanes  # (3, K, 3) omega of a shape function of one about d_c, weighted: l_0 w d_c
    turned: Lanes  # (3, K, 3) Q omega
    balance: Lanes  # (3, K) omega . m
    swept: Lanes  # (3, K, 3) omega x arm
    length_source: Lanes  # (K, 3) t x (n + l nu)
    length_field: Lanes  # (K + 1, 3) its integral to the tip: what the length does to m
    stretched: Lanes  # (S,) K_e q_e
    geometric: Lanes  # (S, S) what loads take from the stiffness
    pairs: Lanes  # (K, 2) two rows of P
    partial: Lanes  # (S, K) P times shape functions
    mode_turn: Lanes  # (S, 3) Theta_a where a panel begins
    mode_growth: Lanes  # (S, 3) what it grows by in the panel
    mode_carried: Lanes  # (S, 3) int_panel phi_a Q omega
    rows: Lanes  # (n, m) rows of D L^T
    solution: Lanes  # (G, n)
    border: Floats  # (N,) of the platform twist, the motors and delayed slots
    part: Floats  # (N,) of those that are unknown
    symmetric: Floats  # (N, N)
    square: Floats  # (N, N) LU factors of the part of the border a problem has
    pivots: Integers  # (N,)
    motions: Floats  # (3, 3) world rotations of the rotation unknowns, as columns
    step: Floats  # (N,) dimensionless
    correction: Floats  # (N,)
    simplified: Floats  # (N,)
    total: Floats  # (N,) sum of all corrections
    trial_state: Floats  # (N,)
    trial_rotation: Floats  # (3, 3)
    trial_position: Floats  # (3,)
    platform_step: Floats  # (6,) world twist by which a step moves the platform
    rotation_step: Floats  # (3, 3) its rotation
    rotated: Floats  # (3, 3) the rotation of the platform behind it
    angles: Floats  # (3,) roll, pitch, yaw of the platform
    turn: Floats  # (3,) rotation vector to what is imposed
    factors: Factors  # of the last tangent, where nobody wants to keep them
    delaying: Factors  # the same with slots delayed that hide digits, for its signs
    known: Floats  # (B,)
    efforts: Floats  # (motors,)
    effort_change: Floats  # (motors,)
    given_efforts: Floats  # (motors,) what a step imposes, or keeps
    given_motors: Floats  # (motors,)
    given_rotation: Floats  # (3, 3)
    given_position: Floats  # (3,)
    rotation: Floats  # (3, 3) of the platform, where a step is
    position: Floats  # (3,)
    residual: Floats  # (N,) in the order of the state
    signs: Integers  # (3,)
    bend_count: (
        Integers  # (1,) number of differences that tell how the branch bends; -1: nothing does
    )
    bend_order: Integers  # (1,) number of those that fall
    bend: Floats  # (N,) what was added to a prediction for it, dimensionless
    differences: Floats  # (4, N) backward differences of what predictions missed
    last_known: Floats  # (B,) what was imposed then
    last_efforts: Floats  # (motors,)
    linear_unknowns: Floats  # (N + motors,) of a linear problem of Section V-C
    lanczos: Floats  # (LANCZOS_STEPS, N + motors)
    lanczos_diagonal: Floats  # (LANCZOS_STEPS,) of the tridiagonal matrix
    lanczos_beside: Floats  # (LANCZOS_STEPS,) beside it


def workspace(robot: RobotArrays) -> Workspace:
    """Memory for one thread; long, for every field has its line."""
    width = robot.slot_index.shape[2]
    groups, slots, inner = len(robot.groups), robot.slots.total, robot.slots.inner_count
    elements, rods = robot.elements.shape[1], robot.rods.shape[1]
    size = len(robot.unit)
    border = size - robot.platform_index
    strains, nodes, steps = robot.slots.strain_count, len(robot.weights), len(robot.steps)

    def empty(*shape: int) -> Lanes:
        return empty_lanes(width, *shape)

    return Workspace(
        blocks=zeros_lanes(width, groups, slots, slots),
        residuals=zeros_lanes(width, groups, slots),
        platform_residual=np.empty(6),
        platform_tangent=np.empty((6, 6)),
        coordinates=zeros_lanes(width, slots),
        by_leg=empty(6),
        motor_values=empty(robot.slots.motor_count),
        rotation_vectors=empty(steps, 3),
        element_position=empty(elements + 1, 3),
        element_axis=empty(elements, 3),
        element_center=empty(elements, 3),
        slot_turn=empty(slots, 3),
        slot_carried=empty(slots, 3),
        frames=empty(rods, 3, nodes, 3),
        arm=empty(rods, nodes + 1, 3),
        point=empty(nodes + 1, 3),
        distributed=empty(nodes + 1, 3),
        load_source=empty(3, nodes, 3),
        load_field=empty(3, nodes + 1, 3),
        joint_moments=empty(3, 3),
        density=empty(3, nodes, 3),
        turned=empty(3, nodes, 3),
        balance=empty(3, nodes),
        swept=empty(3, nodes, 3),
        length_source=empty(nodes, 3),
        length_field=empty(nodes + 1, 3),
        stretched=empty(strains),
        geometric=empty(strains, strains),
        pairs=empty(nodes, 2),
        partial=empty(strains, nodes),
        mode_turn=empty(strains, 3),
        mode_growth=empty(strains, 3),
        mode_carried=empty(strains, 3),
        rows=empty(inner, slots),
        solution=empty(groups, inner),
        border=np.empty(size),
        part=np.empty(size),
        symmetric=np.empty((size, size)),
        square=np.empty((size, size)),
        pivots=np.empty(size, np.int64),
        motions=np.empty((3, 3)),
        step=np.empty(size),
        correction=np.empty(size),
        simplified=np.empty(size),
        total=np.empty(size),
        trial_state=np.empty(size),
        trial_rotation=np.empty((3, 3)),
        trial_position=np.empty(3),
        platform_step=np.empty(6),
        rotation_step=np.empty((3, 3)),
        rotated=np.empty((3, 3)),
        angles=np.empty(3),
        turn=np.empty(3),
        factors=factors_of(robot),
        delaying=factors_of(robot),
        known=np.zeros(border),
        efforts=np.zeros(size - robot.motor_index),
        effort_change=np.zeros(size - robot.motor_index),
        given_efforts=np.zeros(size - robot.motor_index),
        given_motors=np.zeros(size - robot.motor_index),
        given_rotation=np.empty((3, 3)),
        given_position=np.empty(3),
        rotation=np.empty((3, 3)),
        position=np.empty(3),
        residual=np.empty(size),
        signs=np.empty(3, np.int64),
        bend_count=np.zeros(1, np.int64),
        bend_order=np.zeros(1, np.int64),
        bend=np.zeros(size),
        differences=np.zeros((4, size)),
        last_known=np.zeros(border),
        last_efforts=np.zeros(size - robot.motor_index),
        linear_unknowns=np.empty(2 * size - robot.motor_index),
        lanczos=np.empty((LANCZOS_STEPS, 2 * size - robot.motor_index)),
        lanczos_diagonal=np.empty(LANCZOS_STEPS),
        lanczos_beside=np.empty(LANCZOS_STEPS),
    )


def factors_of(robot: RobotArrays) -> Factors:
    """Memory for the factors of a robot's tangent."""
    width = robot.slot_index.shape[2]
    groups, slots, inner = len(robot.groups), robot.slots.total, robot.slots.inner_count
    size = len(robot.unit)
    return Factors(
        upper=zeros_lanes(width, groups, inner, slots),
        inverse=empty_lanes(width, groups, inner),
        border=np.zeros((size, size)),
        status=np.zeros(1, np.int64),
        delayed_count=np.zeros(1, np.int64),
        delayed=np.zeros((size, 3), np.int64),
        beyond=np.zeros((size, inner)),
    )
