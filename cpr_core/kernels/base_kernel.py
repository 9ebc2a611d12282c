# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The bases of a group of legs: where their rods begin, and how their coordinates move them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .by_leg import SHIFT, SINE, VERSINE
from .kernel_decorators import inlined
from .lane_vectors import add_scaled, cross, load_matrix, load_vector, scaled, transposed
from .lanes import broadcast, load, put

__all__ = ["Base", "BaseMotion", "base_of", "motor_motion", "passive_motion"]


class Base(NamedTuple):
    """Where rods begin: vectors, matrices and lanes."""

    position: Any  # p_0
    frame: Any  # R(0)
    length: Any  # l


class BaseMotion(NamedTuple):
    """What a coordinate of the base does to the rod."""

    turn: Any  # omega_a, concentrated at sigma = 0
    shift: Any  # d p_0 / d q_a
    extension: Any  # d l / d q_a


@inlined
def base_of(robot, number, state, work):
    """The bases of a group at a state."""
    group = robot.groups[number]
    position, length = load_vector(group.base_position, ()), load(group.length, ())
    if robot.shifted:
        for leg in range(group.shift_index.shape[0]):
            index = group.shift_index[leg]
            put(work.by_leg, SHIFT, leg, state[index] if index >= 0 else 0.0)
        shift = load(work.by_leg, SHIFT)
        # The rod of an extensible leg comes out of its base point: its direction of shift is zero.
        position = add_scaled(position, shift, load_vector(group.translation_axis, ()))
        length = length + load(group.extensible, ()) * (shift - length)
    return Base(position, _base_frame(group, state, work), length)


@inlined
def _base_frame(group, state, work):
    """Frames at motor zero, turned by the angles in the state."""
    turned = False
    for leg in range(group.turn_index.shape[0]):
        index = group.turn_index[leg]
        turned = turned or index >= 0
        angle = state[index] if index >= 0 else 0.0
        half = math.sin(0.5 * angle)
        put(work.by_leg, SINE, leg, math.sin(angle))
        put(work.by_leg, VERSINE, leg, 2.0 * half * half)
    frame = load_matrix(group.base_rotation, ())
    if turned:
        axis = load_vector(group.rotation_axis, ())
        sine, versine = load(work.by_leg, SINE), load(work.by_leg, VERSINE)
        x, y, z = transposed(frame)
        frame = transposed((
            _turned(x, axis, sine, versine),
            _turned(y, axis, sine, versine),
            _turned(z, axis, sine, versine),
        ))  # fmt: skip
    return frame


@inlined
def _turned(vector, axis, sine, versine):
    """``exp(angle axis^) v = v + sine axis x v + versine axis x (axis x v)``."""
    once = cross(axis, vector)
    return add_scaled(add_scaled(vector, sine, once), versine, cross(axis, once))


@inlined
def motor_motion(group):
    """What the motor does."""
    return BaseMotion(
        scaled(load(group.turn_motor, ()), load_vector(group.rotation_axis, ())),
        scaled(load(group.shift_motor, ()), load_vector(group.translation_axis, ())),
        load(group.extensible, ()),
    )


@inlined
def passive_motion(group):
    """What the passive coordinate does."""
    return BaseMotion(
        scaled(load(group.turn_passive, ()), load_vector(group.rotation_axis, ())),
        scaled(load(group.shift_passive, ()), load_vector(group.translation_axis, ())),
        broadcast(load(group.length, ()), 0.0),
    )
