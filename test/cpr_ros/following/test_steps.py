# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Steps from one equilibrium to the next: how large one is."""

import numpy as np
import pytest
from helpers.drive import robot
from helpers.turntable import turntable

from cpr_core import solve_forward, solve_home
from cpr_ros.steps import change_between


@pytest.mark.parametrize("angle", [0.01, 0.3, -1.5])
def test_a_platform_that_only_turns_has_moved(angle):
    home = solve_home(turntable())
    turned = solve_forward(home.robot, [angle], start=home)
    expected = np.abs(turned.platform_rotation - home.platform_rotation).max()
    assert expected >= 0.9 * abs(np.sin(angle))
    assert change_between(home, turned) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart"])
def test_nothing_changes_by_more_than_the_change(name):
    home = solve_home(robot(name))
    moved = solve_forward(home.robot, home.motors + 0.01 * home.robot.motor_units, start=home)
    change, length = change_between(home, moved), home.robot.mean_length
    assert change == change_between(moved, home)
    assert change_between(home, home) == 0.0
    assert np.abs(moved.platform_position - home.platform_position).max() <= change * length
    assert np.abs(moved.platform_rotation - home.platform_rotation).max() <= change
