# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How near the forward and the inverse problem are to a singularity, from the condensed legs."""

from __future__ import annotations

import math

from ..kernels.prepared_robot import singular_value_prepared
from ..kernels.problems import PROBLEMS
from ..kernels.square_problem import ProblemScales
from ..validation import checked_number
from .equilibrium import Equilibrium
from .equilibrium_steps import evaluated_again
from .problem_units import problem_units
from .robot import Robot, kept_with_robot

__all__ = ["smallest_singular_value"]

_MOTORS, _POSE = PROBLEMS["motors"], PROBLEMS["pose"]


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
    length = characteristic_length
    if length is not None:
        length = checked_number("characteristic_length", length)
    scales = _scales(robot, inverse, length)
    problem, record, kept = _POSE if inverse else _MOTORS, equilibrium.record, equilibrium.factors
    found = singular_value_prepared(robot.prepared, problem, scales, record, kept, False)
    if math.isnan(found):
        evaluated_again(equilibrium)
        found = singular_value_prepared(robot.prepared, problem, scales, record, kept, True)
    return float(found)


@kept_with_robot
def _scales(robot: Robot, inverse: bool, characteristic_length: float | None) -> ProblemScales:
    unknowns, equations = robot.problems["pose" if inverse else "motors"]
    return problem_units(robot, characteristic_length).scales(unknowns, equations)
