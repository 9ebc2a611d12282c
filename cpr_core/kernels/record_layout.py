# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where things are in the record of an equilibrium, behind its state of N numbers.

9 platform rotation | 3 position | energy | residual | Newton steps | 3 signs | n motor efforts

A row of numbers that imposes a pose begins alike: 9 platform rotation | 3 position | n motors.
"""

from __future__ import annotations

__all__ = [
    "EFFORT",
    "ENERGY",
    "IMPOSED_MOTORS",
    "INDEX_FREE",
    "INDEX_LOCKED",
    "INVERSE_SIGN",
    "POSITION",
    "RESIDUAL",
    "ROTATION",
    "SIGNS",
    "STEPS",
]

ROTATION, POSITION, ENERGY, RESIDUAL, STEPS, SIGNS, EFFORT = 0, 9, 12, 13, 14, 15, 18
#: Where the motors are in a row that imposes a pose.
IMPOSED_MOTORS = POSITION + 3
#: Order of the signs: stability indices with the motors locked and free, sign of the determinant of the
#: inverse problem.
INDEX_LOCKED, INDEX_FREE, INVERSE_SIGN = 0, 1, 2
