# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The tips of a group of legs: what their joints hold, and what that does to rods and platform.

Every orientation constraint is ``psi_k = tr(N_k)``, ``N_k = R_l G_k^T``, ``G_k = R_p R_c M_k``. A turn
of the tip changes it by ``c_k = axial(N_k)``; with the multipliers ``N = sum_k mu_k N_k``
(docs/derivations.md).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .kernel_decorators import inlined
from .lane_vectors import (
    add,
    axial,
    component,
    cross,
    dot,
    less_trace,
    load_matrix,
    load_vector,
    matrix_product,
    matrix_vector,
    outer,
    scaled,
    store_matrix,
    store_vector,
    subtract,
    total_matrix,
    total_vector,
    trace,
    transposed,
    unit_vector,
    zero_matrix,
)
from .lanes import broadcast, load, store
from .twist_layout import ANGULAR, FIRST_LINEAR, LINEAR

__all__ = [
    "Tip",
    "couple_platform",
    "couple_tip",
    "couple_tip_turn",
    "hold_tips",
    "push_platform",
    "store_upper",
]


class Tip(NamedTuple):
    """What the multipliers do at the tips: vectors and a matrix of lanes."""

    force: Any  # lambda, on the rod
    lever: Any  # R_p b, from the platform's origin to the joint
    alignment: Any  # N


@inlined
def hold_tips(robot, number, end, platform_rotation, platform_position, work):
    """Constraints of a group into the residuals; returns the Tip.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        end: TipPose.
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,).
        work: Workspace; ``coordinates`` is read, ``residuals`` and ``joint_moments`` are set.
    """
    group, slots, residuals = robot.groups[number], robot.slots, work.residuals
    rotation = load_matrix(platform_rotation, ())
    lever = matrix_vector(rotation, load_vector(group.tip_position, ()))
    joint = add(load_vector(platform_position, ()), lever)
    gap = subtract(joint, end.position)
    first = slots.first_multiplier
    store(residuals, (number, first), gap[0])
    store(residuals, (number, first + 1), gap[1])
    x, y = load(work.coordinates, first), load(work.coordinates, first + 1)
    z = broadcast(x, 0.0)
    if slots.position_count > 2:
        store(residuals, (number, first + 2), gap[2])
        z = load(work.coordinates, first + 2)

    alignment = zero_matrix(x)
    for row in range(slots.orientation_count):
        slot = slots.first_orientation + row
        image = matrix_product(rotation, load_matrix(group.orientation, row))
        of_one = matrix_product(end.frame, transposed(image))
        store(residuals, (number, slot), trace(of_one))
        store_vector(work.joint_moments, row, axial(of_one))
        alignment = add(alignment, scaled(load(work.coordinates, slot), of_one))
    return Tip((x, y, z), lever, alignment)


@inlined
def push_platform(tip, work):
    """Add what all legs do to the platform. Missing legs have neither force nor moment."""
    field = add(outer(tip.lever, tip.force), transposed(tip.alignment))
    moment, force = work.platform_residual[ANGULAR], work.platform_residual[LINEAR]
    store_vector(moment, (), add(load_vector(moment, ()), total_vector(axial(field))))
    store_vector(force, (), add(load_vector(force, ()), total_vector(tip.force)))
    turning = work.platform_tangent[ANGULAR, ANGULAR]
    by_turn = total_matrix(less_trace(field))
    store_matrix(turning, (), add(load_matrix(turning, ()), by_turn))


@inlined
def couple_platform(robot, number, tip, work):
    """Entries of multipliers and platform: how the platform moves the joints."""
    slots, blocks = robot.slots, work.blocks
    for column in range(slots.platform_count):
        axis, at = robot.platform_axes[column], slots.first_platform + column
        motion = add(cross(unit_vector(axis), tip.lever), unit_vector(axis - 3))
        store(blocks, (number, slots.first_multiplier, at), motion[0])
        store(blocks, (number, slots.first_multiplier + 1, at), motion[1])
        if slots.position_count > 2:
            store(blocks, (number, slots.first_multiplier + 2, at), motion[2])
        if axis < FIRST_LINEAR:
            for row in range(slots.orientation_count):
                value = -load(work.joint_moments, (row, axis))
                store(blocks, (number, slots.first_orientation + row, at), value)


@inlined
def couple_tip(robot, number, slot, motion, work):
    """Entries of a coordinate that moves the tip, with the multipliers that hold its position."""
    blocks, first = work.blocks, robot.slots.first_multiplier
    store_upper(blocks, number, slot, first, -motion[0])
    store_upper(blocks, number, slot, first + 1, -motion[1])
    if robot.slots.position_count > 2:
        store_upper(blocks, number, slot, first + 2, -motion[2])


@inlined
def couple_tip_turn(robot, number, slot, turn, tip, work):
    """Entries of a coordinate that turns the tip, with joint moments and the platform's rotation."""
    slots, blocks = robot.slots, work.blocks
    for row in range(slots.orientation_count):
        value = dot(turn, load_vector(work.joint_moments, row))
        store_upper(blocks, number, slot, slots.first_orientation + row, value)
    # Theta . (tr(N) 1 - N^T) Omega
    met = matrix_vector(less_trace(tip.alignment), turn)
    for column in range(slots.platform_count):
        axis = robot.platform_axes[column]
        if axis < FIRST_LINEAR:
            at = slots.first_platform + column
            store_upper(blocks, number, slot, at, -component(met, axis))


@inlined
def store_upper(blocks, number, slot, other_slot, value):
    """Set an entry of the upper triangle."""
    store(blocks, (number, min(slot, other_slot), max(slot, other_slot)), value)
