# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Matrices of the strain modes of all rods, in the order of the state, and curvatures along them."""

from __future__ import annotations

from collections.abc import Callable, Hashable

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainRod
from ..rods.quadrature import RodGrid
from ..validation import read_only
from .state_numbers import StateNumbers

__all__ = ["curvature_stations", "strain_grams", "strain_stiffness", "unit_motions"]

Floats = NDArray[np.float64]


def strain_grams(numbers: StateNumbers, grid: RodGrid) -> Floats:
    """Integrals of products of the strain modes of every rod, (N, N)."""
    return _by_rod(
        numbers,
        lambda element: element.modes.identity,
        lambda element: element.modes.gram(grid),
    )


def strain_stiffness(numbers: StateNumbers, grid: RodGrid) -> Floats:
    """Elastic stiffness K_e of every rod at its nominal length, (N, N)."""
    return _by_rod(
        numbers,
        lambda element: (id(element.rod), element.modes.identity),
        lambda element: element.rod.stiffness(element.modes, grid),
    )


def unit_motions(numbers: StateNumbers, grams: Floats) -> Floats:
    """Dimensionless unit motions as columns, (N, N), see ``Robot.unit_motions``."""
    motions = np.diag(numbers.unit)
    for rod in numbers.rods:
        gram = grams[rod.strain, rod.strain]
        orthonormal = np.linalg.inv(np.linalg.cholesky(gram)).T
        motions[rod.strain, rod.strain] = motions[rod.strain, rod.strain] @ orthonormal
    return motions


def curvature_stations(
    numbers: StateNumbers, sigma: Floats
) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
    """Per rod, at s/l (P,): curvature by strain coordinate (P, 3, m), and at rest (P, 3) [1/m].

    At rest as far as the modes take it up: their difference is the elastic strain.
    """
    elements = [rod.element for rod in numbers.rods]
    components = np.arange(3)[:, None]
    return tuple(
        read_only(
            element.modes.values(sigma)[:, None, :] * (components == element.modes.directions)
        )
        for element in elements
    ), tuple(
        read_only(
            element.rod.rest_curvature_at(sigma) - element.rod.rest_beyond_at(element.modes, sigma)
        )
        for element in elements
    )


def _by_rod(
    numbers: StateNumbers,
    identity: Callable[[ChainRod], Hashable],
    matrix: Callable[[ChainRod], Floats],
) -> Floats:
    """Matrices of the rods on the diagonal, found once for all of an identity."""
    whole = np.zeros((len(numbers.unit), len(numbers.unit)))
    found: dict[Hashable, Floats] = {}
    for rod in numbers.rods:
        key = identity(rod.element)
        if key not in found:
            found[key] = matrix(rod.element)
        whole[rod.strain, rod.strain] = found[key]
    return whole
