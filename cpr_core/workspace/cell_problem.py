# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a map is solved for, as plain arrays: it travels to other threads, processes and machines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernel_arrays import LoadArrays, RobotArrays
from ..loads import Loads
from ..robot import Robot
from .grid import Grid, OrientationKind

__all__ = ["ORIENTATIONS", "CellProblem", "cell_problem"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: How the kernels number the ways to impose an orientation.
ORIENTATIONS: dict[OrientationKind, int] = {
    "none": 0, "zyz": 1, "roll_pitch_yaw": 2, "single_angles": 3, "planar": 4,
}  # fmt: skip
_NONE = np.zeros(0, np.int64)


class CellProblem(NamedTuple):
    """A robot, its loads, and the coordinates of the grid it is solved for."""

    robot: RobotArrays
    loads: LoadArrays
    columns: Integers  # state indices of the unknowns beside those of the legs
    rows: Integers  # state indices of the equations beside those of the legs
    inverse_columns: Integers  # unknowns of the inverse problem; none where there is none
    platform_rows: Integers  # equations of forward and inverse problem
    moving: Integers  # state indices of leg coordinates and platform
    multipliers: Integers  # state indices of the multipliers
    lengths: Integers  # state indices of rod lengths
    motions: Floats  # orthonormal unit motions of what moves, columns, (m, m)
    span: Integers  # (m, 2) first and last row of every unit motion that is not zero
    held: Integers  # (6,) x y z and three angles: whether a coordinate is imposed
    given_motors: bool  # whether motors are imposed, else the platform
    orientation: int  # one of ORIENTATIONS
    angles: bool  # whether roll, pitch and yaw are the rotation coordinates of the inverse problem
    solved_by_angles: bool  # whether they are those of this problem
    conservative: bool  # whether the loads have a potential
    tolerance: float  # largest dimensionless residual of a solution
    contraction: float  # largest ratio of two corrections on one branch
    iterations: int  # Newton steps of one step at most


def cell_problem(
    robot: Robot, loads: Loads, grid: Grid, *, tolerance: float, contraction: float, iterations: int
) -> CellProblem:
    """The problem of a grid.

    Args:
        robot: The robot.
        loads: Loads in force everywhere.
        grid: The grid.
        tolerance: Largest dimensionless residual of a solution.
        contraction: Largest ratio of two corrections on one branch.
        iterations: Newton steps of one step at most.
    """
    forward = grid.given == "motors"
    columns, rows = robot.problems["motors" if forward else "platform"]
    has_inverse = len(robot.controlled_axes) > 0
    moving = np.concatenate([robot.elastic_indices, robot.platform_indices])
    motions = np.ascontiguousarray(robot.unit_motions[np.ix_(moving, moving)])
    filled = motions != 0.0
    span = np.stack([filled.argmax(axis=0), len(moving) - filled[::-1].argmax(axis=0)], axis=1)
    held = np.zeros(6, np.int64)
    if not forward:
        held[:3] = np.isin([3, 4, 5], robot.controlled_axes)
        held[3:] = np.isin([0, 1, 2], robot.controlled_axes)
    return CellProblem(
        robot=robot.arrays,
        loads=robot.load_arrays(loads),
        columns=columns,
        rows=rows,
        inverse_columns=robot.problems["platform"][0] if has_inverse else _NONE,
        platform_rows=robot.platform_indices,
        moving=moving,
        multipliers=robot.multiplier_indices,
        lengths=np.ascontiguousarray(robot.length_indices, np.int64),
        motions=motions,
        span=np.ascontiguousarray(span, np.int64),
        held=held,
        given_motors=forward,
        orientation=ORIENTATIONS[grid.orientation],
        angles=robot.controls_angles,
        solved_by_angles=robot.controls_angles and not forward,
        conservative=loads.conservative(robot.planar),
        tolerance=tolerance,
        contraction=contraction,
        iterations=iterations,
    )
