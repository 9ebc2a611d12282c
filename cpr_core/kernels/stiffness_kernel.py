# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Stiffness of the strain modes of a group of legs: elastic, less what the loads take or give.

With the densities ``omega_a = l_0 phi_a d_c`` of modes and ``Theta_a = int_0^s omega_a`` the second
part is ``int Theta_a . Q omega_b`` and its transpose. At the nodes, with the weights I_jk of node j in
the integral up to node k and ``t_c = l_0 w Q d_c`` (``turned``), modes of components c and d meet in

    l_0 F_c N F_d^T,    N_jk = I_jk d_c(j) . t_d(k) + I_kj d_d(k) . t_c(j).

N is the same for all modes. I is full within a panel only; of earlier panels Theta_a at their end is
enough.
"""

from __future__ import annotations

from .kernel_decorators import inlined
from .lanes import broadcast, load, store

__all__ = ["strain_block"]

# Vectors of the modes in the workspace: Theta_a where a panel begins, int_panel phi_a t_d, and what
# Theta_a grows by in the panel.
_TURN, _CARRIED, _GROWTH = 0, 3, 6


@inlined
def strain_block(robot, number, length, work):
    """The block of the strain coordinates, upper triangle, from frames and Q at the nodes.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        length: Rod lengths, lanes.
        work: Workspace; ``frames`` and ``turned`` are read, ``blocks`` is the result.
    """
    geometric, blocks, start = work.geometric, work.blocks, robot.component_start
    nodes, panel = robot.weights.shape[0], robot.panel_nodes
    nominal = load(robot.groups[number].length, ())
    for first in range(0, nodes, panel):
        for c in range(3):
            for d in range(c, 3):
                if start[c] < start[c + 1] and start[d] < start[d + 1]:
                    _panel_alone(robot, number, c, d, first, work)
        if panel < nodes:
            _panels_before(robot, number, first, work)
    ratio = nominal / length
    for c in range(3):
        for slot in range(start[c], start[c + 1]):
            for other in range(slot, start[3]):
                value = load(geometric, (slot, other))
                if other < start[c + 1]:
                    value += load(geometric, (other, slot))
                elastic = ratio * load(robot.elastic, (number, slot, other))
                store(blocks, (number, slot, other), elastic - nominal * value)


@inlined
def _panel_alone(robot, number, c, d, first, work):
    """What the nodes of one panel give two components. Of one with itself half of N, to be mirrored."""
    functions, rows, partial = robot.functions, work.pairs, work.partial
    panel, function = robot.panel_nodes, robot.function
    here, there = robot.component_start[c], robot.component_start[d]
    count, last = robot.component_start[c + 1] - here, robot.component_start[d + 1] - there
    zero = broadcast(rows, 0.0)
    end = first + panel
    for j in range(first, first + panel, 4):
        _pairs_of_nodes(robot, c, d, j, first, j if c == d else end, work)
        if c == d:
            _pairs_on_diagonal(robot, c, j, work)
            end = j + 4
        for b in range(0, last, 2):  # the last of an odd number is its own partner
            also = min(b + 1, last - 1)
            f, g = function[there + b], function[there + also]
            s0, s1, s2, s3 = zero, zero, zero, zero
            r0, r1, r2, r3 = zero, zero, zero, zero
            for k in range(first, end):
                one, two = load(functions, (number, f, k)), load(functions, (number, g, k))
                p0, p1 = load(rows, (0, k)), load(rows, (1, k))
                p2, p3 = load(rows, (2, k)), load(rows, (3, k))
                s0, s1, s2, s3 = s0 + p0 * one, s1 + p1 * one, s2 + p2 * one, s3 + p3 * one
                r0, r1, r2, r3 = r0 + p0 * two, r1 + p1 * two, r2 + p2 * two, r3 + p3 * two
            store(partial, (b, j), s0)
            store(partial, (b, j + 1), s1)
            store(partial, (b, j + 2), s2)
            store(partial, (b, j + 3), s3)
            store(partial, (also, j), r0)
            store(partial, (also, j + 1), r1)
            store(partial, (also, j + 2), r2)
            store(partial, (also, j + 3), r3)
    for a in range(0, count, 2):
        next_a = min(a + 1, count - 1)
        f, g = function[here + a], function[here + next_a]
        for b in range(0, last, 2):
            next_b = min(b + 1, last - 1)
            s0 = _before(work, first, here + a, there + b, zero)
            s1 = _before(work, first, here + a, there + next_b, zero)
            r0 = _before(work, first, here + next_a, there + b, zero)
            r1 = _before(work, first, here + next_a, there + next_b, zero)
            for j in range(first, first + panel):
                one, two = load(functions, (number, f, j)), load(functions, (number, g, j))
                p0, p1 = load(partial, (b, j)), load(partial, (next_b, j))
                s0, s1, r0, r1 = s0 + one * p0, s1 + one * p1, r0 + two * p0, r1 + two * p1
            store(work.geometric, (here + a, there + b), s0)
            store(work.geometric, (here + a, there + next_b), s1)
            store(work.geometric, (here + next_a, there + b), r0)
            store(work.geometric, (here + next_a, there + next_b), r1)


@inlined
def _before(work, first, slot, other, zero):
    """An entry as earlier panels left it."""
    value = zero
    if first > 0:
        value = load(work.geometric, (slot, other))
    return value


@inlined
def _pairs_of_nodes(robot, c, d, j, first, end, work):
    """Four rows of N, from node j on, for the nodes from ``first`` up to ``end``."""
    frames, turned, rows, integration = work.frames, work.turned, work.pairs, robot.integration
    for row in range(0, 4, 2):
        i = j + row
        x0, y0, z0 = load(frames, (c, 0, i)), load(frames, (c, 1, i)), load(frames, (c, 2, i))
        u0, v0, w0 = load(turned, (c, 0, i)), load(turned, (c, 1, i)), load(turned, (c, 2, i))
        i += 1
        x1, y1, z1 = load(frames, (c, 0, i)), load(frames, (c, 1, i)), load(frames, (c, 2, i))
        u1, v1, w1 = load(turned, (c, 0, i)), load(turned, (c, 1, i)), load(turned, (c, 2, i))
        for k in range(first, end):
            x, y, z = load(frames, (d, 0, k)), load(frames, (d, 1, k)), load(frames, (d, 2, k))
            u, v, w = load(turned, (d, 0, k)), load(turned, (d, 1, k)), load(turned, (d, 2, k))
            value = integration[i - 1, k] * (x0 * u + y0 * v + z0 * w)
            store(rows, (row, k), value + integration[k, i - 1] * (x * u0 + y * v0 + z * w0))
            value = integration[i, k] * (x1 * u + y1 * v + z1 * w)
            store(rows, (row + 1, k), value + integration[k, i] * (x * u1 + y * v1 + z * w1))


@inlined
def _pairs_on_diagonal(robot, c, j, work):
    """The same where the rows meet their own nodes: I_jk d(j) . t(k), whose transpose is the rest."""
    frames, turned, rows = work.frames, work.turned, work.pairs
    for row in range(4):
        i = j + row
        x, y, z = load(frames, (c, 0, i)), load(frames, (c, 1, i)), load(frames, (c, 2, i))
        for k in range(j, j + 4):
            value = x * load(turned, (c, 0, k)) + y * load(turned, (c, 1, k))
            value += z * load(turned, (c, 2, k))
            store(rows, (row, k), robot.integration[i, k] * value)


@inlined
def _panels_before(robot, number, first, work):
    """What the modes have turned before a panel does in it; then their turns up to its end."""
    frames, turned, vectors = work.frames, work.turned, work.turns
    geometric, start, end = work.geometric, robot.component_start, first + robot.panel_nodes
    zero = broadcast(frames, 0.0)
    for c in range(3):
        for slot in range(start[c], start[c + 1]):
            f = robot.function[slot]
            x, y, z, u, v, w = zero, zero, zero, zero, zero, zero
            for k in range(first, end):
                value = load(robot.functions, (number, f, k))
                u += value * load(turned, (c, 0, k))
                v += value * load(turned, (c, 1, k))
                w += value * load(turned, (c, 2, k))
                value = robot.weights[k] * value
                x += value * load(frames, (c, 0, k))
                y += value * load(frames, (c, 1, k))
                z += value * load(frames, (c, 2, k))
            store(vectors, (slot, _CARRIED), u)
            store(vectors, (slot, _CARRIED + 1), v)
            store(vectors, (slot, _CARRIED + 2), w)
            store(vectors, (slot, _GROWTH), x)
            store(vectors, (slot, _GROWTH + 1), y)
            store(vectors, (slot, _GROWTH + 2), z)
            if first == 0:
                continue
            for other in range(slot + 1):
                value = load(geometric, (other, slot)) + _carried(vectors, other, slot)
                if other < start[c]:  # of one component the transpose is added at the end
                    value += _carried(vectors, slot, other)
                store(geometric, (other, slot), value)
                if start[c] <= other < slot:
                    value = load(geometric, (slot, other)) + _carried(vectors, slot, other)
                    store(geometric, (slot, other), value)
    for slot in range(start[3]):
        for i in range(3):
            value = load(vectors, (slot, _GROWTH + i))
            if first > 0:
                value += load(vectors, (slot, _TURN + i))
            store(vectors, (slot, _TURN + i), value)


@inlined
def _carried(vectors, one, other):
    """Turn of one mode times what another carries."""
    value = load(vectors, (one, _TURN)) * load(vectors, (other, _CARRIED))
    value += load(vectors, (one, _TURN + 1)) * load(vectors, (other, _CARRIED + 1))
    return value + load(vectors, (one, _TURN + 2)) * load(vectors, (other, _CARRIED + 2))
