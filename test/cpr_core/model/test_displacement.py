# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Finite changes of state coordinates."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from cpr_core import load_robot, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.lie import rotation_log
from cpr_core.model.displacement import displaced


@pytest.mark.parametrize("name", shipped_robots())
def test_the_platform_moves_by_its_twist_in_the_world_and_the_rest_by_what_is_added(name):
    home = solve_home(load_robot(name))
    robot, rng = home.robot, np.random.default_rng(3)
    change = 0.3 * rng.normal(size=robot.state_size) * robot.kernel_arrays.unit
    given = change.copy()
    place = home.state, home.platform_rotation, home.platform_position
    state, rotation, position = displaced(robot, *place, change)
    twist = np.concatenate([rotation_log(rotation @ place[1].T), position - place[2]])
    assert_allclose(twist[robot.platform_axes], change[robot.platform_indices], atol=1e-14)
    assert_allclose(np.delete(twist, robot.platform_axes), 0.0, atol=1e-15)
    others = np.delete(np.arange(robot.state_size), robot.platform_indices)
    assert_allclose((state - home.state)[others], change[others], rtol=1e-9, atol=1e-13)
    assert_array_equal(state[robot.platform_indices], home.state[robot.platform_indices])
    assert_array_equal(change, given)
