# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The motion of a smallest eigenvalue: its value, and how that changes."""

import numpy as np
import pytest
from helpers.columns import AT_TIP, column
from helpers.shipped_steps import STEPS

from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.description import joints, motors
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.softest_motion import softest_motion


def eigenvalue(found, size):
    spectrum = found.spectrum_locked
    return spectrum.margin if size == "elastic" else spectrum.eigenvalues[0]


@pytest.mark.parametrize("size", ["unit", "elastic"])
@pytest.mark.parametrize("name", shipped_robots())
def test_its_eigenvalue_is_the_smallest_and_what_changes_it_is_told(name, size):
    robot = load_robot(name)
    step = np.abs(STEPS[name]) * np.cos(np.arange(robot.motor_count))
    start = solve_forward(robot, solve_home(robot).motors + 0.1 * step)
    softest = softest_motion(start, size)
    assert softest.eigenvalue == pytest.approx(eigenvalue(start, size), rel=1e-8, abs=1e-9)
    assert softest.change(start) == pytest.approx(0.0, abs=1e-9)
    before, after = (solve_forward(robot, start.motors + k * 1e-4 * step) for k in (-1.0, 1.0))
    seen = eigenvalue(after, size) - eigenvalue(before, size)
    told = softest.change(after) - softest.change(before)
    assert told == pytest.approx(seen, rel=1e-3, abs=2e-9)


def test_where_nothing_moves_there_is_none():
    rigid = solve_home(load_robot("rfrfr", modes=1))
    assert softest_motion(rigid, "unit") is None
    assert softest_motion(rigid, "elastic") is None
    moved = solve_home(column(motors.Welded(), joints.Fixed(AT_TIP)))
    assert softest_motion(moved, "elastic").eigenvalue == pytest.approx(1.0)
