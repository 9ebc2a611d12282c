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

from .slots import COMPONENTS, SlotLayout

__all__ = [
    "PLATFORM_LOADS",
    "Element",
    "Lanes",
    "LoadArrays",
    "RobotArrays",
    "element_dtype",
    "group_dtype",
    "interpolated_loads",
    "rod_dtype",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Lanes = NDArray[np.void]


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


def interpolated_loads(first: LoadArrays, last: LoadArrays, fraction: float) -> LoadArrays:
    """Loads between two, or beyond them on the same straight way."""

    def between(start: NDArray[Any], end: NDArray[Any]) -> NDArray[Any]:
        if start.dtype.names:
            return between(start.view("f8"), end.view("f8")).view(start.dtype)
        return (1.0 - fraction) * start + fraction * end

    found = LoadArrays(*[between(*pair) for pair in zip(first, last, strict=True)])
    # Whether there are any is no number: beyond the end at which there are none it would be negative.
    return found._replace(on_rods=np.maximum(first.on_rods, last.on_rods))
