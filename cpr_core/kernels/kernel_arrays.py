# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The robot and its loads as the kernels see them: plain arrays.

Global state and equations share one order: for every leg its passive joints, its
strain coordinates and its multipliers; then the platform; then the motors. In this order the tangent
is block-arrow shaped, and the forward problem is a leading principal block.

Kernels go through all legs at once, in groups of W lanes (`lanes`). There every leg has the same slots,
of which it may lack some (`slots`).
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .lanes import empty_lanes, zeros_lanes
from .slots import COMPONENTS, SlotLayout

__all__ = [
    "LANCZOS_STEPS",
    "PLATFORM_LOADS",
    "Element",
    "Factors",
    "Lanes",
    "LoadArrays",
    "RobotArrays",
    "Workspace",
    "element_dtype",
    "factors_of",
    "group_dtype",
    "interpolated_loads",
    "rod_dtype",
    "workspace",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Lanes = NDArray[np.void]

#: Most steps of Lanczos' method that a workspace has memory for.
LANCZOS_STEPS = 100


class Element(IntEnum):
    """Kinds of elements of a chain."""

    NONE = 0  # a chain that is shorter than others
    LINK = 1  # rigid: leads somewhere, may turn the frame, may have a mass
    TURN = 2  # joint that turns all behind it
    SHIFT = 3  # joint that shifts all behind it
    ROD = 4


def group_dtype(width: int) -> np.dtype[Any]:
    """Ends of a group of legs: base and tip."""
    lane = (width,)
    return np.dtype(
        [
            ("exists", "f8", lane),  # 1; 0: no leg
            ("base_position", "f8", (3, width)),  # in the world [m]
            ("base_rotation", "f8", (3, 3, width)),  # base frame in the world
            ("tip_position", "f8", (3, width)),  # tip joint in the platform frame [m]
            ("orientation", "f8", (3, 3, 3, width)),  # R_c M_k of psi_k = tr((R_p R_c M_k)^T R_l)
        ],
        align=True,
    )


def element_dtype(width: int) -> np.dtype[Any]:
    """An element of the chains of a group of legs, all vectors in the frame before it."""
    lane = (width,)
    return np.dtype(
        [
            ("kind", "i8"),  # one of ``Element``
            ("slot", "i8"),  # of the coordinate of a joint; -1: none
            ("rod", "i8"),  # number of the rod in its chain; -1: none
            ("heavy", "i8"),  # 1: some leg has a link of mass here
            ("axis", "f8", (3, width)),  # unit axis of a joint
            ("zero", "f8", lane),  # where the joint is at coordinate zero [rad or m]
            ("stiffness", "f8", lane),  # of its spring [N m/rad or N/m]
            ("rest", "f8", lane),  # coordinate at which the spring is at rest
            ("offset", "f8", (3, width)),  # where a link leads [m]
            ("rotation", "f8", (3, 3, width)),  # frame behind it
            ("mass", "f8", lane),  # [kg]
            ("center", "f8", (3, width)),  # its centre of mass [m]
        ],
        align=True,
    )


def rod_dtype(width: int) -> np.dtype[Any]:
    """A rod of the chains of a group of legs."""
    lane = (width,)
    return np.dtype(
        [
            # First strain slot of every component, and where one after the last would begin.
            ("component_start", "i8", COMPONENTS + 1),
            ("length_slot", "i8"),  # slot of the motor that feeds it; -1: all of fixed length
            ("turned", "i8"),  # 1: some coordinate before turns the rod
            ("followed", "i8"),  # 1: something comes after it
            ("length", "f8", lane),  # [m]; the nominal one where the rod is extensible
            ("extensible", "f8", lane),  # 1: a motor feeds it
            ("fed_zero", "f8", lane),  # its length with that motor at zero [m]
            ("length_index", "i8", lane),  # state index of that motor; -1: its length is fixed
            ("rest_energy", "f8", lane),  # q_rest^T K_e q_rest
            ("curved", "i8"),  # 1: some leg has a curvature at rest beyond its modes
            ("loads", "i8", lane),  # number of the rod among all of the robot; -1: none
        ],
        align=True,
    )


class RobotArrays(NamedTuple):
    """Constants of L legs in G groups of equal structure, E elements and R rods a leg at most.

    S strain slots, n inner slots, K nodes, H rotation steps.
    """

    slots: SlotLayout  # n inner slots, m in all
    groups: NDArray[np.void]  # (G,) of group_dtype
    slot_index: Integers  # (G, n, W) state index of every inner slot; -1: the leg lacks it
    motor_slot_index: Integers  # (G, m_a, W) state index of the motor of every motor slot; -1: none
    motor_ratio: Lanes  # (G, m_a) how far a joint goes when its motor goes one; 0: none
    units: (
        Lanes  # (G, m) natural units of the slots, of motors times the ratio; 0: the leg lacks it
    )
    missing: Lanes  # (G, n) 1: the leg lacks the slot
    elements: NDArray[np.void]  # (G, E) of element_dtype: the chains from base to tip
    rods: NDArray[np.void]  # (G, R) of rod_dtype
    lane_leg: Integers  # (G, W) number of the leg in a lane; -1: none
    function: Integers  # (G, S) which shape function a slot uses
    functions: Lanes  # (G, F, K) shape functions at the nodes
    step_functions: Lanes  # (G, H, F, 3) their moments over the rotation steps
    elastic: Lanes  # (G, S, S) K_e by slots
    rest_moment: Lanes  # (G, S) K_e q_rest: the curvature at rest, as far as modes take it up
    rest_steps: Lanes  # (G, R, H, 3, 3) what they do not, by component, its moments over the steps
    weights: Floats  # (K,)
    integration: Floats  # (K, K): I_jk, weight of node j in the integral from 0 to node k
    panel_nodes: int  # nodes of a panel, a multiple of four: the integration is block triangular
    steps: Floats  # (H,) lengths of the rotation steps in sigma
    step_node: Integers  # (H,) node reached at the end of a step; -1: none
    position_axes: Integers  # world axes along which tips are held: (0, 1, 2), in the plane (0, 1)
    platform_axes: Integers  # the b components of the world twist [omega; v] the platform has
    unit: Floats  # (N,) natural unit of every state: dimensionless = state / unit
    energy_unit: float  # natural unit of energy, E J / l [J]
    platform_index: int  # state index of the first platform coordinate
    motor_index: int  # state index of the first motor
    border_indices: Integers  # state indices of platform and motors
    inverse_unknowns: (
        Integers  # state indices of those of the inverse problem; none: no such problem
    )
    controls_angles: int  # 1: among them are roll, pitch, yaw instead of world rotations
    constraint_count: int  # number of multipliers of all legs
    kept_count: int  # lanes in which the factors of a tangent are kept (`kept_factors`)
    one_slot_a_motor: int  # 1: no motor is in several slots
    extensible: int  # 1: a motor feeds some rod


#: Loads of the platform, in the world or turning with it.
PLATFORM_LOADS = np.dtype(
    [
        ("weight", "f8", 3),  # in the world [N]
        ("center_of_mass", "f8", 3),  # in the platform frame [m]
        ("moment_world", "f8", 3),  # fixed in space [N m]
        ("force_world", "f8", 3),  # [N]
        ("moment_body", "f8", 3),  # following, in the platform frame [N m]
        ("force_body", "f8", 3),  # [N]
    ],
    align=True,
)


class LoadArrays(NamedTuple):
    """Loads in force, all linear in what the user gives, so that loads can be interpolated."""

    gravity: Floats  # (3,) in the world [m/s^2]
    distributed: (
        Floats  # (rods, 3, K + 1) int_sigma^1 of the force per length; last: sigma = 0 [N/m]
    )
    point: Floats  # (rods, 3, K + 1) sum of the point forces beyond a node; last: sigma = 0 [N]
    on_rods: Floats  # (1,) above zero where any rod carries a load
    platform: NDArray[np.void]  # (1,) of PLATFORM_LOADS


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


def interpolated_loads(first: LoadArrays, last: LoadArrays, fraction: float) -> LoadArrays:
    """Loads between two."""

    def between(start: NDArray[Any], end: NDArray[Any]) -> NDArray[Any]:
        if start.dtype.names:
            return between(start.view("f8"), end.view("f8")).view(start.dtype)
        return (1.0 - fraction) * start + fraction * end

    return LoadArrays(*[between(*pair) for pair in zip(first, last, strict=True)])


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
