# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A rod in the chains of a group of legs: balance and stiffness of its strain modes and of its length.

The world frame and small world rotations are used throughout. Every coordinate that turns cross-sections
has a density omega_a(s) and a rotation field Theta_a(s) = int_0^s omega_a. All loads and multipliers
enter through one field only (docs/derivations.md), ``F = D - N``:

    gradient   -int omega_a . m ds,                        m = axial(F)
    Hessian    -int Theta_a . Q omega_b ds + (a <-> b),    Q = F - tr(F) 1

with D(s) = int_s^tip t n^T of the tangent t = R e1 and the internal force n(s), and N from the moment
multipliers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .chain_kernel import rod_length
from .joint_kernel import Carried
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
from .lanes import broadcast, load, put, store
from .rod_kernel import integrate_beyond
from .slots import COMPONENTS
from .stiffness_kernel import strain_block
from .tip_kernel import couple_tip, couple_tip_turn

__all__ = ["balance_rod"]


class RodLoads(NamedTuple):
    """What the loads on a rod are in all: vectors and lanes, nu the distributed part of n over l."""

    point: Any  # sum of the point forces
    distributed: Any  # int of the force per length over sigma: nu(0)
    point_along: Any  # int (point forces) . t
    distributed_along: Any  # int nu . t


class Elastic(NamedTuple):
    """Elastic energies at the nominal length, lanes."""

    stored: Any  # q_e^T K_e q_e
    relaxed: Any  # q_e^T h


@inlined
def balance_rod(robot, loads, loaded, number, e, carried, end, tip, work, tangent):
    """Rows of the strain coordinates of a rod, and of its length where that is a motor.

    It takes what is known at both ends of the rod, and which rod it is.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        loaded: Whether any rod carries a load.
        number: Number of the group.
        e: Number of the element.
        carried: Carried at the end of the rod.
        end: TipPose.
        tip: Tip.
        work: Workspace with frames and arms of the rod.
        tangent: Whether the stiffness is wanted.

    Returns:
        Carried where the rod begins, and its energy with the potential of its loads, lanes.
    """
    r = robot.elements[number, e].rod
    rod, length = robot.rods[number, r], rod_length(robot, number, r, work)
    on_rod = _no_rod_loads(length)
    if loaded:
        _gather_loads(robot, loads, number, r, work)
        on_rod = _rod_loads(robot, r, length, work)
    lever = subtract(end.position, load_vector(work.element_position, e + 1))
    elastic = _stretch(robot, number, r, length, work)
    _fields(robot, number, r, length, lever, carried, loaded, work)
    _strain_coordinates(robot, number, r, tip, work)
    if tangent:
        strain_block(robot, number, r, length, work)
    if rod.length_slot >= 0:
        _extension(robot, number, r, length, carried, on_rod, elastic, loaded, work)
    nodes = robot.weights.shape[0]
    whole = add_scaled(on_rod.point, load(rod.length, ()), on_rod.distributed)
    before = Carried(
        add(carried.force, whole),
        _field(r, carried, length, loaded, nodes, work),
    )
    begin = load_vector(work.element_position, e)
    return before, _energy(rod, begin, length, on_rod, elastic)


@inlined
def _gather_loads(robot, loads, number, r, work):
    """Loads of a rod by lanes."""
    rows = robot.rods[number, r].loads
    for lane in range(rows.shape[0]):
        row = rows[lane]
        for i in range(3):
            for node in range(loads.point.shape[2]):
                point = loads.point[row, i, node] if row >= 0 else 0.0
                distributed = loads.distributed[row, i, node] if row >= 0 else 0.0
                put(work.point, (node, i), lane, point)
                put(work.distributed, (node, i), lane, distributed)


@inlined
def _no_rod_loads(length):
    """The same of rods without loads."""
    zero = broadcast(length, 0.0)
    return RodLoads(zero_vector(length), zero_vector(length), zero, zero)


@inlined
def _rod_loads(robot, r, length, work):
    """Loads on a rod in all, and their part of D into ``load_field``."""
    nodes = robot.weights.shape[0]
    point_along, distributed_along = broadcast(length, 0.0), broadcast(length, 0.0)
    for node in range(nodes):
        t, weight = load_vector(work.frames, (r, 0, node)), robot.weights[node]
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
def _stretch(robot, number, r, length, work):
    """Elastic forces of the strain coordinates; returns what they have stored."""
    rod, coordinates = robot.rods[number, r], work.coordinates
    first, last = rod.component_start[0], rod.component_start[COMPONENTS]
    ratio = load(rod.length, ()) / length
    stored, relaxed = broadcast(length, 0.0), broadcast(length, 0.0)
    for slot in range(first, last):
        force = broadcast(length, 0.0)
        for other_slot in range(first, last):
            force += load(robot.elastic, (number, slot, other_slot)) * load(coordinates, other_slot)
        store(work.stretched, slot, force)
        amplitude, rest = load(coordinates, slot), load(robot.rest_moment, (number, slot))
        stored += force * amplitude
        relaxed += amplitude * rest
        store(work.residuals, (number, slot), ratio * force - rest)
    return Elastic(stored, relaxed)


@inlined
def _energy(rod, begin, length, on_rod, elastic):
    """Energy of a rod and potential of its loads [J], lanes."""
    ratio = load(rod.length, ()) / length
    energy = 0.5 * ratio * elastic.stored - elastic.relaxed
    energy += 0.5 * load(rod.rest_energy, ()) / ratio
    energy -= length * (on_rod.point_along + length * on_rod.distributed_along)
    # What has not come out of its feed yet weighs there.
    return energy - dot(begin, add_scaled(on_rod.point, load(rod.length, ()), on_rod.distributed))


@inlined
def _field(r, carried, length, loaded, node, work):
    """F = D - N at a node, or where the rod begins, which comes after the last one."""
    arm = scaled(length, load_vector(work.arm, (r, node)))
    field = add(carried.field, outer(arm, carried.force))
    if loaded:
        of_rods = (
            load_vector(work.load_field, (0, node)),
            load_vector(work.load_field, (1, node)),
            load_vector(work.load_field, (2, node)),
        )
        field = add(field, of_rods)
    return field


@inlined
def _fields(robot, number, r, length, lever, carried, loaded, work):
    """All that is integrated along a rod with shape functions, from frames, arms and loads."""
    rod = robot.rods[number, r]
    nominal = load(rod.length, ())
    first = _first_component(rod)
    for node in range(robot.weights.shape[0]):
        field = _field(r, carried, length, loaded, node, work)
        m, q = axial(field), less_trace(field)
        arm = scaled(length, load_vector(work.arm, (r, node)))
        if rod.followed:
            arm = add(arm, lever)
        weight = robot.weights[node] * nominal
        for c in range(first, 3):
            omega = scaled(weight, load_vector(work.frames, (r, c, node)))
            store_vector(work.density, (c, node), omega)
            store_vector(work.turned, (c, node), matrix_vector(q, omega))
            store_vector(work.swept, (c, node), cross(omega, arm))
            store(work.balance, (c, node), dot(omega, m))


@inlined
def _first_component(rod):
    """The first strain component any leg has."""
    first = 0
    while first < 2 and rod.component_start[first + 1] == rod.component_start[first]:
        first += 1
    return first


@inlined
def _strain_coordinates(robot, number, r, tip, work):
    """Balance of the strain coordinates, and how they move and turn what is behind them."""
    rod, residuals = robot.rods[number, r], work.residuals
    nodes, turning = robot.weights.shape[0], robot.slots.orientation_count > 0
    for c in range(3):
        for slot in range(rod.component_start[c], rod.component_start[c + 1]):
            function = robot.function[number, slot]
            balance, motion = broadcast(work.balance, 0.0), zero_vector(work.balance)
            for node in range(nodes):
                phi = load(robot.functions, (number, function, node))
                balance += phi * load(work.balance, (c, node))
                motion = add_scaled(motion, phi, load_vector(work.swept, (c, node)))
            store(residuals, (number, slot), load(residuals, (number, slot)) - balance)
            couple_tip(robot, number, slot, motion, work)
            if rod.turned:
                carried = _summed(robot, number, function, work.turned[c], work)
                store_vector(work.slot_carried, slot, carried)
            if turning or rod.followed:
                turn = _summed(robot, number, function, work.density[c], work)
                store_vector(work.slot_turn, slot, turn)
                if turning:
                    couple_tip_turn(robot, number, slot, turn, tip, work)


@inlined
def _summed(robot, number, function, values, work):
    """A field at the nodes, weighted already, times a shape function, over the rod."""
    whole = zero_vector(work.balance)
    for node in range(robot.weights.shape[0]):
        phi = load(robot.functions, (number, function, node))
        whole = add_scaled(whole, phi, load_vector(values, node))
    return whole


@inlined
def _extension(robot, number, r, length, carried, on_rod, elastic, loaded, work):
    """Balance and couplings of a rod length as motor: ``p(l) = p_0 + l int t dsigma``.

    It takes what `balance_rod` has found on its way, as it is a part of it that few rods need.
    """
    rod, blocks, residuals = robot.rods[number, r], work.blocks, work.residuals
    nodes, slot = robot.weights.shape[0], rod.length_slot
    nominal, chord = load(rod.length, ()), load_vector(work.arm, (r, robot.weights.shape[0]))
    ratio = nominal / length
    pull = dot(carried.force, chord)
    pull += on_rod.point_along + 2.0 * length * on_rod.distributed_along
    pull += 0.5 * ratio / length * elastic.stored - 0.5 * load(rod.rest_energy, ()) / nominal
    store(residuals, (number, slot), -pull)

    # What the length does to m, int_sigma^1 t x (n + l nu).
    for node in range(nodes):
        force = carried.force
        if loaded:
            force = add(force, load_vector(work.point, node))
            force = add_scaled(force, 2.0 * length, load_vector(work.distributed, node))
        t = load_vector(work.frames, (r, 0, node))
        store_vector(work.length_source, node, cross(t, force))
    integrate_beyond(robot, work.length_source, work.length_field)
    for c in range(3):
        for mode in range(rod.component_start[c], rod.component_start[c + 1]):
            value = ratio / length * load(work.stretched, mode)
            for node in range(nodes):
                phi = load(robot.functions, (number, robot.function[number, mode], node))
                omega = load_vector(work.density, (c, node))
                value += phi * dot(omega, load_vector(work.length_field, node))
            store(blocks, (number, mode, slot), -value)
    stiffening = ratio / (length * length) * elastic.stored - 2.0 * on_rod.distributed_along
    store(blocks, (number, slot, slot), stiffening)
    couple_tip(robot, number, slot, chord, work)
    store_vector(work.slot_carried, slot, load_vector(work.length_field, nodes))
