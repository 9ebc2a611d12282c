# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What Newton's method is given: a configuration, a square problem cut out of the model, tolerances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "CONTRACTION",
    "ITERATIONS",
    "RESIDUAL_TOLERANCE",
    "Configuration",
    "ProblemScales",
    "SquareProblem",
    "Tolerances",
]

#: Largest dimensionless residual of an equilibrium.
RESIDUAL_TOLERANCE = 1e-10
#: Newton steps of one path step.
ITERATIONS = 12
#: A correction must be smaller than this times the one before: by Kantorovich's theorem the solution
#: then moves continuously from the last one to this one.
CONTRACTION = 0.25


class Configuration(NamedTuple):
    """Where a robot is, in equilibrium or not.

    Attributes:
        state: State with the motors, (N,); entries of the platform are not read.
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,) [m].
    """

    state: NDArray[np.float64]
    platform_rotation: NDArray[np.float64]
    platform_position: NDArray[np.float64]


class SquareProblem(NamedTuple):
    """What is unknown beside leg coordinates and multipliers, and what holds beside their equations."""

    equations: NDArray[np.int64]  # state indices among platform and motors, (s,)
    unknowns: NDArray[np.int64]  # as many state indices among platform and motors
    angles: bool  # whether the rotation unknowns are roll, pitch and yaw, not world rotations


class ProblemScales(NamedTuple):
    """Units of a linear problem of Section V-C, as parts of the natural ones.

    Unknowns: leg coordinates, multipliers, then what the square problem has beside them, then efforts.
    Equations in the order of a square problem, then those of the motors. Strains have their L2 norm
    along the rod, by its gram matrix L L^T: its diagonal is part of the units where modes are
    orthogonal, the R rods where they are not have their L here.
    """

    unknowns: NDArray[np.float64]  # unit over its own one, zero of multipliers, (legs + s + n,)
    squared_equations: NDArray[np.float64]  # the square of unit over its own one, (legs + s + n,)
    first_strains: NDArray[np.int64]  # state index of the first strain coordinate, (R,)
    strain_counts: NDArray[np.int64]  # how many it has, (R,)
    gram_factors: NDArray[np.float64]  # L, lower triangular, in the upper left, (R, m, m)


class Tolerances(NamedTuple):
    """When Newton's method is done, or gives up."""

    residual: float = RESIDUAL_TOLERANCE  # largest dimensionless residual of a solution
    iterations: int = ITERATIONS  # at most so many steps
    contraction: float = CONTRACTION
    """Below 1: full steps only, given up as soon as a correction is not smaller than this times the one
    before; the solution then lies on the branch of the start. 1: steps are damped instead, for a start
    that may be far away."""
