# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs that are chains, against differences: every element, alone and with others."""

import pytest
from helpers.chain_robots import ALL_DIFFERENT, CHAINS, TIPS, robot_of
from helpers.differences import check_residual, check_tangent

from cpr_core import Loads

LOADS = {
    "none": Loads.none(),
    "gravity": Loads.none().with_(gravity=[1.0, -9.0, 3.0]),
}


def beside(chain):
    """Two legs, of which one has a rod."""
    return [chain, "motor" if chain == "no rod" else chain]


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
