# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Both paper paths against continuous-rod solutions found by another method (test/data)."""

import numpy as np
import pytest
from helpers.reference_paths import numbers, read, straight_path

from cpr_core import load_robot, solve_forward, solve_home, solve_inverse


def test_rfrfr_path_with_twelve_modes():
    rows = read("rfrfr_forward_path.csv")
    assert len(rows) == 51
    robot = load_robot("rfrfr", modes=12)
    equilibrium = solve_home(robot)
    for row in rows:
        equilibrium = solve_forward(robot, numbers(row, "q1", "q2"), start=equilibrium)
        np.testing.assert_allclose(
            equilibrium.platform_position[:2], numbers(row, "x", "y"), atol=1e-8
        )
        np.testing.assert_allclose(equilibrium.efforts, numbers(row, "tau1", "tau2"), atol=1e-7)
        np.testing.assert_allclose(
            equilibrium.multipliers[:2], numbers(row, "F1x", "F1y"), atol=1e-7
        )
        assert equilibrium.energy == pytest.approx(row["U"], abs=1e-8)
        assert equilibrium.index_locked == row["nneg_lock"]
        assert equilibrium.index_free == row["nneg_free"]


def test_six_rfs_path_with_twelve_modes():
    rows = read("6rfs_forward_path.csv")
    motors = [f"q{k}" for k in range(1, 7)]
    robot = load_robot("six_rfs", modes=12)
    expected = {int(row["t"]): row for row in rows}
    equilibrium, compared = solve_home(robot), 0
    for t, target in enumerate(straight_path(rows, motors)):
        equilibrium = solve_forward(robot, target, start=equilibrium)
        if t not in expected:
            continue
        row = expected[t]
        np.testing.assert_allclose(target, numbers(row, *motors), atol=1e-12)
        np.testing.assert_allclose(
            equilibrium.platform_position, numbers(row, "px", "py", "pz"), atol=1e-7
        )
        np.testing.assert_allclose(
            equilibrium.platform_quaternion, numbers(row, "qw", "qx", "qy", "qz"), atol=1e-6
        )
        efforts = numbers(row, *(f"tau{k}" for k in range(1, 7)))
        np.testing.assert_allclose(equilibrium.efforts, efforts, atol=1e-7)
        assert equilibrium.energy == pytest.approx(row["U"], abs=1e-7)
        assert (equilibrium.index_locked, equilibrium.index_free) == (
            row["nneg_lock"],
            row["nneg_free"],
        )
        compared += 1
    assert compared == len(rows) == 6


@pytest.mark.parametrize(
    ("modes", "worst", "mean"),
    [(3, 9.33e-3, 1.510e-3), (4, 2.69e-3, 0.679e-3), (5, 0.14e-3, 0.029e-3)],
)
def test_position_error_falls_with_the_modes_as_in_table_i(modes, worst, mean):
    rows = read("rfrfr_forward_path.csv")
    robot = load_robot("rfrfr", modes=modes)
    equilibrium, errors = solve_home(robot), []
    for row in rows:
        equilibrium = solve_forward(robot, numbers(row, "q1", "q2"), start=equilibrium)
        errors.append(np.linalg.norm(equilibrium.platform_position[:2] - numbers(row, "x", "y")))
    assert np.mean(errors) == pytest.approx(mean, rel=0.02)
    assert np.max(errors) == pytest.approx(worst, rel=0.03)


def test_inverse_walks_the_rfrfr_path_back_to_its_motors():
    rows = read("rfrfr_forward_path.csv")
    robot = load_robot("rfrfr", modes=12)
    equilibrium = solve_home(robot)
    for row in rows:
        equilibrium = solve_inverse(robot, numbers(row, "x", "y"), start=equilibrium)
        np.testing.assert_allclose(equilibrium.motors, numbers(row, "q1", "q2"), atol=1e-6)
