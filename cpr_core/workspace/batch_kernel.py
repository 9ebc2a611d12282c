# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Many cells at once: each is analysed and left for its neighbours, without the GIL."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.kernel_decorators import compiled
from ..kernels.model_kernel import evaluate, tangent_into
from ..kernels.newton_kernel import copy_configuration
from ..kernels.singularity_kernel import smallest_singular_value
from ..kernels.square_problem import Configuration
from ..kernels.tangent_kernel import factor
from .analysis_kernel import spectrum_of
from .cell_layout import (
    FORWARD_MARGIN,
    INVERSE_MARGIN,
    LARGEST_EIGENVALUE,
    NEAREST_EIGENVALUE,
    SIGN_COUNT,
)
from .way_kernel import Way, advance

__all__ = [
    "Analyses",
    "Arrivals",
    "Cells",
    "Ways",
    "analyse_cells",
    "leave_cells",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Cells(NamedTuple):
    """Solved cells, B of them."""

    coordinates: Floats  # (B, C) what is imposed
    state: Floats  # (B, N)
    rotation: Floats  # (B, 3, 3)
    position: Floats  # (B, 3)
    signs: Integers  # (B, 4), see `cell_layout`


class Ways(NamedTuple):
    """Ways that start at cells, in the order of the cells."""

    origin: Integers  # (W,) number of the cell
    targets: Floats  # (W, C) coordinates where it leads
    longest: Floats  # (W,) longest and
    smallest: Floats  # (W,) smallest step, as fractions of the way
    guesses: Floats  # (W, N + 12) configurations expected at the ends; NaN: no guess


class Arrivals(NamedTuple):
    """Where B ways ended."""

    status: Integers  # (B,) ARRIVED, BLOCKED or FLIPPED
    fraction: Floats  # (B,) how far they went
    state: Floats  # (B, N)
    rotation: Floats  # (B, 3, 3)
    position: Floats  # (B, 3)
    signs: Integers  # (B, 4)
    efforts: Floats  # (B, n)
    energy: Floats  # (B,)


class Analyses(NamedTuple):
    """What is known of B cells beyond their solutions."""

    eigenvalues: Floats  # (B, K) smallest of H_r, motors held
    measures: Floats  # (B, 4), see `cell_layout`


@compiled
def analyse_cells(problem, cells, work, analyses):
    """Analyse cells one by one."""
    size = cells.state.shape[1]
    tangent, residual = np.zeros((size, size)), np.empty(size)
    for b in range(cells.state.shape[0]):
        state, rotation, position = cells.state[b], cells.rotation[b], cells.position[b]
        measures = analyses.measures[b]
        evaluate(problem.robot, problem.loads, state, rotation, position, residual, work)
        tangent_into(problem.robot, work, tangent)
        nearest, largest = spectrum_of(problem, tangent, analyses.eigenvalues[b])
        measures[NEAREST_EIGENVALUE], measures[LARGEST_EIGENVALUE] = nearest, largest
        measures[INVERSE_MARGIN] = np.nan
        factor(problem.robot, rotation, problem.forward, work, work.factors)
        for number in range(2 if problem.inverse.unknowns.shape[0] > 0 else 1):
            forward = number == 0
            square = problem.forward if forward else problem.inverse
            scales = problem.forward_scales if forward else problem.inverse_scales
            # Counted on, not chosen by a condition, which takes all of the analysis 7 % longer.
            measures[FORWARD_MARGIN + number] = smallest_singular_value(
                problem.robot, square, scales, rotation, work, work.factors
            )


@compiled
def leave_cells(problem, cells, ways, work, arrivals):
    """Go from cells straight to targets.

    Args:
        problem: CellProblem.
        cells: Cells to start from.
        ways: Ways.
        work: Workspace.
        arrivals: Result, of the W ways.
    """
    size, motor_index = cells.state.shape[1], problem.robot.motor_index
    scratch = np.zeros((size, size))
    for way in range(ways.origin.shape[0]):
        b = ways.origin[way]
        end = Configuration(arrivals.state[way], arrivals.rotation[way], arrivals.position[way])
        copy_configuration(Configuration(cells.state[b], cells.rotation[b], cells.position[b]), end)
        signs = arrivals.signs[way]
        for i in range(SIGN_COUNT):
            signs[i] = cells.signs[b, i]
        status, fraction, energy = advance(
            problem,
            Way(
                cells.coordinates[b],
                ways.targets[way],
                ways.longest[way],
                ways.smallest[way],
                ways.guesses[way],
            ),
            end,
            signs,
            scratch,
            work,
        )
        arrivals.status[way], arrivals.fraction[way] = status, fraction
        arrivals.energy[way] = energy
        for i in range(size - motor_index):
            arrivals.efforts[way, i] = work.residual[motor_index + i]
