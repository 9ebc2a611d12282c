# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Energy, static balance, constraint and exact tangent of a group of legs, in one pass along the rods.

The world frame and small world rotations are used throughout. Every leg coordinate that turns
cross-sections has a density omega_a(s) and a rotation field Theta_a(s) = int_0^s omega_a. All loads
and multipliers enter through one field only (docs/derivations.md), ``F = D - N``:

    gradient   -int omega_a . m ds,                        m = axial(F)
    Hessian    -int Theta_a . Q omega_b ds + (a <-> b),    Q = F - tr(F) 1

with D(s) = int_s^l t n^T of the tangent t = R e1 and the internal force n(s), and N from the moment
multipliers.

Results go to the slots (`slots`): `blocks` (upper triangle, slots of the leg, platform, motor),
`residuals`, and what all legs do to the platform. Slots a leg lacks hold numbers without meaning.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .base_kernel import base_of, motor_motion, passive_motion
from .kernel_decorators import inlined
from .lane_vectors import (
    add,
    add_scaled,
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
from .lanes import broadcast, load, put, store, total
from .rod_kernel import integrate_beyond, integrate_frames
from .stiffness_kernel import strain_block
from .tip_kernel import couple_platform, couple_tip, couple_tip_turn, hold_tips, push_platform

__all__ = ["evaluate_group"]


class RodLoads(NamedTuple):
    """What the loads on the rods are in all: vectors and lanes, nu the distributed part of n over l."""

    point: Any  # sum of the point forces
    distributed: Any  # int of the force per length over sigma: nu(0)
    point_along: Any  # int (point forces) . t
    distributed_along: Any  # int nu . t


class Elastic(NamedTuple):
    """Elastic energies at the nominal length, lanes."""

    stored: Any  # q_e^T K_e q_e
    relaxed: Any  # q_e^T h


class Section(NamedTuple):
    """What a cross-section carries."""

    field: Any  # F = D - N
    force: Any  # n


@inlined
def evaluate_group(
    robot, loads, loaded, number, state, platform_rotation, platform_position, work
):  # fmt: skip
    """Add a group of legs to the model and return its potential energy.

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

    Returns:
        Elastic energy and potential of the rods' loads [J].
    """
    _gather_coordinates(robot, number, state, work)
    base = base_of(robot, number, state, work)
    tip_frame = integrate_frames(robot, number, base.frame, work)
    integrate_beyond(robot, work.frames[0], work.arm)
    rods = _no_rod_loads(base.length)
    if loaded:
        _gather_loads(robot, loads, number, work)
        rods = _rod_loads(robot, base.length, work)
    tip = hold_tips(
        robot, number, base, tip_frame, platform_rotation, platform_position, work
    )  # fmt: skip
    push_platform(tip, work)
    couple_platform(robot, number, tip, work)
    elastic = _stretch(robot, number, base.length, work)
    _fields(robot, number, base.length, tip, loaded, work)
    _strain_coordinates(robot, number, tip, work)
    strain_block(robot, number, base.length, work)
    _base_coordinates(robot, number, base, tip, rods, elastic, loaded, work)
    return _energy(robot.groups[number], base, rods, elastic)


@inlined
def _gather_coordinates(robot, number, state, work):
    """The state by slots; zero where a leg lacks a slot."""
    index = robot.slot_index[number]
    for slot in range(index.shape[0]):
        for leg in range(index.shape[1]):
            i = index[slot, leg]
            put(work.coordinates, slot, leg, state[i] if i >= 0 else 0.0)


@inlined
def _gather_loads(robot, loads, number, work):
    """Loads of the rods by lanes, and those on the whole rod."""
    width, count = robot.slot_index.shape[2], loads.point.shape[0]
    for lane in range(width):
        leg = number * width + lane
        exists = leg < count
        for i in range(3):
            for node in range(loads.point.shape[2]):
                point = loads.point[leg, i, node] if exists else 0.0
                distributed = loads.distributed[leg, i, node] if exists else 0.0
                put(work.point, (node, i), lane, point)
                put(work.distributed, (node, i), lane, distributed)


@inlined
def _no_rod_loads(length):
    """The same of rods without loads."""
    zero = broadcast(length, 0.0)
    return RodLoads(zero_vector(length), zero_vector(length), zero, zero)


@inlined
def _rod_loads(robot, length, work):
    """Loads on the rods in all, and their part of D into ``load_field``."""
    nodes = robot.weights.shape[0]
    point_along, distributed_along = broadcast(length, 0.0), broadcast(length, 0.0)
    for node in range(nodes):
        t, weight = load_vector(work.frames, (0, node)), robot.weights[node]
        point, nu = load_vector(work.point, node), load_vector(work.distributed, node)
        point_along += weight * dot(t, point)
        distributed_along += weight * dot(t, nu)
        n = add_scaled(point, length, nu)
        rows = outer(scaled(length, t), n)
        store_vector(work.load_source, (0, node), rows[0])
        store_vector(work.load_source, (1, node), rows[1])
        store_vector(work.load_source, (2, node), rows[2])
    for row in range(3):
        integrate_beyond(robot, work.load_source[row], work.load_field[row])
    return RodLoads(
        load_vector(work.point, nodes),
        load_vector(work.distributed, nodes),
        point_along,
        distributed_along,
    )


@inlined
def _stretch(robot, number, length, work):
    """Elastic forces of the strain coordinates; returns what they have stored."""
    strains, coordinates = robot.slots.strain_count, work.coordinates
    ratio = load(robot.groups[number].length, ()) / length
    stored, relaxed = broadcast(length, 0.0), broadcast(length, 0.0)
    for slot in range(strains):
        force = broadcast(length, 0.0)
        for other_slot in range(strains):
            force += load(robot.elastic, (number, slot, other_slot)) * load(coordinates, other_slot)
        store(work.stretched, slot, force)
        amplitude, rest = load(coordinates, slot), load(robot.rest_moment, (number, slot))
        stored += force * amplitude
        relaxed += amplitude * rest
        store(work.residuals, (number, slot), ratio * force - rest)
    return Elastic(stored, relaxed)


@inlined
def _energy(group, base, rods, elastic):
    """Potential energy of a group [J]."""
    length, ratio = base.length, load(group.length, ()) / base.length
    energy = 0.5 * ratio * elastic.stored - elastic.relaxed
    energy += 0.5 * load(group.rest_energy, ()) / ratio
    energy -= length * (rods.point_along + length * rods.distributed_along)
    # The rod of an extensible leg comes out of its base point: no potential is counted there.
    fixed = (1.0 - load(group.extensible, ())) * length
    energy -= dot(base.position, add_scaled(rods.point, fixed, rods.distributed))
    return total(load(group.exists, ()) * energy)


@inlined
def _field(tip, length, loaded, node, work):
    """F = D - N at a node, or at the base, which comes after the last one."""
    arm = scaled(length, load_vector(work.arm, node))
    field = subtract(outer(arm, tip.force), tip.alignment)
    if loaded:
        of_rods = (
            load_vector(work.load_field, (0, node)),
            load_vector(work.load_field, (1, node)),
            load_vector(work.load_field, (2, node)),
        )
        field = add(field, of_rods)
    return field


@inlined
def _fields(robot, number, length, tip, loaded, work):
    """All that is integrated along the rods with shape functions, from frames, arms and loads."""
    group = robot.groups[number]
    nominal, axis = load(group.length, ()), load_vector(group.rotation_axis, ())
    first = _first_component(robot)
    for node in range(robot.weights.shape[0]):
        field = _field(tip, length, loaded, node, work)
        m, q = axial(field), less_trace(field)
        arm = scaled(length, load_vector(work.arm, node))
        weight = robot.weights[node] * nominal
        for c in range(first, 3):
            omega = scaled(weight, load_vector(work.frames, (c, node)))
            turned = matrix_vector(q, omega)
            store_vector(work.density, (c, node), omega)
            store_vector(work.turned, (c, node), turned)
            store_vector(work.swept, (c, node), cross(omega, arm))
            store(work.balance, (c, node), dot(omega, m))
            store(work.base_turning, (c, node), dot(axis, turned))


@inlined
def _first_component(robot):
    """The first strain component any leg has."""
    first = 0
    while first < 2 and robot.component_start[first + 1] == robot.component_start[first]:
        first += 1
    return first


@inlined
def _strain_coordinates(robot, number, tip, work):
    """Balance of the strain coordinates, how they move the tip, and their couplings to the base."""
    group, slots, residuals = robot.groups[number], robot.slots, work.residuals
    turn_motor, turn_passive = load(group.turn_motor, ()), load(group.turn_passive, ())
    nodes = robot.weights.shape[0]
    for c in range(3):
        for slot in range(robot.component_start[c], robot.component_start[c + 1]):
            function = robot.function[slot]
            balance, turning = broadcast(turn_motor, 0.0), broadcast(turn_motor, 0.0)
            motion = zero_vector(turn_motor)
            for node in range(nodes):
                phi = load(robot.functions, (number, function, node))
                balance += phi * load(work.balance, (c, node))
                turning += phi * load(work.base_turning, (c, node))
                motion = add_scaled(motion, phi, load_vector(work.swept, (c, node)))
            store(residuals, (number, slot), load(residuals, (number, slot)) - balance)
            couple_tip(robot, number, slot, motion, work)
            store(work.blocks, (number, slot, slots.motor), -(turn_motor * turning))
            if robot.slots.passive >= 0:
                store(work.blocks, (number, slot, slots.passive), -(turn_passive * turning))
            if slots.orientation_count > 0:
                turn = zero_vector(turn_motor)
                for node in range(nodes):
                    phi = load(robot.functions, (number, function, node))
                    turn = add_scaled(turn, phi, load_vector(work.density, (c, node)))
                couple_tip_turn(robot, number, slot, turn, tip, work)


@inlined
def _base_coordinates(robot, number, base, tip, rods, elastic, loaded, work):
    """Rows and columns of the coordinates of the base: the motor, and the passive one."""
    group, slots = robot.groups[number], robot.slots
    section = Section(
        _field(tip, base.length, loaded, robot.weights.shape[0], work),
        add(tip.force, add_scaled(rods.point, base.length, rods.distributed)),
    )
    motor = motor_motion(group)
    _base_coordinate(robot, number, slots.motor, motor, base, section, tip, work)
    if robot.slots.passive >= 0:
        passive = passive_motion(group)
        _base_coordinate(robot, number, slots.passive, passive, base, section, tip, work)
    if robot.extensible:
        _extension(robot, number, base.length, tip, rods, elastic, loaded, work)


@inlined
def _base_coordinate(robot, number, slot, motion, base, section, tip, work):
    """Balance, tip motion and second derivative of a coordinate that turns, shifts or feeds the rod."""
    chord = load_vector(work.arm, robot.weights.shape[0])
    value = -(dot(motion.turn, axial(section.field)) + dot(motion.shift, section.force))
    store(work.residuals, (number, slot), value)
    second = -dot(motion.turn, matrix_vector(less_trace(section.field), motion.turn))
    store(work.blocks, (number, slot, slot), second)
    moved = add(cross(motion.turn, scaled(base.length, chord)), motion.shift)
    couple_tip(robot, number, slot, add_scaled(moved, motion.extension, chord), work)
    if robot.slots.orientation_count > 0:
        couple_tip_turn(robot, number, slot, motion.turn, tip, work)


@inlined
def _extension(robot, number, length, tip, rods, elastic, loaded, work):
    """Balance and couplings of a rod length as motor: ``p(l) = p_0 + l int t dsigma``."""
    group, slots, blocks, residuals = robot.groups[number], robot.slots, work.blocks, work.residuals
    nodes, motor = robot.weights.shape[0], robot.slots.motor
    extensible, nominal = load(group.extensible, ()), load(group.length, ())
    ratio = nominal / length
    pull = dot(tip.force, load_vector(work.arm, nodes))
    pull += rods.point_along + 2.0 * length * rods.distributed_along
    pull += 0.5 * ratio / length * elastic.stored - 0.5 * load(group.rest_energy, ()) / nominal
    before = load(residuals, (number, motor))
    store(residuals, (number, motor), before - extensible * pull)

    # What the length does to m, int_sigma^1 t x (n + l nu).
    for node in range(nodes):
        force = tip.force
        if loaded:
            force = add(force, load_vector(work.point, node))
            force = add_scaled(force, 2.0 * length, load_vector(work.distributed, node))
        t = load_vector(work.frames, (0, node))
        store_vector(work.length_source, node, cross(t, force))
    integrate_beyond(robot, work.length_source, work.length_field)
    for c in range(3):
        for slot in range(robot.component_start[c], robot.component_start[c + 1]):
            value = ratio / length * load(work.stretched, slot)
            for node in range(nodes):
                phi = load(robot.functions, (number, robot.function[slot], node))
                omega = load_vector(work.density, (c, node))
                value += phi * dot(omega, load_vector(work.length_field, node))
            before = load(blocks, (number, slot, motor))
            store(blocks, (number, slot, motor), before - extensible * value)
    stiffening = ratio / (length * length) * elastic.stored - 2.0 * rods.distributed_along
    before = load(blocks, (number, motor, motor))
    store(blocks, (number, motor, motor), before + extensible * stiffening)
    if robot.slots.passive >= 0:
        turn = load_vector(group.rotation_axis, ())
        turning = -dot(turn, load_vector(work.length_field, nodes))
        store(blocks, (number, slots.passive, motor), extensible * turning)
