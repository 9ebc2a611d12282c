# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Derivatives by parameters as full solves of robots beside one tell them."""

import numpy as np

from cpr_core import CprError, Robot
from cpr_core.description.changed_description import shifted
from cpr_core.kernels.continuation_kernel import UNPREDICTED
from cpr_core.kernels.kept_factors import kept_factors
from cpr_core.kernels.prepared_robot import continue_prepared
from cpr_core.kernels.problems import PROBLEMS
from cpr_core.kernels.square_problem import Configuration
from cpr_core.lie import rotation_log
from cpr_core.model.equilibrium_records import new_record
from cpr_core.model.equilibrium_steps import equilibrium_at
from cpr_core.solving.continued import continued
from cpr_core.solving.held_problem import held

FACTORS, WEIGHTS = (-2.0, -1.0, 1.0, 2.0), np.array([1.0, -8.0, 8.0, -1.0]) / 12.0


def robots_beside(robot, parameter, step):
    """Robots at four values of a parameter; None where there are none on both sides."""
    try:
        return [Robot(shifted(robot.description, parameter, factor * step)) for factor in FACTORS]
    except CprError:
        return None


def polished(equilibrium, problem):
    """With no residual but rounding: what is left by a solve is divided by a small step here."""
    robot, records = equilibrium.robot, new_record(equilibrium.robot, 1)
    factors = kept_factors(robot.kernel_arrays)
    given = held(equilibrium, problem).given(equilibrium)
    asked = robot.prepared, equilibrium.load_arrays, PROBLEMS[problem], given, UNPREDICTED
    kept = equilibrium.record, factors, records, factors
    continue_prepared(*asked, 0.0, 2, np.inf, *kept)
    loads, arrays = equilibrium.loads, equilibrium.load_arrays
    state = records[0, : robot.state_size]
    rotation, position = records[0, robot.state_size :][:9], records[0, robot.state_size + 9 :][:3]
    return equilibrium_at(robot, loads, arrays, Configuration(state, rotation, position))


def solved_slopes(equilibrium, robots, step, problem):
    """Position, rotation, motors, efforts, margin and smallest eigenvalue by the parameter."""
    found = [polished(continued(equilibrium, robot, problem), problem) for robot in robots]
    turned = equilibrium.platform_rotation.T

    def slope(value):
        return np.tensordot(WEIGHTS, [value(solution) for solution in found], 1) / step

    return {
        "position": slope(lambda solution: solution.platform_position),
        "rotation": slope(lambda solution: rotation_log(solution.platform_rotation @ turned)),
        "motors": slope(lambda solution: solution.motors),
        "efforts": slope(lambda solution: solution.efforts),
        "margin": slope(lambda solution: solution.margin),
        "smallest_eigenvalue": slope(lambda solution: solution.spectrum_locked.smallest),
    }
