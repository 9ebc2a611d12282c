# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The smallest singular value from the condensed legs is that of the dense matrix, in any basis."""

import numpy as np
import pytest
from helpers.shipped_steps import STEPS
from helpers.strain_bases import with_basis
from helpers.yaml_content import shipped_content

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


def home_and_bent(robot):
    """Models at home and a step from it."""
    home = solve_home(robot)
    bent = solve_forward(robot, home.motors + np.array(STEPS[robot.description.name]), start=home)
    return kinemato_statics(home), kinemato_statics(bent)


@pytest.mark.parametrize("name", shipped_robots())
@pytest.mark.parametrize("basis", ["chebyshev", "monomials"])
def test_it_does_not_depend_on_the_strain_basis(name, basis):
    """Polynomials of one degree are the same shapes."""
    by_basis = (home_and_bent(with_basis(name, each, 5)) for each in (basis, "legendre"))
    for found, expected in zip(*by_basis, strict=True):
        for problem in found.problems:
            values = expected.singular_values(problem)
            np.testing.assert_allclose(found.singular_values(problem), values, rtol=1e-6)
            assert found.smallest_singular_value(problem) == pytest.approx(values[0], rel=1e-6)


@pytest.mark.parametrize("name", shipped_robots())
@pytest.mark.parametrize("basis", ["chebyshev", "monomials"])
def test_it_is_that_of_the_dense_matrix_for_modes_that_are_not_orthogonal(name, basis):
    robot = with_basis(name, basis, 4)
    for model in home_and_bent(robot):
        for problem in model.problems:
            for ratio in (0.03, 0.4, 20.0):
                length = ratio * robot.mean_length
                found = model.smallest_singular_value(problem, length)
                expected = model.singular_values(problem, length)[0]
                assert found == pytest.approx(expected, rel=1e-6), (problem, length)


@pytest.mark.parametrize(
    "controlled", [["z", "pitch", "yaw"], ["x", "roll", "yaw"], ["x", "y", "yaw"]]
)
def test_it_is_that_of_the_dense_matrix_whichever_angles_are_unknown(controlled):
    """Rates of roll and pitch are no turns about the axes of the world."""
    robot = load_robot(shipped_content("three_prs") | {"controlled": controlled})
    step = 0.1 * robot.motor_units * np.array([1.0, -0.5, 0.2])
    model = kinemato_statics(solve_forward(robot, solve_home(robot).motors + step))
    for problem in model.problems:
        expected = model.singular_values(problem)[0]
        assert model.smallest_singular_value(problem) == pytest.approx(expected, rel=1e-6), problem


@pytest.mark.parametrize("name", shipped_robots())
def test_it_converges_with_the_number_of_modes(name):
    by_modes = (home_and_bent(load_robot(name, modes=modes)) for modes in (8, 16))
    for found, expected in zip(*by_modes, strict=True):
        for problem in found.problems:
            value = found.smallest_singular_value(problem)
            assert value == pytest.approx(expected.smallest_singular_value(problem), rel=1e-3)


@pytest.mark.parametrize("modes", [5, 20, 28, 40])
def test_a_soft_leg_has_many_that_are_nearly_the_smallest(modes):
    """One for every mode: the vectors lost their right angles, and the value came out 10 % too small."""
    content = shipped_content("two_rods")
    for element in content["legs"][0]["chain"]:
        if "rod" in element:
            element["rod"] = {"section": {"shape": "circular", "radius": 0.0005}}
    for model in home_and_bent(load_robot(content, modes=modes)):
        for problem in model.problems:
            expected = model.singular_values(problem)[0]
            assert model.smallest_singular_value(problem) == pytest.approx(expected, rel=1e-6)


def test_what_cannot_be_asked():
    model = kinemato_statics(solve_home(load_robot("rfrfr")))
    with pytest.raises(InvalidRequest, match="expected forward, inverse"):
        model.smallest_singular_value("sideways")
    for length in (0.0, -1.0, np.nan, 1e12, "long"):
        with pytest.raises(InvalidRequest, match="characteristic_length"):
            model.smallest_singular_value("forward", length)
    longest = 1e6 * model.equilibrium.robot.mean_length
    with pytest.raises(InvalidRequest, match=rf"1e\+06 m, got {1.00000001 * longest}$"):
        model.smallest_singular_value("forward", 1.00000001 * longest)
