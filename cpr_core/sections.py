"""Cross-sections of rods: area and second moments about (d1, d2, d3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["CircularSection"]


@dataclass(frozen=True)
class CircularSection:
    """Solid circle.

    Attributes:
        radius: Radius [m].
    """

    radius: float

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return math.pi * self.radius**2

    @property
    def second_moments(self) -> tuple[float, float, float]:
        """Torsion constant J_1 and second moments J_2, J_3 [m^4], Eq. (6)."""
        bending = 0.25 * math.pi * self.radius**4
        return 2.0 * bending, bending, bending
