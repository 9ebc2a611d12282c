# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The response without eigenvalues: that of the kinemato-static model, and of full solves."""

import numpy as np
import pytest
from helpers.rigid_leg import rigid_leg
from helpers.shipped_steps import STEPS
from numpy.testing import assert_allclose

from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.identification.pushed_equilibrium import pushed_equilibrium
from cpr_core.lie import rotation_log
from cpr_core.model import world_response as module
from cpr_core.model.world_response import world_response, wrench_units

MATRICES = ("twist_by_wrench", "efforts_by_wrench", "twist_by_motors", "efforts_by_motors")


def loaded(name):
    """Away from home, under a wrench with a moment: the tangent is not symmetric there."""
    robot = load_robot(name)
    home = solve_home(robot)
    wrench = np.zeros(6)
    units = wrench_units(home.robot)
    wrench[robot.platform_axes] = 0.1 * units * np.linspace(-1.0, 1.0, len(units))
    loads = robot.default_loads.with_(wrench_world=robot.default_loads.wrench_world + wrench)
    return solve_forward(robot, home.motors + 0.2 * np.array(STEPS[name]), loads=loads)


@pytest.mark.parametrize("name", list(shipped_robots()))
def test_it_is_that_of_the_kinemato_static_model(name):
    equilibrium = loaded(name)
    assert module.border_of(equilibrium.robot.kernel_arrays, equilibrium.factors) is not None
    mine, theirs = world_response(equilibrium), module._dense(equilibrium)
    for matrix in MATRICES:
        expected = getattr(theirs, matrix)
        scale = np.abs(expected).max()
        assert_allclose(getattr(mine, matrix), expected, rtol=0, atol=1e-9 * scale, err_msg=matrix)


@pytest.mark.parametrize("name", ["six_rfs", "rfrfr", "three_rfs", "delta", "rigid_leg"])
def test_it_is_that_of_full_solves(name):
    """Also where the platform cannot move in some direction while the motors are held."""
    equilibrium = solve_home(rigid_leg()) if name == "rigid_leg" else loaded(name)
    robot, response = equilibrium.robot, world_response(equilibrium)
    units, axes = wrench_units(equilibrium.robot), robot.platform_axes
    lengths, step = robot.kernel_arrays.unit[robot.platform_indices], 1e-5

    def beside(wrench, motors):
        world = np.zeros(6)
        world[axes] = wrench * units
        found = pushed_equilibrium(
            equilibrium, equilibrium.motors + motors * robot.motor_units, *known, world
        )
        turn = rotation_log(found.platform_rotation @ equilibrium.platform_rotation.T)
        twist = np.concatenate([turn, found.platform_position - equilibrium.platform_position])
        efforts = found.efforts * robot.motor_units / robot.kernel_arrays.energy_unit
        return np.concatenate([twist[axes] / lengths, efforts])

    known = equilibrium.loads, equilibrium.load_arrays
    count, size = robot.motor_count, len(axes)
    for column in range(size):
        way = step * np.eye(size)[column]
        slope = (beside(way, np.zeros(count)) - beside(-way, np.zeros(count))) / (2.0 * step)
        expected = np.concatenate(
            [response.twist_by_wrench[:, column], response.efforts_by_wrench[:, column]]
        )
        assert_allclose(slope, expected, rtol=0, atol=3e-5 * (1.0 + np.abs(expected).max()))
    for column in range(count):
        way = step * np.eye(count)[column]
        slope = (beside(np.zeros(size), way) - beside(np.zeros(size), -way)) / (2.0 * step)
        expected = np.concatenate(response.by_way(np.eye(count)[column])[::-1])
        assert_allclose(slope, expected, rtol=0, atol=3e-5 * (1.0 + np.abs(expected).max()))
