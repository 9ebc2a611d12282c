# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rows of ``by_leg`` in the workspace: lanes that are written or read leg by leg."""

__all__ = [
    "MOTOR",
    "PIVOT",
    "PIVOT_INVERSE",
    "PIVOT_SCALE",
    "SHIFT",
    "SINE",
    "SQUARED_ANGLE",
    "VERSINE",
]

#: Of a base, and of a rotation: its squared angle, its sine over it, and one less its cosine over that.
SHIFT, SQUARED_ANGLE, SINE, VERSINE = 0, 1, 2, 3
#: Of a column of the motors; of a pivot, with what it is measured by.
MOTOR, PIVOT, PIVOT_INVERSE, PIVOT_SCALE = 4, 5, 6, 7
