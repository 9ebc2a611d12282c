# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations of the platform in compiled code: matrices (3, 3), one for the whole robot."""

from __future__ import annotations

import math

from .kernel_decorators import kernel
from .lane_vectors import load_matrix, matrix_product, store_matrix, transposed

__all__ = [
    "multiply",
    "multiply_transposed",
    "roll_pitch_yaw_into",
    "rotation_exp_into",
    "rotation_from_angles_into",
    "rotation_log_into",
]


@kernel
def multiply(left, right, result):
    """Product of two (3, 3) matrices into a third."""
    store_matrix(result, (), matrix_product(load_matrix(left, ()), load_matrix(right, ())))


@kernel
def multiply_transposed(left, right, result):
    """Product of a (3, 3) matrix and the transpose of another."""
    product = matrix_product(load_matrix(left, ()), transposed(load_matrix(right, ())))
    store_matrix(result, (), product)


@kernel
def rotation_exp_into(x, y, z, rotation):
    """Rotation matrix ``exp((x, y, z)^)`` into an array (3, 3), Rodrigues' formula."""
    squared = x * x + y * y + z * z
    if squared < 0.1:
        # Taylor series to the last bit: cheaper than sine and cosine, and exact at zero.
        sine = 1.0 - squared / 6.0 * (
            1.0
            - squared
            / 20.0
            * (1.0 - squared / 42.0 * (1.0 - squared / 72.0 * (1.0 - squared / 110.0)))
        )
        versine = 0.5 - squared / 24.0 * (
            1.0
            - squared
            / 30.0
            * (1.0 - squared / 56.0 * (1.0 - squared / 90.0 * (1.0 - squared / 132.0)))
        )
    else:
        angle = math.sqrt(squared)
        sine = math.sin(angle) / angle
        half = math.sin(0.5 * angle)
        versine = 2.0 * half * half / squared
    rotation[0, 0] = 1.0 - versine * (y * y + z * z)
    rotation[1, 1] = 1.0 - versine * (x * x + z * z)
    rotation[2, 2] = 1.0 - versine * (x * x + y * y)
    rotation[0, 1] = versine * x * y - sine * z
    rotation[1, 0] = versine * x * y + sine * z
    rotation[0, 2] = versine * x * z + sine * y
    rotation[2, 0] = versine * x * z - sine * y
    rotation[1, 2] = versine * y * z - sine * x
    rotation[2, 1] = versine * y * z + sine * x


@kernel
def rotation_log_into(rotation, vector):
    """Rotation vector, of norm at most pi, of a rotation matrix, into an array (3,)."""
    x = 0.5 * (rotation[2, 1] - rotation[1, 2])
    y = 0.5 * (rotation[0, 2] - rotation[2, 0])
    z = 0.5 * (rotation[1, 0] - rotation[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (rotation[0, 0] + rotation[1, 1] + rotation[2, 2] - 1.0)
    if cosine > 0.0:
        scale = 1.0 if sine < 1e-8 else math.atan2(sine, cosine) / sine
        vector[0], vector[1], vector[2] = scale * x, scale * y, scale * z
        return
    # Near half a turn nothing is left of the sine: the axis is any column of (R + R^T) / 2 - cos I.
    longest = 0
    for axis in range(1, 3):
        if rotation[axis, axis] > rotation[longest, longest]:
            longest = axis
    squared = 0.0
    for axis in range(3):
        vector[axis] = 0.5 * (rotation[axis, longest] + rotation[longest, axis])
        if axis == longest:
            vector[axis] -= cosine
        squared += vector[axis] * vector[axis]
    scale = math.atan2(sine, cosine) / math.sqrt(squared)
    if x * vector[0] + y * vector[1] + z * vector[2] < 0.0:
        scale = -scale
    for axis in range(3):
        vector[axis] *= scale


@kernel
def roll_pitch_yaw_into(rotation, angles):
    """Angles (roll, pitch, yaw) of ``Rz(yaw) Ry(pitch) Rx(roll)`` into an array (3,)."""
    angles[0] = math.atan2(rotation[2, 1], rotation[2, 2])
    angles[1] = math.atan2(-rotation[2, 0], math.hypot(rotation[2, 1], rotation[2, 2]))
    angles[2] = math.atan2(rotation[1, 0], rotation[0, 0])


@kernel
def rotation_from_angles_into(roll, pitch, yaw, rotation):
    """``Rz(yaw) Ry(pitch) Rx(roll)`` into an array (3, 3)."""
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    rotation[0, 0], rotation[0, 1], rotation[0, 2] = (
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
    )
    rotation[1, 0], rotation[1, 1], rotation[1, 2] = (
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
    )
    rotation[2, 0], rotation[2, 1], rotation[2, 2] = -sp, cp * sr, cp * cr
