# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shape of the rods of a group of legs: frames at the nodes, and lever arms to the tip."""

from __future__ import annotations

import math

from .kernel_decorators import inlined
from .lanes import broadcast, get, highest, load, put, store
from .rotation_kernel import SMALL_ANGLE_SQUARED, magnus, small_rotation, turned_frame

__all__ = ["integrate_arms", "integrate_frames", "turn_base"]


@inlined
def turn_base(group, state, base_rotation, exists):
    """Base frames of a group, turned by the angles in the state.

    Args:
        group: Record of the group.
        state: Global state, (N,).
        base_rotation: Result, lanes (3, 3).
        exists: Work space, lanes (2, 3).
    """
    sine, versine = broadcast(base_rotation, 0.0), broadcast(base_rotation, 0.0)
    turned = False
    for lane in range(group.turn_index.shape[0]):
        index = group.turn_index[lane]
        turned = turned or index >= 0
        angle = state[index] if index >= 0 else 0.0
        half = math.sin(0.5 * angle)
        put(exists, (0, 0), lane, math.sin(angle))
        put(exists, (0, 1), lane, 2.0 * half * half)
    sine, versine = load(exists, (0, 0)), load(exists, (0, 1))
    x, y, z = (
        load(group.rotation_axis, 0),
        load(group.rotation_axis, 1),
        load(group.rotation_axis, 2),
    )
    for j in range(3):
        # exp(angle axis^) r = r + sine axis x r + versine axis x (axis x r)
        a, b, c = (
            load(group.base_rotation, (0, j)),
            load(group.base_rotation, (1, j)),
            load(group.base_rotation, (2, j)),
        )
        if turned:
            u, v, w = y * c - z * b, z * a - x * c, x * b - y * a
            p, q, r = y * w - z * v, z * u - x * w, x * v - y * u
            a, b, c = (
                a + sine * u + versine * p,
                b + sine * v + versine * q,
                c + sine * w + versine * r,
            )
        store(base_rotation, (0, j), a)
        store(base_rotation, (1, j), b)
        store(base_rotation, (2, j), c)


@inlined
def _rotation_vectors(robot, number, work):
    """Rotation vectors of all steps; returns the highest squared angle of a step."""
    first, second, third = (
        robot.component_start[0],
        robot.component_start[1],
        robot.component_start[2],
    )
    last = robot.component_start[3]
    function, functions, strain = robot.function, robot.step_functions, work.strain
    # Strain coordinates are curvatures at the nominal length: the rotation does not see the length.
    nominal = load(robot.groups[number].length, ())
    zero = broadcast(strain, 0.0)
    largest = 0.0
    for step in range(robot.steps.shape[0]):
        a1, a2, a3, b1, b2, b3, c1, c2, c3 = zero, zero, zero, zero, zero, zero, zero, zero, zero
        for slot in range(first, second):
            value, f = load(strain, slot), function[slot]
            a1 += value * load(functions, (number, step, 0, f))
            b1 += value * load(functions, (number, step, 1, f))
            c1 += value * load(functions, (number, step, 2, f))
        for slot in range(second, third):
            value, f = load(strain, slot), function[slot]
            a2 += value * load(functions, (number, step, 0, f))
            b2 += value * load(functions, (number, step, 1, f))
            c2 += value * load(functions, (number, step, 2, f))
        for slot in range(third, last):
            value, f = load(strain, slot), function[slot]
            a3 += value * load(functions, (number, step, 0, f))
            b3 += value * load(functions, (number, step, 1, f))
            c3 += value * load(functions, (number, step, 2, f))
        h = robot.steps[step] * nominal
        x, y, z = magnus(
            h * a1, h * a2, h * a3, h * b1, h * b2, h * b3, h * c1, h * c2, h * c3
        )  # fmt: skip
        store(work.vectors, (0, step), x)
        store(work.vectors, (1, step), y)
        store(work.vectors, (2, step), z)
        largest = max(largest, highest(x * x + y * y + z * z))
    return largest


@inlined
def integrate_frames(robot, number, rotation, work):
    """Frames at the nodes and at the tip.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        rotation: On entry the base frame, on return the tip frame, lanes (3, 3).
        work: Workspace; ``strain`` is read, ``frames`` is the result.
    """
    largest = _rotation_vectors(robot, number, work)
    vectors, frames = work.vectors, work.frames
    a1, a2, a3 = load(rotation, (0, 0)), load(rotation, (0, 1)), load(rotation, (0, 2))
    b1, b2, b3 = load(rotation, (1, 0)), load(rotation, (1, 1)), load(rotation, (1, 2))
    c1, c2, c3 = load(rotation, (2, 0)), load(rotation, (2, 1)), load(rotation, (2, 2))
    for step in range(robot.steps.shape[0]):
        x, y, z = load(vectors, (0, step)), load(vectors, (1, step)), load(vectors, (2, step))
        squared = x * x + y * y + z * z
        if largest <= SMALL_ANGLE_SQUARED:
            sine, versine = small_rotation(squared)
        else:
            store(work.small, (0, 0), squared)
            for lane in range(robot.slot_index.shape[2]):
                value = get(work.small, (0, 0), lane)
                if value > SMALL_ANGLE_SQUARED:
                    angle = math.sqrt(value)
                    half = math.sin(0.5 * angle)
                    put(work.small, (0, 1), lane, math.sin(angle) / angle)
                    put(work.small, (0, 2), lane, 2.0 * half * half / value)
                else:
                    one, other = small_rotation(value)
                    put(work.small, (0, 1), lane, one)
                    put(work.small, (0, 2), lane, other)
            sine, versine = load(work.small, (0, 1)), load(work.small, (0, 2))
        a1, a2, a3 = turned_frame(a1, a2, a3, x, y, z, sine, versine)
        b1, b2, b3 = turned_frame(b1, b2, b3, x, y, z, sine, versine)
        c1, c2, c3 = turned_frame(c1, c2, c3, x, y, z, sine, versine)
        node = robot.step_node[step]
        if node >= 0:
            store(frames, (0, 0, node), a1)
            store(frames, (1, 0, node), a2)
            store(frames, (2, 0, node), a3)
            store(frames, (0, 1, node), b1)
            store(frames, (1, 1, node), b2)
            store(frames, (2, 1, node), b3)
            store(frames, (0, 2, node), c1)
            store(frames, (1, 2, node), c2)
            store(frames, (2, 2, node), c3)
    store(rotation, (0, 0), a1)
    store(rotation, (0, 1), a2)
    store(rotation, (0, 2), a3)
    store(rotation, (1, 0), b1)
    store(rotation, (1, 1), b2)
    store(rotation, (1, 2), b3)
    store(rotation, (2, 0), c1)
    store(rotation, (2, 1), c2)
    store(rotation, (2, 2), c3)


@inlined
def integrate_arms(robot, length, chord, work):
    """Lever arms ``p(l) - p(s)`` at the nodes and ``(p(l) - p(0)) / l``.

    Args:
        robot: RobotArrays.
        length: Rod lengths, lanes.
        chord: Result, lanes (3,) of ``work.small``, as an index into it.
        work: Workspace; ``frames`` is read, ``arm`` is the result.
    """
    frames, integration, weights = work.frames, robot.integration, robot.weights
    panel = robot.panel_nodes
    for i in range(3):
        whole = broadcast(frames, 0.0)
        for j in range(weights.shape[0]):
            whole += weights[j] * load(frames, (0, i, j))
        store(work.small, (chord, i), whole)
        for first in range(0, weights.shape[0], panel):
            for k in range(first, first + panel, 4):
                s0, s1, s2, s3 = whole, whole, whole, whole
                for j in range(first, first + panel):
                    tangent = load(frames, (0, i, j))
                    s0 -= integration[j, k] * tangent
                    s1 -= integration[j, k + 1] * tangent
                    s2 -= integration[j, k + 2] * tangent
                    s3 -= integration[j, k + 3] * tangent
                store(work.arm, (i, k), length * s0)
                store(work.arm, (i, k + 1), length * s1)
                store(work.arm, (i, k + 2), length * s2)
                store(work.arm, (i, k + 3), length * s3)
            for j in range(first, first + panel):  # beyond a panel its whole integral counts
                whole -= weights[j] * load(frames, (0, i, j))
