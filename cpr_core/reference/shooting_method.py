# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How continuous rods are integrated, and when their shooting ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import RK45

from .rod_integration import EIGHTH_ORDER, STEPS, Tableau

__all__ = ["ACCURATE", "TABLEAUS", "ShootingMethod"]

#: Explicit Runge-Kutta methods of orders 4, 5 and 8.
TABLEAUS: dict[str, Tableau] = {
    "RK4": Tableau(
        np.array([[0.0] * 4, [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]]),
        np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    ),
    "DOPRI5": Tableau(np.ascontiguousarray(RK45.A), np.ascontiguousarray(RK45.B)),
    "DOP853": EIGHTH_ORDER,
}


@dataclass(frozen=True)
class ShootingMethod:
    """How the rods are integrated and when the shooting ends.

    Attributes:
        tableau: Name in ``TABLEAUS``.
        steps: Steps along every rod.
        tolerance: On the residual: lengths in rod lengths, moments in EI/l, forces in EI/l^2.
    """

    tableau: str = "DOP853"
    steps: int = STEPS
    tolerance: float = 1e-11


ACCURATE = ShootingMethod()
