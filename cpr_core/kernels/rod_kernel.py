# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Along the rods of a group of legs: frames at the nodes, and integrals from the nodes to the tip."""

from __future__ import annotations

import math

from .by_leg import SINE, SQUARED_ANGLE, VERSINE
from .kernel_decorators import inlined
from .lane_vectors import (
    add_scaled,
    dot,
    load_vector,
    scaled,
    store_vector,
    subtract_scaled,
    transposed,
    zero_vector,
)
from .lanes import get, highest, load, put, store
from .rotation_kernel import SMALL_ANGLE_SQUARED, magnus, small_rotation, turned_frame

__all__ = ["integrate_beyond", "integrate_frames"]


@inlined
def integrate_frames(robot, number, rod, base_frame, work):
    """Frames at the nodes of a rod; returns the frame at its end.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        rod: Number of the rod in its chain.
        base_frame: Frame where it begins, a matrix of lanes.
        work: Workspace; ``coordinates`` is read, ``frames`` is the result.
    """
    largest = _rotation_vectors(robot, number, rod, work)
    frame = base_frame
    for step in range(robot.steps.shape[0]):
        vector = load_vector(work.rotation_vectors, step)
        squared = dot(vector, vector)
        if largest <= SMALL_ANGLE_SQUARED:
            sine, versine = small_rotation(squared)
        else:
            sine, versine = _rotation_of_any_angle(robot.slot_index.shape[2], squared, work)
        frame = turned_frame(frame, vector, sine, versine)
        node = robot.step_node[step]
        if node >= 0:
            directions = transposed(frame)
            store_vector(work.frames, (rod, 0, node), directions[0])
            store_vector(work.frames, (rod, 1, node), directions[1])
            store_vector(work.frames, (rod, 2, node), directions[2])
    return frame


@inlined
def _rotation_vectors(robot, number, rod, work):
    """Rotation vectors of all steps; returns the highest squared angle of a step."""
    # Strain coordinates are curvatures at the nominal length: the rotation does not see the length.
    nominal = load(robot.rods[number, rod].length, ())
    largest = 0.0
    for step in range(robot.steps.shape[0]):
        by_component = (
            _curvature_moments(robot, number, rod, step, 0, work),
            _curvature_moments(robot, number, rod, step, 1, work),
            _curvature_moments(robot, number, rod, step, 2, work),
        )
        a, b, c = scaled(robot.steps[step] * nominal, transposed(by_component))
        vector = magnus(a, b, c)
        store_vector(work.rotation_vectors, step, vector)
        largest = max(largest, highest(dot(vector, vector)))
    return largest


@inlined
def _curvature_moments(robot, number, rod, step, component, work):
    """The three moments of a component of the curvature over a step (``magnus``)."""
    moments = zero_vector(work.coordinates)
    if robot.rods[number, rod].curved:
        moments = load_vector(robot.rest_steps, (number, rod, step, component))
    start = robot.rods[number, rod].component_start
    for slot in range(start[component], start[component + 1]):
        function = load_vector(robot.step_functions, (number, step, robot.function[number, slot]))
        moments = add_scaled(moments, load(work.coordinates, slot), function)
    return moments


@inlined
def _rotation_of_any_angle(width, squared, work):
    """``small_rotation`` where some leg turns too far for the series."""
    store(work.by_leg, SQUARED_ANGLE, squared)
    for leg in range(width):
        value = get(work.by_leg, SQUARED_ANGLE, leg)
        if value > SMALL_ANGLE_SQUARED:
            angle = math.sqrt(value)
            half = math.sin(0.5 * angle)
            sine, versine = math.sin(angle) / angle, 2.0 * half * half / value
        else:
            sine, versine = small_rotation(value)
        put(work.by_leg, SINE, leg, sine)
        put(work.by_leg, VERSINE, leg, versine)
    return load(work.by_leg, SINE), load(work.by_leg, VERSINE)


@inlined
def integrate_beyond(robot, values, result):
    """Integrals of a field of vectors over sigma, from every node to the tip.

    Two nodes at a time: a value serves both.

    Args:
        robot: RobotArrays.
        values: At the nodes, lanes (K, 3).
        result: Lanes (K + 1, 3); last: the integral over the whole rod.
    """
    integration, weights, panel = robot.integration, robot.weights, robot.panel_nodes
    nodes = weights.shape[0]
    whole = zero_vector(values)
    for node in range(nodes):
        whole = add_scaled(whole, weights[node], load_vector(values, node))
    store_vector(result, nodes, whole)
    for first in range(0, nodes, panel):
        for node in range(first, first + panel, 2):
            beyond, beyond_next = whole, whole
            for source in range(first, first + panel):
                value = load_vector(values, source)
                beyond = subtract_scaled(beyond, integration[source, node], value)
                beyond_next = subtract_scaled(beyond_next, integration[source, node + 1], value)
            store_vector(result, node, beyond)
            store_vector(result, node + 1, beyond_next)
        for source in range(first, first + panel):  # beyond a panel its whole integral counts
            whole = subtract_scaled(whole, weights[source], load_vector(values, source))
