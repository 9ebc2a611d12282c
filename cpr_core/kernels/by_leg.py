# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rows of ``by_leg`` in the workspace: lanes that are written or read leg by leg."""

__all__ = [
    "PIVOT",
    "PIVOT_INVERSE",
    "PIVOT_SCALE",
    "SINE",
    "SQUARED_ANGLE",
    "VERSINE",
]

#: Of a rotation: its squared angle, its sine over it, and one less its cosine over that.
SQUARED_ANGLE, SINE, VERSINE = 0, 1, 2
#: Of a pivot, with what it is measured by.
PIVOT, PIVOT_INVERSE, PIVOT_SCALE = 3, 4, 5
