# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shipped robots away from home, under a force; and numbers that are to be close to others."""

import numpy as np

from cpr_core import Equilibrium, load_robot, solve_forward, solve_home
from helpers.shipped_steps import STEPS


def placed(name: str) -> Equilibrium:
    """A robot at its step from home, pushed."""
    robot = load_robot(name)
    force = [0, 0, 0, 0.02, -0.03, 0.0 if robot.planar else 0.04]
    loads = robot.default_loads.with_(wrench_world=force)
    return solve_forward(robot, solve_home(robot).motors + np.array(STEPS[name]), loads=loads)


def close(found, expected):
    """To a millionth of the largest number expected."""
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * scale)
