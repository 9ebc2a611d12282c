"""A slender rod: geometry, elasticity and the strain modes that describe its shape."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .quadrature import RodGrid
from .sections import CircularSection
from .strain_basis import Legendre, StrainBasis

__all__ = ["Rod", "StrainModes"]


@dataclass(frozen=True)
class StrainModes:
    """Assumed strain modes, Eqs. (3)-(4): kappa(s) = Phi(s) q_e.

    Attributes:
        counts: Number of modes m_1 (torsion), m_2, m_3 (bending about d2, d3).
        basis: Shape functions.
    """

    counts: tuple[int, int, int]
    basis: StrainBasis = field(default_factory=Legendre)

    @property
    def total(self) -> int:
        """Number of strain coordinates of the rod."""
        return sum(self.counts)

    @property
    def directions(self) -> NDArray[np.int64]:
        """Strain component of every coordinate: 0 torsion, 1 and 2 bending."""
        return np.repeat(np.arange(3), self.counts)

    def values(self, sigma: NDArray[np.float64]) -> NDArray[np.float64]:
        """Value of every coordinate's shape function, shape (len(sigma), total)."""
        return np.hstack([self.basis.values(sigma, count) for count in self.counts])


@dataclass(frozen=True)
class Rod:
    """Inextensible, unshearable (Kirchhoff) rod, straight at rest.

    Attributes:
        length: Length l [m].
        section: Cross-section.
        young_modulus: E [Pa].
        shear_modulus: G [Pa].
        density: Mass density rho [kg/m^3].
    """

    length: float
    section: CircularSection
    young_modulus: float
    shear_modulus: float
    density: float

    @property
    def mass_per_length(self) -> float:
        """Mass per length, rho A [kg/m]."""
        return self.density * self.section.area

    @property
    def rigidities(self) -> NDArray[np.float64]:
        """H_a = diag(G J1, E J2, E J3) of Eq. (6) as a vector [N m^2]."""
        torsion, bending_2, bending_3 = self.section.second_moments
        return np.array(
            [
                self.shear_modulus * torsion,
                self.young_modulus * bending_2,
                self.young_modulus * bending_3,
            ]
        )

    def stiffness(self, modes: StrainModes, grid: RodGrid) -> NDArray[np.float64]:
        """K_e = int Phi^T H_a Phi ds of Eq. (7), shape (m, m) [N m^3]."""
        values = modes.values(grid.nodes)
        directions = modes.directions
        gram = values.T @ (grid.weights[:, None] * values)
        same = directions[:, None] == directions
        return self.length * np.where(same, gram * self.rigidities[directions], 0.0)
