# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations in three dimensions: the few operations the kernels and the interfaces need."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .compiled import kernel
from .errors import InvalidQuaternion
from .lane_vectors import load_matrix, matrix_product, store_matrix, transposed
from .validation import checked_vector

__all__ = [
    "angle_motions",
    "multiply",
    "multiply_transposed",
    "quaternion_from_rotation",
    "roll_pitch_yaw",
    "roll_pitch_yaw_into",
    "rotation_exp",
    "rotation_exp_into",
    "rotation_from_angles",
    "rotation_from_angles_into",
    "rotation_from_quaternion",
    "rotation_log",
    "rotation_log_into",
    "skew",
]

#: Quaternions whose norm differs from 1 by more than this are refused, not normalised.
QUATERNION_TOLERANCE = 1e-3


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


def rotation_exp(vector: ArrayLike) -> NDArray[np.float64]:
    """Rotation matrix ``exp(vector^)``, (3, 3), of a rotation vector of shape (3,)."""
    x, y, z = np.asarray(vector, float)
    rotation = np.empty((3, 3))
    rotation_exp_into(x, y, z, rotation)
    return rotation


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


def roll_pitch_yaw(rotation: ArrayLike) -> NDArray[np.float64]:
    """Angles (roll, pitch, yaw) of ``Rz(yaw) Ry(pitch) Rx(roll)``, |pitch| <= pi/2, shape (3,)."""
    angles = np.empty(3)
    roll_pitch_yaw_into(np.array(rotation, float), angles)
    return angles


def rotation_from_angles(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    """``Rz(yaw) Ry(pitch) Rx(roll)``, shape (3, 3)."""
    rotation = np.empty((3, 3))
    rotation_from_angles_into(roll, pitch, yaw, rotation)
    return rotation


def angle_motions(rotation: ArrayLike) -> NDArray[np.float64]:
    """World rotations of unit roll, pitch and yaw rates at a rotation, as columns, (3, 3)."""
    matrix = np.asarray(rotation, float)
    yaw = math.atan2(matrix[1, 0], matrix[0, 0])
    return np.column_stack([matrix[:, 0], [-math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])


def skew(vector: ArrayLike) -> NDArray[np.float64]:
    """Matrix ``v^`` with ``v^ u = v x u``, shape (3, 3)."""
    x, y, z = np.asarray(vector, float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_log(rotation: ArrayLike) -> NDArray[np.float64]:
    """Rotation vector, shape (3,), of norm at most pi, of a rotation matrix."""
    w, x, y, z = quaternion_from_rotation(rotation)
    axis = np.array([x, y, z])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return 2.0 * axis
    return 2.0 * math.atan2(sine, w) / sine * axis


@kernel
def rotation_log_into(rotation, vector):
    """Rotation vector of a rotation by less than a right angle, into an array (3,)."""
    x = 0.5 * (rotation[2, 1] - rotation[1, 2])
    y = 0.5 * (rotation[0, 2] - rotation[2, 0])
    z = 0.5 * (rotation[1, 0] - rotation[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 1.0 if sine < 1e-8 else math.asin(min(1.0, sine)) / sine
    vector[0], vector[1], vector[2] = scale * x, scale * y, scale * z


def quaternion_from_rotation(rotation: ArrayLike) -> NDArray[np.float64]:
    """Unit quaternion (w, x, y, z) with w >= 0 of a rotation matrix."""
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(rotation, float).tolist()
    # Squares of 2w, 2x, 2y, 2z; the largest is divided by, so no digit is lost.
    squares = (1.0 + a + e + i, 1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i)
    largest = squares.index(max(squares))
    w, x, y, z = (
        (squares[0], h - f, c - g, d - b),
        (h - f, squares[1], b + d, c + g),
        (c - g, b + d, squares[2], f + h),
        (d - b, c + g, f + h, squares[3]),
    )[largest]
    scale = (-1.0 if w < 0.0 else 1.0) / math.sqrt(w * w + x * x + y * y + z * z)
    return np.array([scale * w, scale * x, scale * y, scale * z])


def rotation_from_quaternion(quaternion_wxyz: ArrayLike) -> NDArray[np.float64]:
    """Rotation matrix of a unit quaternion (w, x, y, z).

    Raises:
        InvalidRequest: Not four numbers.
        NonFiniteInput: A component is NaN or infinite.
        InvalidQuaternion: The norm differs from 1 by more than ``QUATERNION_TOLERANCE``.
    """
    quaternion = checked_vector("quaternion", quaternion_wxyz, 4, "w x y z")
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1.0) > QUATERNION_TOLERANCE:
        raise InvalidQuaternion(
            "quaternion", f"expected unit length, got norm {norm:g} of {quaternion.tolist()}"
        )
    w, x, y, z = quaternion / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
