# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stiffness of the strain modes of a group of legs: elastic, less what the loads take or give.

With the densities ``omega_a = l_0 phi_a d_c`` of modes and ``Theta_a = int_0^s omega_a`` the second
part is ``int Theta_a . Q omega_b`` and its transpose. At the nodes, with the weights I_jk of node j in
the integral up to node k and ``t_c = l_0 w Q d_c`` (``turned``), modes of components c and d meet in

    l_0 Phi_c P Phi_d^T,    P_jk = I_jk d_c(j) . t_d(k) + I_kj d_d(k) . t_c(j).

P is the same for all modes. I is full within a panel only; of earlier panels Theta_a at their end is
enough.
"""

from __future__ import annotations

from .kernel_decorators import inlined
from .lane_vectors import add, add_scaled, dot, load_vector, store_vector, zero_vector
from .lanes import broadcast, load, store
from .slots import COMPONENTS

__all__ = ["strain_block"]


@inlined
def strain_block(robot, number, rod, length, work):
    """The block of the strain coordinates, upper triangle, from frames and Q at the nodes.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        rod: Number of the rod in its chain.
        length: Rod lengths, lanes.
        work: Workspace; ``frames`` and ``turned`` are read, ``blocks`` is the result.
    """
    geometric, blocks = work.geometric, work.blocks
    start = robot.rods[number, rod].component_start
    nodes, panel = robot.weights.shape[0], robot.panel_nodes
    nominal = load(robot.rods[number, rod].length, ())
    for first in range(0, nodes, panel):
        for c in range(COMPONENTS):
            for d in range(c, COMPONENTS):
                if start[c] < start[c + 1] and start[d] < start[d + 1]:
                    _multiply_pairs(robot, number, rod, c, d, first, work)
                    _multiply_partial(robot, number, rod, c, d, first, work)
        if panel < nodes:
            _panels_before(robot, number, rod, first, work)
    ratio = nominal / length
    for c in range(COMPONENTS):
        for slot in range(start[c], start[c + 1]):
            for other_slot in range(slot, start[COMPONENTS]):
                value = load(geometric, (slot, other_slot))
                if other_slot < start[c + 1]:
                    value += load(geometric, (other_slot, slot))
                elastic = ratio * load(robot.elastic, (number, slot, other_slot))
                store(blocks, (number, slot, other_slot), elastic - nominal * value)


@inlined
def _multiply_pairs(robot, number, rod, c, d, first, work):
    """P Phi_d^T of one panel: of a component with itself half of P, to be mirrored.

    Two rows of P and two modes at a time: what is loaded serves twice, and four sums are as many as
    registers hold where a vector of lanes takes two of them.
    """
    component_start, zero = robot.rods[number, rod].component_start, broadcast(work.pairs, 0.0)
    start, count = component_start[d], component_start[d + 1] - component_start[d]
    end = first + robot.panel_nodes
    for j in range(first, first + robot.panel_nodes, 2):
        _pairs_of_nodes(robot, rod, c, d, j, first, j if c == d else end, work)
        if c == d:
            _pairs_on_diagonal(robot, rod, c, j, work)
            end = j + 2
        for mode in range(0, count, 2):  # the last of an odd number is its own partner
            partner = min(mode + 1, count - 1)
            function, partner_function = (
                robot.function[number, start + mode],
                robot.function[number, start + partner],
            )
            corner, right, below, across = zero, zero, zero, zero
            for k in range(first, end):
                phi = load(robot.functions, (number, function, k))
                partner_phi = load(robot.functions, (number, partner_function, k))
                value, next_value = load(work.pairs, (k, 0)), load(work.pairs, (k, 1))
                corner, right = corner + phi * value, right + phi * next_value
                below, across = below + partner_phi * value, across + partner_phi * next_value
            store(work.partial, (mode, j), corner)
            store(work.partial, (mode, j + 1), right)
            store(work.partial, (partner, j), below)
            store(work.partial, (partner, j + 1), across)


@inlined
def _multiply_partial(robot, number, rod, c, d, first, work):
    """Add Phi_c times P Phi_d^T of one panel to the stiffness; two modes by two at a time."""
    start = robot.rods[number, rod].component_start
    row_start, column_start = start[c], start[d]
    rows, columns = start[c + 1] - row_start, start[d + 1] - column_start
    functions, partial, geometric = robot.functions, work.partial, work.geometric
    for row in range(0, rows, 2):
        next_row = min(row + 1, rows - 1)
        i, next_i = row_start + row, row_start + next_row
        f, next_f = robot.function[number, i], robot.function[number, next_i]
        for column in range(0, columns, 2):
            next_column = min(column + 1, columns - 1)
            j, next_j = column_start + column, column_start + next_column
            corner, right = (
                _of_panels_before(work, first, i, j),
                _of_panels_before(work, first, i, next_j),
            )
            below = _of_panels_before(work, first, next_i, j)
            across = _of_panels_before(work, first, next_i, next_j)
            for k in range(first, first + robot.panel_nodes):
                phi, next_phi = (
                    load(functions, (number, f, k)),
                    load(functions, (number, next_f, k)),
                )
                value, next_value = load(partial, (column, k)), load(partial, (next_column, k))
                corner, right = corner + phi * value, right + phi * next_value
                below, across = below + next_phi * value, across + next_phi * next_value
            store(geometric, (i, j), corner)
            store(geometric, (i, next_j), right)
            store(geometric, (next_i, j), below)
            store(geometric, (next_i, next_j), across)


@inlined
def _of_panels_before(work, first, slot, other_slot):
    """An entry as earlier panels left it."""
    value = broadcast(work.geometric, 0.0)
    if first > 0:
        value = load(work.geometric, (slot, other_slot))
    return value


@inlined
def _pairs_of_nodes(robot, rod, c, d, j, first, end, work):
    """Two rows of P, from node j on, for the nodes from ``first`` up to ``end``."""
    frames, turned, integration = work.frames, work.turned, robot.integration
    for row in range(2):
        i = j + row
        d_i, t_i = load_vector(frames, (rod, c, i)), load_vector(turned, (c, i))
        for k in range(first, end):
            d_k, t_k = load_vector(frames, (rod, d, k)), load_vector(turned, (d, k))
            value = integration[i, k] * dot(d_i, t_k) + integration[k, i] * dot(d_k, t_i)
            store(work.pairs, (k, row), value)


@inlined
def _pairs_on_diagonal(robot, rod, c, j, work):
    """The same where the rows meet their own nodes: I_jk d(j) . t(k), whose transpose is the rest."""
    for row in range(2):
        direction = load_vector(work.frames, (rod, c, j + row))
        for k in range(j, j + 2):
            value = dot(direction, load_vector(work.turned, (c, k)))
            store(work.pairs, (k, row), robot.integration[j + row, k] * value)


@inlined
def _panels_before(robot, number, rod, first, work):
    """What the modes have turned before a panel does in it; then their turns up to its end."""
    geometric, end = work.geometric, first + robot.panel_nodes
    start = robot.rods[number, rod].component_start
    for c in range(COMPONENTS):
        for slot in range(start[c], start[c + 1]):
            function = robot.function[number, slot]
            growth, carried = zero_vector(geometric), zero_vector(geometric)
            for k in range(first, end):
                phi = load(robot.functions, (number, function, k))
                carried = add_scaled(carried, phi, load_vector(work.turned, (c, k)))
                growth = add_scaled(
                    growth, robot.weights[k] * phi, load_vector(work.frames, (rod, c, k))
                )
            store_vector(work.mode_carried, slot, carried)
            store_vector(work.mode_growth, slot, growth)
            if first == 0:
                continue
            for other_slot in range(start[0], slot + 1):
                value = load(geometric, (other_slot, slot)) + _carried(work, other_slot, slot)
                if other_slot < start[c]:  # of one component the transpose is added at the end
                    value += _carried(work, slot, other_slot)
                store(geometric, (other_slot, slot), value)
                if start[c] <= other_slot < slot:
                    value = load(geometric, (slot, other_slot)) + _carried(work, slot, other_slot)
                    store(geometric, (slot, other_slot), value)
    for slot in range(start[0], start[COMPONENTS]):
        turn = load_vector(work.mode_growth, slot)
        if first > 0:
            turn = add(turn, load_vector(work.mode_turn, slot))
        store_vector(work.mode_turn, slot, turn)


@inlined
def _carried(work, turning_slot, slot):
    """Turn of one mode times what another carries: Theta_a . int_panel phi_b Q omega."""
    return dot(load_vector(work.mode_turn, turning_slot), load_vector(work.mode_carried, slot))
