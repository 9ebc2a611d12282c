# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A slender rod: geometry, elasticity and the strain modes that describe its shape."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ..validation import cached_property
from .quadrature import MAGNUS_WEIGHTS, RodGrid, distinct_stations, rod_grid
from .sections import Section
from .strain_basis import DescribedBasis, Legendre, StrainBasis

__all__ = ["DIRECTIONS", "MOST_MODES", "UNIFORM", "Profile", "Rod", "StrainModes", "strain_series"]

Floats = NDArray[np.float64]

_NONE: Floats = np.zeros(0)
#: Of a panel of the mean rigidity: a tip a hundredth as thick as the base is integrated to 1e-11.
_POINTS_OF_MEAN = 64
#: Names of the strain components.
DIRECTIONS = ("torsion", "bending_2", "bending_3")
#: Modes that may be asked for in a direction; the truth is reached to the last digit long before.
MOST_MODES = 40


def strain_series(strain: Mapping[str, Sequence[float]]) -> tuple[Floats, Floats, Floats]:
    """Series of the three strain components, by their names; none of what is not named."""
    torsion, bending_2, bending_3 = (np.array(strain.get(name, ()), float) for name in DIRECTIONS)
    return torsion, bending_2, bending_3


@dataclass(frozen=True)
class StrainModes:
    """Assumed strain modes, Eqs. (3)-(4): kappa(s) = Phi(s) q_e, and what a rod has at rest beyond them.

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

    @cached_property
    def _columns(self) -> NDArray[np.int64]:
        """Shape function of every coordinate."""
        return np.concatenate([np.arange(count) for count in self.counts])

    @property
    def identity(self) -> Hashable:
        """What tells modes from others: themselves if their basis, anybody's, has a hash."""
        try:
            hash(self)
        except TypeError:
            return id(self)
        return self

    def with_counts(self, modes: int) -> StrainModes:
        """As many in every direction that has any."""
        torsion, bending_2, bending_3 = (modes if count else 0 for count in self.counts)
        return replace(self, counts=(torsion, bending_2, bending_3))

    def richer(self, more: int, missing: int = 0) -> StrainModes:
        """Modes of which these are combinations: more of them in every direction.

        Args:
            more: How many in those that have any; a basis that says itself how many it has is refined.
            missing: How many in those that have none; 0: they stay without.
        """
        basis = self.basis.refined() if isinstance(self.basis, DescribedBasis) else self.basis
        bounded = getattr(basis, "modes", None)
        torsion, bending_2, bending_3 = (
            ((bounded or count + more) if count else (missing and (bounded or missing)))
            for count in self.counts
        )
        return StrainModes((torsion, bending_2, bending_3), basis)

    def hold(self, series: tuple[Floats, Floats, Floats]) -> bool:
        """Whether a strain is one of theirs, whatever the coefficients of its Legendre series are."""
        of_basis = self.basis.polynomials if isinstance(self.basis, DescribedBasis) else lambda _: 0
        pairs = zip(series, self.counts, strict=True)
        return all(len(own) <= of_basis(count) for own, count in pairs)

    def values(self, sigma: Floats) -> Floats:
        """Value of every coordinate's shape function, shape (len(sigma), total)."""
        most = self.basis.values(sigma, max(self.counts))
        return most.take(self._columns, axis=1)

    def strain_at(self, sigma: Floats, coordinates: Floats) -> Floats:
        """Strain Phi q of coordinates, (len(sigma), 3) [1/m]."""
        return np.asarray((self.values(sigma) * coordinates) @ np.eye(3)[self.directions])

    def gram(self, grid: RodGrid, weight: Floats | float = 1.0) -> Floats:
        """``int_0^1 weight Phi^T Phi dsigma``; weight by node and component (K, 3), or a number."""
        values, directions = self.values(grid.nodes), self.directions
        weights = np.broadcast_to(weight, (len(grid.nodes), 3))[:, directions]
        gram = values.T @ (grid.weights[:, None] * weights * values)
        return np.where(directions[:, None] == directions, gram, 0.0)

    def project(self, curvature: Floats, grid: RodGrid) -> Floats:
        """Strain coordinates (..., total) of the strains nearest to those at the nodes, (..., K, 3).

        Nearest in the mean square along the rod; components without modes are left out.
        """
        root = np.sqrt(grid.weights)
        values, directions = root[:, None] * self.values(grid.nodes), self.directions
        coordinates = np.zeros((*curvature.shape[:-2], self.total))
        for component in range(3):
            mine = np.flatnonzero(directions == component)
            if len(mine):
                targets = (root * curvature[..., component]).reshape(-1, len(root))
                found = np.linalg.lstsq(values[:, mine], targets.T, rcond=None)[0]
                coordinates[..., mine] = found.T.reshape(*curvature.shape[:-2], len(mine))
        return coordinates


@dataclass(frozen=True, eq=False)
class Profile:
    """How stiffness and mass vary along a rod: factors, linear between stations.

    Attributes:
        at: Stations in s/l, from 0 to 1, increasing, (P,).
        stiffness: Factors on H_a, (P,).
        mass: Factors on the mass per length, (P,).
    """

    at: Floats
    stiffness: Floats
    mass: Floats

    @cached_property
    def uniform(self) -> bool:
        """Whether nothing varies."""
        return bool(np.all(self.stiffness == 1.0) and np.all(self.mass == 1.0))


UNIFORM = Profile(np.array([0.0, 1.0]), np.ones(2), np.ones(2))


@dataclass(frozen=True, eq=False)
class Rod:
    """Inextensible, unshearable (Kirchhoff) rod.

    Attributes:
        length: Length l [m].
        section: Cross-section, where the rod begins and the profile is one.
        young_modulus: E [Pa].
        shear_modulus: G [Pa].
        density: Mass density rho [kg/m^3].
        profile: Factors on stiffness and mass along the rod.
        rest_curvature: Strain at rest by component, Legendre series in 2 s/l - 1, (any length,) [1/m].
        yield_strain: Bending strain the material bears; infinite where it is not given.
    """

    length: float
    section: Section
    young_modulus: float = 0.0
    shear_modulus: float = 0.0
    density: float = 0.0
    profile: Profile = UNIFORM
    rest_curvature: tuple[Floats, Floats, Floats] = (_NONE, _NONE, _NONE)
    yield_strain: float = math.inf

    @property
    def mass_per_length(self) -> float:
        """Mass per length where the profile is one, rho A [kg/m]."""
        return self.section.mass_per_length(self.density)

    @property
    def rigidities(self) -> Floats:
        """H_a = diag(G J1, E J2, E J3) of Eq. (6) where the profile is one, (3,) [N m^2]."""
        return np.array(self.section.rigidities(self.young_modulus, self.shear_modulus))

    def mean_rigidity(self, planar: bool) -> float:
        """E J of the uniform rod that is as soft: l over the integral of ds / E J [N m^2].

        In the plane E J3, in space the smaller one: the way in which the rod is bent far.
        """
        mean_2, mean_3 = self._mean_rigidities
        return mean_3 if planar else min(mean_2, mean_3)

    @cached_property
    def _mean_rigidities(self) -> tuple[float, float]:
        """That of bending about d2, and about d3."""
        mean = self.rigidities
        if np.any(self.profile.stiffness != 1.0) or self.section.tapered:
            panels = rod_grid(_POINTS_OF_MEAN, tuple(self.profile.at[1:-1].tolist()))
            mean = 1.0 / (panels.weights @ (1.0 / self.rigidities_at(panels.nodes)))
        return float(mean[1]), float(mean[2])

    @cached_property
    def uniform(self) -> bool:
        """Whether stiffness, mass and rest curvature are the same all along."""
        bent = any(np.any(series[1:]) for series in self.rest_curvature)
        return self.profile.uniform and not self.section.tapered and not bent

    @property
    def straight(self) -> bool:
        """Whether it is not curved at rest."""
        return not any(map(len, self.rest_curvature))

    def mass_at(self, sigma: Floats) -> Floats:
        """Mass per length, (len(sigma),) [kg/m]."""
        factor = np.interp(sigma, self.profile.at, self.profile.mass)
        return self.mass_per_length * factor * self.section.scale(sigma) ** 2

    def rigidities_at(self, sigma: Floats) -> Floats:
        """H_a, (len(sigma), 3) [N m^2]."""
        factor = np.interp(sigma, self.profile.at, self.profile.stiffness)
        return (factor * self.section.scale(sigma) ** 4)[:, None] * self.rigidities

    def bending_strain_at(self, sigma: Floats, curvature: Floats) -> Floats:
        """Largest strain across the section, (..., P), where it is curved by (..., P, 3) [1/m]."""
        bending_2, bending_3 = curvature[..., 1], curvature[..., 2]
        return self.section.scale(sigma) * self.section.bending_strain(bending_2, bending_3)

    def rest_curvature_at(self, sigma: Floats) -> Floats:
        """Strain at rest, (len(sigma), 3) [1/m]."""
        if self.straight:
            return np.zeros((len(sigma), 3))
        return np.column_stack(
            [
                legendre.legval(2.0 * sigma - 1.0, np.append(series, 0.0))
                for series in self.rest_curvature
            ]
        )

    def stiffness(self, modes: StrainModes, grid: RodGrid) -> Floats:
        """K_e = int Phi^T H_a Phi ds of Eq. (7), shape (m, m) [N m^3]."""
        return self.length * modes.gram(grid, self.rigidities_at(grid.nodes))

    def rest_strain(self, modes: StrainModes) -> Floats:
        """Strain coordinates q_rest of what modes take up of the curvature at rest, (m,) [1/m]."""
        if self.straight:
            return np.zeros(modes.total)
        points = max(modes.counts) + max(map(len, self.rest_curvature))
        panels = rod_grid(points, distinct_stations(modes.basis.breakpoints))
        return modes.project(self.rest_curvature_at(panels.nodes), panels)

    def rest_beyond_at(self, modes: StrainModes, sigma: Floats) -> Floats:
        """Curvature at rest beyond the modes, kappa_rest - Phi q_rest, (len(sigma), 3) [1/m].

        The rod has it besides the strain of its modes, stressed or not. Zero where they hold the whole.
        """
        if modes.hold(self.rest_curvature):
            return np.zeros((len(sigma), 3))
        return self.rest_curvature_at(sigma) - modes.strain_at(sigma, self.rest_strain(modes))

    def rest_beyond_steps(self, modes: StrainModes, step_points: Floats) -> Floats:
        """Its moments over rotation steps, by moment and component, (H, 3, 3).

        Args:
            modes: Strain modes of the rod.
            step_points: Points of the steps, those of ``MAGNUS_WEIGHTS``, (H, 16).
        """
        beyond = self.rest_beyond_at(modes, step_points.ravel())
        return np.asarray(MAGNUS_WEIGHTS @ beyond.reshape(*step_points.shape, 3))
