# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rotations along a rod: ``R' = R kappa^`` in steps of a Magnus expansion of order six.

Formulas that hold for numbers and for lanes alike.
"""

from __future__ import annotations

from .kernel_decorators import inlined, kernel

__all__ = ["SMALL_ANGLE_SQUARED", "magnus", "rotation_steps", "small_rotation", "turned_frame"]

#: Squared angles up to which ``small_rotation`` is exact to the last bit.
SMALL_ANGLE_SQUARED = 1.0


@inlined
def magnus(a1, a2, a3, b1, b2, b3, c1, c2, c3):
    """Rotation vector of a step from moments of the body curvature over the step.

    With ``A_i = h int x^i kappa dx`` over x from -1/2 to 1/2, ``a = 9/4 A_0 - 15 A_2``, ``b = 12 A_1``
    and ``c = 180 A_2 - 15 A_0`` (Blanes, Casas, Oteo and Ros 2009, Section 5.4): a + c / 12 is the whole
    turn, where all curvature is about one axis.
    """
    # f = a x b;  s = a x (f - 2 c) / 60 - b
    f1, f2, f3 = a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1
    g1, g2, g3 = f1 - 2.0 * c1, f2 - 2.0 * c2, f3 - 2.0 * c3
    s1 = (1.0 / 60.0) * (a2 * g3 - a3 * g2) - b1
    s2 = (1.0 / 60.0) * (a3 * g1 - a1 * g3) - b2
    s3 = (1.0 / 60.0) * (a1 * g2 - a2 * g1) - b3
    u1, u2, u3 = 20.0 * a1 + c1 + f1, 20.0 * a2 + c2 + f2, 20.0 * a3 + c3 + f3
    return (
        a1 + (1.0 / 12.0) * c1 - (1.0 / 240.0) * (u2 * s3 - u3 * s2),
        a2 + (1.0 / 12.0) * c2 - (1.0 / 240.0) * (u3 * s1 - u1 * s3),
        a3 + (1.0 / 12.0) * c3 - (1.0 / 240.0) * (u1 * s2 - u2 * s1),
    )


@kernel
def rotation_steps(curvature, lengths, vectors):
    """Rotation vectors of all steps along one rod.

    Args:
        curvature: Moments of the body curvature over G steps (``magnus``), [component, moment, step].
        lengths: Lengths of the steps, (G,).
        vectors: Result, (3, G), such that ``R(end) = R(start) exp(vector^)``.
    """
    for step in range(lengths.shape[0]):
        h = lengths[step]
        vectors[0, step], vectors[1, step], vectors[2, step] = magnus(
            h * curvature[0, 0, step], h * curvature[1, 0, step], h * curvature[2, 0, step],
            h * curvature[0, 1, step], h * curvature[1, 1, step], h * curvature[2, 1, step],
            h * curvature[0, 2, step], h * curvature[1, 2, step], h * curvature[2, 2, step],
        )  # fmt: skip


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
def turned_frame(a, b, c, x, y, z, sine, versine):
    """One row (a, b, c) of ``R exp((x, y, z)^)``: ``r + sine r x^ + versine (r x^) x^``."""
    # r x^ is minus x cross r.
    u, v, w = b * z - c * y, c * x - a * z, a * y - b * x
    p, q, r = v * z - w * y, w * x - u * z, u * y - v * x
    return a + sine * u + versine * p, b + sine * v + versine * q, c + sine * w + versine * r
