# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far apart two equilibria are."""

import numpy as np
import pytest

from cpr_core import load_robot, solve_forward, solve_home
from cpr_ros.steps import change_between


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "delta"])
def test_legs_and_platform_count_in_their_units_motors_and_forces_do_not(name):
    robot = load_robot(name)
    home = solve_home(robot)
    ways = 0.05 * robot.motor_units * (np.arange(robot.motor_count) == 0)
    there = solve_forward(robot, home.motors + ways)
    strains = there.leg_coordinates - home.leg_coordinates
    changes = [
        strains / robot.arrays.unit[robot.elastic_indices],
        (there.platform_position - home.platform_position) / robot.mean_length,
        (there.platform_rotation - home.platform_rotation).ravel(),
    ]
    expected = max(np.abs(change).max(initial=0.0) for change in changes)
    assert expected > 1e-3
    assert change_between(home, there) == change_between(there, home) == expected
    assert change_between(home, home) == 0.0
