# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far configurations are apart: what counts, and in which units."""

import numpy as np
import pytest

from cpr_core import load_robot, solve_home
from cpr_core.model.configurations import configuration_distance, configuration_rows, leg_units


@pytest.fixture(scope="module", params=["rfrfr", "gough_stewart"])
def home(request):
    return solve_home(load_robot(request.param, modes=3))


def test_every_number_counts_in_its_unit(home):
    robot, size = home.robot, home.robot.state_size
    for place in range(size + 12):
        moved, unit = home.configuration.copy(), 1.0
        if place < size:
            unit = robot.kernel_arrays.unit[place]
        elif place >= size + 9:
            unit = robot.mean_length
        moved[place] -= 0.25 * unit
        assert configuration_distance(robot, home.configuration, moved) == pytest.approx(0.25)


def test_rows_are_compared_one_by_one(home):
    rows = configuration_rows(
        np.stack([home.state] * 3),
        np.stack([home.platform_rotation] * 3),
        np.stack([home.platform_position] * 3),
    )
    np.testing.assert_array_equal(rows, [home.configuration] * 3)
    rows[1, -1] += 0.5 * home.robot.mean_length
    found = configuration_distance(home.robot, rows, home.configuration)
    np.testing.assert_allclose(found, [0.0, 0.5, 0.0])
    assert configuration_distance(home.robot, rows[:0], rows[:0]).shape == (0,)


def test_of_legs_neither_multipliers_nor_motors_count(home):
    robot, counts = home.robot, np.isfinite(leg_units(home.robot))
    assert not counts[[*robot.multiplier_indices, *robot.motor_indices]].any()
    assert counts[robot.elastic_indices].all() and counts[robot.state_size :].all()
    assert counts.sum() == len(robot.elastic_indices) + 12


@pytest.mark.parametrize(("name", "counts"), [("delta", False), ("three_prs", True)])
def test_whole_turns_of_passive_joints_count_where_a_spring_is_wound(name, counts):
    """Maps and the way home of the page took the same place for another equilibrium."""
    home = solve_home(load_robot(name, modes=3))
    robot, moved = home.robot, home.configuration.copy()
    joint, index = robot.passive_joints[0]
    assert (joint.stiffness > 0.0) == counts
    moved[index] -= 4.0 * np.pi
    turned = 4.0 * np.pi / robot.kernel_arrays.unit[index] if counts else 0.0
    rows = np.stack([home.configuration, moved])
    found = configuration_distance(robot, rows, home.configuration)
    np.testing.assert_allclose(found, [0.0, turned], rtol=1e-12, atol=1e-12)
    moved[index] += 1.0
    short = turned - 1.0 if counts else 1.0
    assert configuration_distance(robot, home.configuration, moved) == pytest.approx(short)
