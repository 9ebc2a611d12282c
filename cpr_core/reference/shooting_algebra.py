# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations, cross products and elimination of small systems, written in place."""

from __future__ import annotations

import math

from .reference_decorators import reference

__all__ = ["add_cross", "add_product", "add_skew", "eliminate", "turn"]


@reference
def turn(vector, rotation, result):
    """``exp(vector^) rotation`` into another matrix (3, n)."""
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    sine, versine = 1.0, 0.5
    if angle > 1e-8:
        sine = math.sin(angle) / angle
        versine = 2.0 * (math.sin(0.5 * angle) / angle) ** 2
    for j in range(rotation.shape[1]):
        x, y, z = rotation[0, j], rotation[1, j], rotation[2, j]
        ax = vector[1] * z - vector[2] * y
        ay = vector[2] * x - vector[0] * z
        az = vector[0] * y - vector[1] * x
        result[0, j] = x + sine * ax + versine * (vector[1] * az - vector[2] * ay)
        result[1, j] = y + sine * ay + versine * (vector[2] * ax - vector[0] * az)
        result[2, j] = z + sine * az + versine * (vector[0] * ay - vector[1] * ax)


@reference
def eliminate(matrix, right, size, columns):
    """Solve in place by Gauss with row pivoting: ``right[:size, :columns] = matrix^-1 right``."""
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, size):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for j in range(columns):
                right[k, j], right[pivot, j] = right[pivot, j], right[k, j]
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, size):
                matrix[i, j] -= factor * matrix[k, j]
            for j in range(columns):
                right[i, j] -= factor * right[k, j]
    for k in range(size - 1, -1, -1):
        for j in range(columns):
            value = right[k, j]
            for i in range(k + 1, size):
                value -= matrix[k, i] * right[i, j]
            right[k, j] = value / matrix[k, k]


@reference
def add_cross(factor, a, b, result):
    """Add ``factor a x b``."""
    result[0] += factor * (a[1] * b[2] - a[2] * b[1])
    result[1] += factor * (a[2] * b[0] - a[0] * b[2])
    result[2] += factor * (a[0] * b[1] - a[1] * b[0])


@reference
def add_product(factor, a, b, result):
    """Add ``factor a^ b^``, which is ``factor (b a^T - (a . b) 1)``."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    for i in range(3):
        for j in range(3):
            result[i, j] += factor * b[i] * a[j]
        result[i, i] -= factor * dot


@reference
def add_skew(factor, a, result):
    """Add ``factor a^``."""
    result[0, 1] -= factor * a[2]
    result[0, 2] += factor * a[1]
    result[1, 0] += factor * a[2]
    result[1, 2] -= factor * a[0]
    result[2, 0] -= factor * a[1]
    result[2, 1] += factor * a[0]
