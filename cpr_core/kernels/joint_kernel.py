# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Joints and links in the chains of a group of legs: balance, and what they hand on towards the base.

What acts beyond a place is ``Carried`` there: the force n and the field ``F = D - N``. A joint that
turns is a density concentrated at its place, a link a stretch without density (docs/derivations.md).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .kernel_decorators import inlined
from .lane_vectors import (
    add,
    axial,
    cross,
    dot,
    less_trace,
    load_vector,
    matrix_vector,
    outer,
    scaled,
    store_vector,
    subtract,
    zero_vector,
)
from .lanes import broadcast, load, store
from .tip_kernel import couple_tip, couple_tip_turn

__all__ = ["Carried", "balance_shift", "balance_turn", "cross_link"]


class Carried(NamedTuple):
    """What acts on a chain beyond a place."""

    force: Any  # n, a vector of lanes
    field: Any  # F = D - N, a matrix of lanes


@inlined
def balance_turn(robot, number, e, carried, end, tip, work):
    """Balance of a joint that turns all behind it; returns the energy of its spring, lanes.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        e: Number of the element.
        carried: Carried at the joint.
        end: TipPose.
        tip: Tip.
        work: Workspace; rows of the joint's slot are the result.
    """
    element, axis = robot.elements[number, e], load_vector(work.element_axis, e)
    turned = matrix_vector(less_trace(carried.field), axis)
    lever = subtract(end.position, load_vector(work.element_position, e))
    balance, curvature = -dot(axis, axial(carried.field)), -dot(axis, turned)
    store_vector(work.slot_turn, element.slot, axis)
    store_vector(work.slot_carried, element.slot, turned)
    couple_tip(robot, number, element.slot, cross(axis, lever), work)
    if robot.slots.orientation_count > 0:
        couple_tip_turn(robot, number, element.slot, axis, tip, work)
    return _with_spring(robot, number, e, balance, curvature, work)


@inlined
def balance_shift(robot, number, e, carried, work):
    """Balance of a joint that shifts all behind it.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        e: Number of the element.
        carried: Carried behind the joint.
        work: Workspace; rows of the joint's slot are the result.

    Returns:
        Carried before the joint, and the energy of its spring, lanes.
    """
    element, axis = robot.elements[number, e], load_vector(work.element_axis, e)
    way = load(work.coordinates, element.slot) + load(element.zero, ())
    field = add(carried.field, outer(scaled(way, axis), carried.force))
    balance = -dot(axis, carried.force)
    store_vector(work.slot_turn, element.slot, zero_vector(balance))
    store_vector(work.slot_carried, element.slot, cross(axis, carried.force))
    couple_tip(robot, number, element.slot, axis, work)
    curvature = broadcast(balance, 0.0)
    stored = _with_spring(robot, number, e, balance, curvature, work)
    return Carried(carried.force, field), stored


@inlined
def _with_spring(robot, number, e, balance, curvature, work):
    """Write balance and second derivative of a joint, with its spring; returns the spring's energy."""
    element = robot.elements[number, e]
    stiffness = load(element.stiffness, ())
    stretch = load(work.coordinates, element.slot) - load(element.rest, ())
    store(work.residuals, (number, element.slot), balance + stiffness * stretch)
    store(work.blocks, (number, element.slot, element.slot), curvature + stiffness)
    return 0.5 * stiffness * stretch * stretch


@inlined
def cross_link(robot, loads, number, e, carried, work):
    """From behind a link to before it.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        number: Number of the group.
        e: Number of the element.
        carried: Carried behind the link.
        work: Workspace.

    Returns:
        Carried before the link, and the potential of its weight, lanes.
    """
    element, offset = robot.elements[number, e], load_vector(work.element_axis, e)
    force, field = carried.force, add(carried.field, outer(offset, carried.force))
    potential = broadcast(offset[0], 0.0)
    if element.heavy:
        mass, center = load(element.mass, ()), load_vector(work.element_center, e)
        weight = scaled(mass, _gravity(loads, mass))
        force, field = add(force, weight), add(field, outer(center, weight))
        potential -= dot(weight, add(load_vector(work.element_position, e), center))
    return Carried(force, field), potential


@inlined
def _gravity(loads, lanes):
    """Gravity, the same in all lanes."""
    return (
        broadcast(lanes, loads.gravity[0]),
        broadcast(lanes, loads.gravity[1]),
        broadcast(lanes, loads.gravity[2]),
    )
