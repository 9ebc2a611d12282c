# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Energy, static balance, constraint and exact tangent of a group of legs.

A leg is a chain of joints, links and rods. It is gone through from base to tip for where everything is,
and back for what acts beyond every place. Turns T_a of coordinates meet what others further out carry:
``H_ab = -T_a . w_b``.

Results go to the slots (`slots`): `blocks` (upper triangle, slots of the leg, platform, motors),
`residuals`, and what all legs do to the platform. Slots a leg lacks hold numbers without meaning.
"""

from __future__ import annotations

from .chain_kernel import place_chain
from .joint_kernel import Carried, balance_shift, balance_turn, cross_link
from .kernel_arrays import Element
from .kernel_decorators import inlined
from .lane_vectors import dot, load_vector, negated
from .lanes import broadcast, get, load, put, total
from .rod_balance_kernel import balance_rod
from .slots import COMPONENTS
from .tip_kernel import couple_platform, hold_tips, push_platform, store_upper

__all__ = ["evaluate_group"]


@inlined
def evaluate_group(
    robot, loads, loaded, number, state, platform_rotation, platform_position, work, tangent
):
    """Add a group of legs to the model and return its potential energy.

    It takes all that the model takes, and which group.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        loaded: Whether any rod carries a load.
        number: Number of the group.
        state: Global state, (N,).
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,).
        work: Workspace; `blocks` and `residuals` of the group are set, `platform_residual` and
            `platform_tangent` are added to.
        tangent: Whether `blocks` are wanted, a constant; without, they are left half done.

    Returns:
        Elastic energy, and potential of the weights of links and the loads of rods [J].
    """
    _gather_coordinates(robot, number, state, work)
    end = place_chain(robot, number, work)
    tip = hold_tips(robot, number, end, platform_rotation, platform_position, work)
    push_platform(tip, work)
    couple_platform(robot, number, tip, work)
    energy = _balance_chain(robot, loads, loaded, number, end, tip, work, tangent)
    if tangent:
        _couple_chain(robot, number, work)
    return total(load(robot.groups[number].exists, ()) * energy)


@inlined
def _gather_coordinates(robot, number, state, work):
    """The state by slots; zero where a leg lacks a slot."""
    index, motors = robot.slot_index[number], robot.motor_slot_index[number]
    for slot in range(index.shape[0]):
        for leg in range(index.shape[1]):
            i = index[slot, leg]
            put(work.coordinates, slot, leg, state[i] if i >= 0 else 0.0)
    for m in range(motors.shape[0]):
        for leg in range(motors.shape[1]):
            i, value = motors[m, leg], 0.0
            if i >= 0:
                value = get(robot.motor_ratio, (number, m), leg) * state[i]
            put(work.coordinates, robot.slots.first_motor + m, leg, value)


@inlined
def _balance_chain(robot, loads, loaded, number, end, tip, work, tangent):
    """Rows of all coordinates from tip to base; returns the energy, lanes."""
    carried = Carried(tip.force, negated(tip.alignment))
    energy = broadcast(work.coordinates, 0.0)
    for e in range(robot.elements.shape[1] - 1, -1, -1):
        kind = robot.elements[number, e].kind
        if kind == Element.ROD:
            carried, stored = balance_rod(
                robot, loads, loaded, number, e, carried, end, tip, work, tangent
            )
            energy += stored
        elif kind == Element.TURN:
            energy += balance_turn(robot, number, e, carried, end, tip, work)
        elif kind == Element.SHIFT:
            carried, stored = balance_shift(robot, number, e, carried, work)
            energy += stored
        elif kind == Element.LINK:
            carried, stored = cross_link(robot, loads, number, e, carried, work)
            energy += stored
    return energy


@inlined
def _couple_chain(robot, number, work):
    """Second derivatives by coordinates of different elements: H_ab = -T_a . w_b, a before b."""
    for e in range(1, robot.elements.shape[1]):
        element = robot.elements[number, e]
        if element.kind == Element.ROD:
            rod = robot.rods[number, element.rod]
            first, last = rod.component_start[0], rod.component_start[COMPONENTS]
            _couple_with_before(robot, number, e, first, last, work)
            if rod.length_slot >= 0:
                slot = rod.length_slot
                _couple_with_before(robot, number, e, slot, slot + 1, work)
        elif element.slot >= 0:
            _couple_with_before(robot, number, e, element.slot, element.slot + 1, work)


@inlined
def _couple_with_before(robot, number, later, first, last, work):
    """Some slots of an element with all of elements before it that turn."""
    for e in range(later):
        element = robot.elements[number, e]
        start, end = 0, 0
        if element.kind == Element.TURN:
            start, end = element.slot, element.slot + 1
        elif element.kind == Element.ROD:
            rod = robot.rods[number, element.rod]
            start, end = rod.component_start[0], rod.component_start[COMPONENTS]
        for a in range(start, end):
            turn = load_vector(work.slot_turn, a)
            for b in range(first, last):
                value = -dot(turn, load_vector(work.slot_carried, b))
                store_upper(work.blocks, number, a, b, value)
