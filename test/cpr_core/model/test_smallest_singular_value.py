# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The smallest singular value from the condensed legs is that of the dense matrix."""

import numpy as np
import pytest

from cpr_core import NotReached, kinemato_statics, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.errors import InvalidRequest


def equilibria(robot, count, seed):
    """From home on, step by step in random directions."""
    home = reached = solve_home(robot)
    random = np.random.default_rng(seed)
    for _ in range(count):
        try:
            step = 0.1 * random.normal(size=robot.motor_count) * robot.motor_units
            reached = solve_forward(robot, reached.motors + step, start=reached)
        except NotReached:
            reached = home
        yield reached


@pytest.mark.parametrize("name", shipped_robots())
@pytest.mark.parametrize("modes", [None, 3])
def test_it_is_that_of_the_dense_matrix_in_any_units(name, modes):
    random = np.random.default_rng(5)
    robot = load_robot(name, modes=modes)
    for equilibrium in equilibria(robot, 12, seed=3):
        model = kinemato_statics(equilibrium)
        for problem in model.problems:
            for length in (None, robot.mean_length * 10.0 ** random.uniform(-1.5, 1.5)):
                found = model.smallest_singular_value(problem, length)
                expected = model.singular_values(problem, length)[0]
                assert found == pytest.approx(expected, rel=1e-6), (problem, length)


def test_what_cannot_be_asked():
    model = kinemato_statics(solve_home(load_robot("rfrfr")))
    with pytest.raises(InvalidRequest, match="expected forward, inverse"):
        model.smallest_singular_value("sideways")
    for length in (0.0, -1.0, np.nan, 1e12, "long"):
        with pytest.raises(InvalidRequest, match="characteristic_length"):
            model.smallest_singular_value("forward", length)
