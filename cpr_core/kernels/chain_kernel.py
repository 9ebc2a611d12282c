# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The chains of a group of legs from base to tip: where every element begins, and where they lead."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .by_leg import SINE, VERSINE
from .kernel_arrays import Element
from .kernel_decorators import inlined
from .lane_vectors import (
    add,
    add_scaled,
    load_matrix,
    load_vector,
    matrix_product,
    matrix_vector,
    store_vector,
)
from .lanes import get, load, put, store
from .rod_kernel import integrate_beyond, integrate_frames
from .rotation_kernel import turned_frame

__all__ = ["TipPose", "place_chain", "rod_length"]


class TipPose(NamedTuple):
    """Where the tips of a group are: a vector and a matrix of lanes, in the world."""

    position: Any
    frame: Any


@inlined
def place_chain(robot, number, work):
    """Go through the chains of a group; returns the TipPose of each.

    Args:
        robot: RobotArrays.
        number: Number of the group.
        work: Workspace; ``coordinates`` is read, the fields ``element_...``, ``frames`` and ``arm`` are
            the result.
    """
    group = robot.groups[number]
    position, frame = load_vector(group.base_position, ()), load_matrix(group.base_rotation, ())
    for e in range(robot.elements.shape[1]):
        element = robot.elements[number, e]
        store_vector(work.element_position, e, position)
        if element.kind == Element.ROD:
            r = element.rod
            frame = integrate_frames(robot, number, r, frame, work)
            integrate_beyond(robot, work.frames[r, 0], work.arm[r])
            chord = load_vector(work.arm, (r, robot.weights.shape[0]))
            position = add_scaled(position, rod_length(robot, number, r, work), chord)
        elif element.kind == Element.TURN:
            axis = load_vector(element.axis, ())
            store_vector(work.element_axis, e, matrix_vector(frame, axis))
            sine, versine = _turn_of_joint(element, work)
            frame = turned_frame(frame, axis, sine, versine)
        elif element.kind == Element.SHIFT:
            axis = matrix_vector(frame, load_vector(element.axis, ()))
            store_vector(work.element_axis, e, axis)
            way = load(work.coordinates, element.slot) + load(element.zero, ())
            position = add_scaled(position, way, axis)
        elif element.kind == Element.LINK:
            offset = matrix_vector(frame, load_vector(element.offset, ()))
            store_vector(work.element_axis, e, offset)
            center = matrix_vector(frame, load_vector(element.center, ()))
            store_vector(work.element_center, e, center)
            position = add(position, offset)
            frame = matrix_product(frame, load_matrix(element.rotation, ()))
    store_vector(work.element_position, robot.elements.shape[1], position)
    return TipPose(position, frame)


@inlined
def rod_length(robot, number, r, work):
    """Lengths of a rod: nominal, or those that motors have fed [m]."""
    rod = robot.rods[number, r]
    length = load(rod.length, ())
    if rod.length_slot >= 0:
        fed = load(rod.fed_zero, ()) + load(work.coordinates, rod.length_slot)
        length += load(rod.extensible, ()) * (fed - length)
    return length


@inlined
def _turn_of_joint(element, work):
    """Sine, and one less cosine, of the angles of a joint."""
    store(work.by_leg, SINE, load(work.coordinates, element.slot) + load(element.zero, ()))
    for lane in range(element.zero.shape[0]):
        angle = get(work.by_leg, SINE, lane)
        half = math.sin(0.5 * angle)
        put(work.by_leg, SINE, lane, math.sin(angle))
        put(work.by_leg, VERSINE, lane, 2.0 * half * half)
    return load(work.by_leg, SINE), load(work.by_leg, VERSINE)
