# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations in three dimensions, for use from Python."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InvalidQuaternion, InvalidRequest
from .kernels.rotation_matrices import (
    roll_pitch_yaw_into,
    rotation_exp_into,
    rotation_from_angles_into,
)
from .validation import checked_matrix, checked_vector

__all__ = [
    "ROTATION_TOLERANCE",
    "angle_motions",
    "checked_quaternion",
    "directions_across",
    "nearest_rotation",
    "projected_rotation",
    "quaternion_from_rotation",
    "roll_pitch_yaw",
    "rotation_exp",
    "rotation_from_angles",
    "rotation_from_quaternion",
    "rotation_log",
    "rotations_exp",
    "rotations_log",
    "skew",
    "turn_about_z",
    "turn_between",
    "turned",
    "turns_by_vector",
    "vectors_by_turn",
]

#: Quaternions whose norm differs from 1 by more than this are refused, not normalised.
QUATERNION_TOLERANCE = 1e-3

#: Matrices that stretch some direction by more than this part of it are refused as rotations: rounding
#: to two digits stays below.
ROTATION_TOLERANCE = 0.02

#: Angles below which of a series, where it counts by its square, the first term is all that is left.
_SMALL = 1e-5

#: The one direction near which `directions_across` turns quickly: none that descriptions have.
_POLE = np.array([0.48, -0.64, 0.6])
_ACROSS_POLE = np.array([[0.8, 0.6, 0.0], [-0.36, 0.48, 0.8]])
#: e^ for the three unit vectors e.
_CROSS = -np.cross(np.eye(3)[:, None], np.eye(3)[None])


def rotation_exp(vector: ArrayLike) -> NDArray[np.float64]:
    """Rotation matrix ``exp(vector^)``, (3, 3), of a rotation vector of shape (3,)."""
    x, y, z = np.asarray(vector, float)
    rotation = np.empty((3, 3))
    rotation_exp_into(x, y, z, rotation)
    return rotation


def rotations_exp(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrices of many rotation vectors at once: (..., 3) to (..., 3, 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = np.tensordot(vectors, _CROSS, 1)
    # sin(a) / a and (1 - cos(a)) / a^2, without loss at small angles.
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    return np.eye(3) + first * cross + second * (cross @ cross)


def rotations_log(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation vectors of norm at most pi of many rotation matrices at once: (..., 3, 3) to (..., 3)."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(rotations, (-2, -1), (0, 1))
    # Four times q q^T, of the unit quaternion: the row of the largest square loses no digit.
    products = [
        [1.0 + a + e + i, h - f, c - g, d - b],
        [h - f, 1.0 + a - e - i, b + d, c + g],
        [c - g, b + d, 1.0 - a + e - i, f + h],
        [d - b, c + g, f + h, 1.0 - a - e + i],
    ]
    largest = np.argmax([products[row][row] for row in range(4)], axis=0)
    w, *vector = np.take_along_axis(np.array(products), largest[None, None], axis=0)[0]
    sine = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    half = np.arctan2(sine, np.abs(w))
    scale = np.divide(half, sine, out=np.zeros_like(sine), where=sine > 0.0)
    return np.asarray((np.where(w < 0.0, -2.0, 2.0) * scale)[..., None] * np.stack(vector, axis=-1))


def turns_by_vector(vector: ArrayLike) -> NDArray[np.float64]:
    """How a rotation turns with its vector: exp((v + dv)^) = exp((J dv)^) exp(v^) with J, (3, 3)."""
    angle, cross = float(np.linalg.norm(vector)), skew(vector)
    first = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    # It is multiplied by the square of the angle: no digit is lost.
    second = 1.0 / 6.0 if angle < _SMALL else (1.0 - math.sin(angle) / angle) / angle**2
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross))


def vectors_by_turn(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """How rotation vectors change with a turn: inverses of :func:`turns_by_vector`, (..., 3, 3).

    Args:
        vectors: Rotation vectors of less than a turn, (..., 3).
    """
    half = 0.5 * np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = np.tensordot(vectors, _CROSS, 1)
    other = np.where(half < _SMALL, 1.0, half)
    second = np.where(half < _SMALL, 1.0 / 12.0, 0.25 * (1.0 - other / np.tan(other)) / other**2)
    return np.asarray(np.eye(3) - 0.5 * cross + second * (cross @ cross))


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
    w, x, y, z = _unit_quaternion(rotation)
    sine = math.hypot(x, y, z)
    scale = 2.0 if sine < 1e-12 else 2.0 * math.atan2(sine, w) / sine
    return np.array([scale * x, scale * y, scale * z])


def quaternion_from_rotation(rotation: ArrayLike) -> NDArray[np.float64]:
    """Unit quaternion (w, x, y, z) with w >= 0 of a rotation matrix."""
    return np.array(_unit_quaternion(rotation))


def _unit_quaternion(rotation: ArrayLike) -> tuple[float, float, float, float]:
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
    return scale * w, scale * x, scale * y, scale * z


def checked_quaternion(quaternion_wxyz: ArrayLike) -> list[float]:
    """Components w, x, y, z of a unit quaternion, whose length is one to the last digit.

    Raises:
        InvalidRequest: Not four numbers.
        NonFiniteInput: A component is NaN or infinite.
        InvalidQuaternion: The norm differs from 1 by more than ``QUATERNION_TOLERANCE``.
    """
    quaternion = checked_vector("quaternion", quaternion_wxyz, 4, "w x y z").tolist()
    norm = math.hypot(*quaternion)
    if abs(norm - 1.0) > QUATERNION_TOLERANCE:
        raise InvalidQuaternion(
            "quaternion", f"expected unit length, got norm {norm:g} of {quaternion}"
        )
    return [number / norm for number in quaternion]


def rotation_from_quaternion(quaternion_wxyz: ArrayLike) -> NDArray[np.float64]:
    """Rotation matrix of a unit quaternion (w, x, y, z); raises as `checked_quaternion` does."""
    w, x, y, z = checked_quaternion(quaternion_wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turn_between(first: ArrayLike, last: ArrayLike) -> NDArray[np.float64]:
    """Rotation vector in the world, (3,), that leads from one orientation to another the short way.

    Args:
        first: Unit quaternion (w, x, y, z).
        last: The same.
    """
    a, b, c, d = np.asarray(last, float).tolist()
    w, x, y, z = np.asarray(first, float).tolist()
    # last times the conjugate of first
    cosine = a * w + b * x + c * y + d * z
    axis = (
        w * b - a * x - (c * z - d * y),
        w * c - a * y - (d * x - b * z),
        w * d - a * z - (b * y - c * x),
    )
    sine = math.hypot(*axis)
    scale = 2.0 if sine < 1e-12 else 2.0 * math.atan2(sine, abs(cosine)) / sine
    scale = -scale if cosine < 0.0 else scale
    return np.array([scale * part for part in axis])


def nearest_rotation(name: str, matrix: ArrayLike) -> NDArray[np.float64]:
    """The rotation matrix, (3, 3), nearest to a rounded one.

    Args:
        name: What the matrix is called, in errors.
        matrix: Nearly a rotation, (3, 3).

    Raises:
        InvalidRequest: Not a 3 x 3 matrix, or one that stretches, shears or mirrors by more than
            ``ROTATION_TOLERANCE``.
        NonFiniteInput: A NaN or an infinity.
    """
    given = checked_matrix(name, matrix, 3, 3)
    left, stretches, right = np.linalg.svd(given)
    rotation = np.asarray(left @ right, float)
    stretched = np.abs(stretches - 1.0).max()
    if stretched > ROTATION_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise InvalidRequest(
            name,
            "expected a rotation matrix, orthogonal and of determinant 1 up to rounding, "
            f"got {given.tolist()}",
        )
    return rotation


def turned(vector: NDArray[np.float64], rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """A twist or a wrench, (6,), of the same point in turned axes.

    Args:
        vector: In axes of its own, (6,).
        rotation: From these axes to those of the result, (3, 3).
    """
    both: NDArray[np.float64] = vector.reshape(2, 3) @ rotation.T
    return both.ravel()


def turn_about_z(rotation: NDArray[np.float64]) -> float:
    """Angle from -pi to pi of the turn about z that is nearest to a rotation, (3, 3).

    A tilt of the rest, however turned itself, does not change it.
    """
    (a, b, _), (c, d, _), _ = rotation.tolist()
    return math.atan2(c - b, a + d)


def projected_rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation, (3, 3), nearest to any matrix, (3, 3)."""
    left, _, right = np.linalg.svd(matrix)
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ right)


def directions_across(direction: ArrayLike) -> NDArray[np.float64]:
    """Two unit directions across a unit direction and each other, as rows, (2, 3).

    They change smoothly with it, so that what is written in them does not jump where it is varied.
    """
    reflected = np.asarray(direction, float) - _POLE
    square = float(reflected @ reflected)
    if square < 1e-20:
        return _ACROSS_POLE.copy()
    # The reflection that takes the pole to the direction takes what is across one across the other.
    return _ACROSS_POLE - np.outer(_ACROSS_POLE @ reflected, 2.0 / square * reflected)
