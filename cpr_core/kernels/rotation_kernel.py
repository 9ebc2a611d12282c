# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations along a rod: ``R' = R kappa^`` in steps of a Magnus expansion of order six.

Formulas that hold for numbers and for lanes alike.
"""

from __future__ import annotations

from .kernel_decorators import inlined, kernel
from .lane_vectors import add, add_scaled, cross, load_matrix, scaled, store_vector, subtract

__all__ = ["SMALL_ANGLE_SQUARED", "magnus", "rotation_steps", "small_rotation", "turned_frame"]

#: Squared angles up to which ``small_rotation`` is exact to the last bit.
SMALL_ANGLE_SQUARED = 1.0


@inlined
def magnus(a, b, c):
    """Rotation vector of a step from moments of the body curvature over the step.

    With ``A_i = h int x^i kappa dx`` over x from -1/2 to 1/2, ``a = 9/4 A_0 - 15 A_2``, ``b = 12 A_1``
    and ``c = 180 A_2 - 15 A_0`` (Blanes, Casas, Oteo and Ros 2009, Section 5.4): a + c / 12 is the whole
    turn, where all curvature is about one axis.
    """
    first = cross(a, b)
    second = subtract(scaled(1.0 / 60.0, cross(a, add_scaled(first, -2.0, c))), b)
    commutator = cross(add(add_scaled(c, 20.0, a), first), second)
    return add_scaled(add_scaled(a, 1.0 / 12.0, c), -1.0 / 240.0, commutator)


@kernel
def rotation_steps(curvature, lengths, vectors):
    """Rotation vectors of all steps along one rod.

    Args:
        curvature: Moments of the body curvature over G steps (``magnus``), [step, moment, component].
        lengths: Lengths of the steps, (G,).
        vectors: Result, (G, 3), such that ``R(end) = R(start) exp(vector^)``.
    """
    for step in range(lengths.shape[0]):
        a, b, c = scaled(lengths[step], load_matrix(curvature, step))
        store_vector(vectors, step, magnus(a, b, c))


@inlined
def small_rotation(squared):
    """``sin(a) / a`` and ``(1 - cos(a)) / a^2`` of a small squared angle, by Taylor's series."""
    sine = squared * (-1.0 / 342.0) + 1.0
    sine = squared * sine * (-1.0 / 272.0) + 1.0
    sine = squared * sine * (-1.0 / 210.0) + 1.0
    sine = squared * sine * (-1.0 / 156.0) + 1.0
    sine = squared * sine * (-1.0 / 110.0) + 1.0
    sine = squared * sine * (-1.0 / 72.0) + 1.0
    sine = squared * sine * (-1.0 / 42.0) + 1.0
    sine = squared * sine * (-1.0 / 20.0) + 1.0
    sine = squared * sine * (-1.0 / 6.0) + 1.0
    versine = squared * (-1.0 / 380.0) + 1.0
    versine = squared * versine * (-1.0 / 306.0) + 1.0
    versine = squared * versine * (-1.0 / 240.0) + 1.0
    versine = squared * versine * (-1.0 / 182.0) + 1.0
    versine = squared * versine * (-1.0 / 132.0) + 1.0
    versine = squared * versine * (-1.0 / 90.0) + 1.0
    versine = squared * versine * (-1.0 / 56.0) + 1.0
    versine = squared * versine * (-1.0 / 30.0) + 1.0
    versine = squared * versine * (-1.0 / 12.0) + 1.0
    return sine, 0.5 * versine


@inlined
def turned_frame(frame, vector, sine, versine):
    """``R exp(v^) = R + sine R v^ + versine R v^ v^``: row by row, as ``r^T v^ = (r x v)^T``."""
    return (
        _turned_row(frame[0], vector, sine, versine),
        _turned_row(frame[1], vector, sine, versine),
        _turned_row(frame[2], vector, sine, versine),
    )


@inlined
def _turned_row(row, vector, sine, versine):
    once = cross(row, vector)
    return add_scaled(add_scaled(row, sine, once), versine, cross(once, vector))
