# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is measured is what it says: equilibria, of the right robots, by every way the same."""

import numpy as np
import pytest
from helpers.shipped_steps import SHORT_FORM

from benchmarks.batches import _batch, solve_batch
from benchmarks.linear_algebra import matrix_sizes
from benchmarks.scaling import AXES, _robot
from benchmarks.walks import PROBLEMS, ROBOTS, walk_of
from cpr_core import solve_home


def test_every_robot_of_the_short_form_is_measured_and_one_of_chains():
    assert set(ROBOTS) == {*SHORT_FORM, "six_rus"}


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("name", ROBOTS)
def test_walks_are_small_steps_between_equilibria(name, problem):
    walk = walk_of(name, 5, problem)
    points = walk.equilibria()
    assert len(points) >= 10
    assert max(point.residual for point in points) < 1e-10
    assert walk.run().residual == points[-1].residual
    steps = np.diff([walk.start.platform_position, *[p.platform_position for p in points]], axis=0)
    assert 1e-5 < np.linalg.norm(steps, axis=1).max() < 0.2


def test_the_robot_with_extensible_legs_steps_1_4_mm():
    walk = walk_of("gough_stewart", 5, "inverse")
    points = [walk.start, *walk.equilibria()]
    steps = np.diff([point.platform_position for point in points], axis=0)
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), 1.4e-3, rtol=1e-6)


def test_a_batch_finds_what_single_solves_find():
    problem, cells, ways = _batch(60, 5)
    arrivals = solve_batch(problem, cells, ways, None)
    points = walk_of("six_rfs", 5, "forward").equilibria()
    for number in range(60):
        expected = points[number % len(points)]
        np.testing.assert_allclose(arrivals.position[number], expected.platform_position, atol=1e-9)


def test_the_matrix_of_the_6_rfs_robot_has_84_rows():
    assert matrix_sizes((5,))["six_rfs/5"] == 84


@pytest.mark.parametrize("axis", AXES)
def test_one_number_of_the_robot_is_varied(axis):
    for number in AXES[axis][:4]:
        robot = _robot(axis, number)
        legs = robot.description.legs
        found = {
            "legs": len(legs),
            "nodes": len(robot.grid.nodes),
            "modes": legs[0].modes.counts[1],
        }
        assert found[axis] == number
        usual = {"legs": 6, "nodes": 16, "modes": 5}
        # More modes have more nodes of their own accord.
        for other in set(usual) - {axis, "nodes" if axis == "modes" else axis}:
            assert found[other] == usual[other]
        assert solve_home(robot).converged
