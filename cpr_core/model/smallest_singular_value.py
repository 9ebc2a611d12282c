# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How near the forward and the inverse problem are to a singularity, from the condensed legs."""

from __future__ import annotations

import numpy as np

from ..kernels.prepared_robot import singular_value_prepared
from ..kernels.square_problem import ProblemScales, SquareProblem
from .equilibrium import Equilibrium
from .problem_units import problem_units
from .robot import Robot

__all__ = ["smallest_singular_value"]


def smallest_singular_value(
    equilibrium: Equilibrium, inverse: bool, characteristic_length: float | None
) -> float:
    """Smallest singular value of a linear problem of Section V-C, dimensionless.

    Args:
        equilibrium: Where.
        inverse: Of the inverse problem, else of the forward one.
        characteristic_length: Weighs rotations against translations [m]; None: mean rod length.

    Returns:
        The value, to a millionth of it; 0 where this method does not find it.

    Raises:
        InvalidRequest: No such length.
    """
    robot = equilibrium.robot
    if inverse and robot.redundancy:
        return 0.0
    name = f"{'inverse' if inverse else 'forward'} problem in units of {characteristic_length} m"
    problem, scales = robot.kept(name, lambda: _problem(robot, inverse, characteristic_length))
    tangent = np.zeros((robot.state_size, robot.state_size))
    # Copies: read-only arrays are another type to numba, for which it would compile all again.
    return float(
        singular_value_prepared(
            robot.prepared,
            equilibrium.load_arrays,
            problem,
            scales,
            equilibrium.state.copy(),
            equilibrium.platform_rotation.copy(),
            equilibrium.platform_position.copy(),
            np.empty(robot.state_size),
            tangent,
        )
    )


def _problem(
    robot: Robot, inverse: bool, characteristic_length: float | None
) -> tuple[SquareProblem, ProblemScales]:
    unknowns, equations = robot.problems["pose" if inverse else "motors"]
    scales = problem_units(robot, characteristic_length).scales(unknowns, equations)
    return SquareProblem(equations, unknowns, bool(inverse and robot.controls_angles)), scales
