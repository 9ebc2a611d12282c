# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a map is solved for, as plain arrays: it travels to other threads, processes and machines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.kernel_arrays import LoadArrays, RobotArrays
from ..kernels.square_problem import ProblemScales, SquareProblem, Tolerances
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..model.problem_units import problem_units
from ..model.robot import Robot
from .grid import Grid
from .orientations import Orientation

__all__ = ["CellProblem", "cell_problem"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_NONE = np.zeros(0, np.int64)


class CellProblem(NamedTuple):
    """A robot, its loads, and the coordinates of the grid it is solved for."""

    robot: RobotArrays
    loads: LoadArrays
    square: SquareProblem  # what the cells are solved for: one of the next two
    forward: SquareProblem
    inverse: SquareProblem  # without unknowns where there is none
    forward_scales: ProblemScales  # all natural
    inverse_scales: ProblemScales
    moving: Integers  # state indices of leg coordinates and platform
    multipliers: Integers  # state indices of the multipliers
    motions: Floats  # orthonormal unit motions of what moves, columns, (m, m)
    span: Integers  # (m, 2) first and last row of every unit motion that is not zero
    held: Integers  # (6,) x y z and three angles: whether a coordinate is imposed
    given_motors: bool  # whether motors are imposed, else the platform
    orientation: int  # an Orientation
    conservative: bool  # whether the loads have a potential
    tolerances: Tolerances


def cell_problem(robot: Robot, loads: Loads, grid: Grid) -> CellProblem:
    """The problem of a grid.

    Args:
        robot: The robot.
        loads: Loads in force everywhere.
        grid: The grid.
    """
    forward = grid.given == "motors"
    # Copies: read-only arrays are another type to numba, for which it would compile all again.
    moving, equations = robot.moving_indices.copy(), robot.platform_indices.copy()
    motions = np.ascontiguousarray(robot.unit_motions[np.ix_(moving, moving)])
    filled = motions != 0.0
    span = np.stack([filled.argmax(axis=0), len(moving) - filled[::-1].argmax(axis=0)], axis=1)
    held = np.zeros(6, np.int64)
    if not forward:
        held[:] = np.isin(np.r_[LINEAR, ANGULAR], robot.controlled_axes)
    unknowns = robot.kernel_arrays.inverse_unknowns if robot.redundancy == 0 else _NONE
    forward_problem = SquareProblem(equations, equations, False)
    inverse_problem = SquareProblem(equations, unknowns, bool(robot.controls_angles))
    units = problem_units(robot, None)
    return CellProblem(
        robot=robot.kernel_arrays,
        loads=robot.load_arrays(loads),
        square=forward_problem if forward else inverse_problem,
        forward=forward_problem,
        inverse=inverse_problem,
        forward_scales=units.scales(equations, equations),
        inverse_scales=units.scales(unknowns, equations),
        moving=moving,
        multipliers=robot.multiplier_indices.copy(),
        motions=motions,
        span=np.ascontiguousarray(span, np.int64),
        held=held,
        given_motors=forward,
        orientation=Orientation.of(grid.orientation).value,
        conservative=robot.has_potential(loads),
        tolerances=Tolerances(),
    )
