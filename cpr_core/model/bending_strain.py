# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far the rods are from yielding: bending strains at the surface, and what the material bears."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .equilibrium import Equilibrium, check_equilibrium
from .robot import Robot

__all__ = ["bending_strains", "strain_reserves", "strains_in"]

Floats = NDArray[np.float64]


def bending_strains(equilibrium: Equilibrium) -> Floats:
    """Largest bending strain of every rod at nodes and ends, (R,), dimensionless.

    The strain of the outermost fibre, curvature (less the one at rest) times its distance from the
    centre line, at the quadrature nodes and at both ends. In between it may be larger, of shipped robots
    by some 2 %. Torsion and tension are not counted. Where a profile changes the stiffness, the section
    is still the one of the description. NaN where it is ``given`` without an ``outer_radius``.

    Raises:
        InvalidRequest: No equilibrium.
    """
    check_equilibrium(equilibrium)
    return strains_in(equilibrium.robot, equilibrium.state)


def strains_in(robot: Robot, states: Floats) -> Floats:
    """The same in some states (..., N), (..., R); NaN where a state is."""
    largest = []
    for rod, values, rest in zip(robot.numbers.rods, *robot.curvature_stations, strict=True):
        curvature = np.einsum("pcm,...m->...pc", values, states[..., rod.strain])
        curvature /= rod.stretch(states)[..., None, None]
        strain = rod.element.rod.bending_strain_at(robot.curvature_sigma, curvature - rest)
        largest.append(strain.max(axis=-1))
    return np.stack(largest, axis=-1)


def strain_reserves(robot: Robot, strains: Floats) -> Floats:
    """What is left of the limits of the rods that have one, (..., K): 1 where a rod is not bent.

    Args:
        robot: The robot.
        strains: Largest bending strain of every rod, (..., R).
    """
    limited = np.isfinite(robot.yield_strains)
    found: Floats = 1.0 - strains[..., limited] / robot.yield_strains[limited]
    return found
