# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs that are chains, against differences: every element, alone and with others."""

import numpy as np
import pytest
from helpers.chain_robots import ALL_DIFFERENT, CHAINS, TIPS, robot_of
from helpers.differences import derivative, model_at, random_state

from cpr_core import Loads

LOADS = {
    "none": Loads.none(),
    "gravity": Loads.none().with_(gravity=[1.0, -9.0, 3.0]),
}


def beside(chain):
    """Two legs, of which one has a rod."""
    return [chain, "motor" if chain == "no rod" else chain]


def check_tangent(robot, loads, seed=7):
    value = model_at(robot, robot.load_arrays(loads))
    point = random_state(robot, np.random.default_rng(seed))
    unit = robot.arrays.unit
    exact = value(*point).tangent * unit[:, None] * unit
    for index in range(len(unit)):
        column = derivative(lambda *p: value(*p).residual, robot, point, index)
        np.testing.assert_allclose(
            column * unit * unit[index],
            exact[:, index],
            rtol=0,
            atol=1e-7 * np.abs(exact).max(),
            err_msg=f"column {index}",
        )


def check_residual(robot, loads, seed=11):
    value = model_at(robot, robot.load_arrays(loads))
    point = random_state(robot, np.random.default_rng(seed))
    constraints = robot.multiplier_indices

    def lagrangian(state, rotation, position):
        found = value(state, rotation, position)
        return found.energy + found.residual[constraints] @ state[constraints]

    unit, exact = robot.arrays.unit, value(*point).residual
    scale = np.abs(exact * unit).max()
    for index in range(len(unit)):
        slope = derivative(lagrangian, robot, point, index) * unit[index]
        assert slope == pytest.approx(exact[index] * unit[index], abs=1e-7 * scale), index


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("tip", TIPS)
@pytest.mark.parametrize("chain", CHAINS)
def test_tangent_is_the_derivative_of_the_residual(chain, tip, load):
    check_tangent(robot_of(beside(chain), tip), LOADS[load])


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("chain", CHAINS)
def test_residual_is_the_derivative_of_the_lagrangian(chain, load):
    check_residual(robot_of(beside(chain), "fixed"), LOADS[load])


@pytest.mark.parametrize("shared", [False, True])
def test_legs_of_different_structure_and_motors_they_share(shared):
    robot = robot_of(ALL_DIFFERENT, "fixed", shared)
    check_tangent(robot, LOADS["gravity"])
    check_residual(robot, LOADS["gravity"])
