"""Linear solves with the tangent, condensed leg by leg or whole, against numpy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cpr_core.condensation_kernel import (
    CONDENSED,
    DENSE,
    NO_INVERSE,
    allocate,
    factor,
    lu_factor,
    lu_solve,
    solve,
)
from cpr_core.model import evaluate, tangent_at
from cpr_core.robot import load_robot

ROBOTS = ["rfrfr", "six_rfs"]
PROBLEMS = ["motors", "platform", "efforts"]


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return load_robot(request.param)


@pytest.fixture
def tangent(robot):
    return tangent_at(robot.home)


def straight_leg_tangent(robot):
    """Tangent where the first leg is straight: its tip cannot give way along it."""
    home, here = robot.home, robot.arrays.legs[0]
    state = home.state.copy()
    state[here["strain_index"] :][: here["strain_count"]] = 0.0
    return evaluate(
        robot, home.load_arrays, state, home.platform_rotation, home.platform_position
    ).tangent


def dimensionless(robot, tangent, problem):
    """The matrix of a problem in the order of the kernel: legs first, then the border."""
    columns, rows = robot.problems[problem]
    legs = np.arange(robot.arrays.platform_index)
    rows, columns = np.concatenate([legs, rows]), np.concatenate([legs, columns])
    unit = robot.arrays.unit
    matrix = tangent[np.ix_(rows, columns)]
    return unit[rows, None] * matrix * unit[columns] / robot.arrays.energy_unit


def factored(robot, tangent, problem):
    columns, rows = robot.problems[problem]
    factors = allocate(robot.arrays, len(rows))
    return factor(robot.arrays, tangent, rows, columns, factors), factors


def block_of(robot, leg):
    """State indices of a leg: strain coordinates and multipliers."""
    starts = [*robot.arrays.legs["strain_index"], robot.arrays.platform_index]
    return np.arange(starts[leg], starts[leg + 1])


def check_solutions(robot, tangent, problem, expected_how):
    matrix = dimensionless(robot, tangent, problem)
    assert np.linalg.cond(matrix) < 1e8
    before = tangent.copy()
    how, factors = factored(robot, tangent, problem)
    assert how == expected_how
    assert np.array_equal(tangent, before)
    size = len(matrix)
    for right in (*np.eye(size)[[0, -1]], *np.random.default_rng(3).normal(size=(5, size))):
        found = right.copy()
        solve(factors, how, found)
        expected = np.linalg.solve(matrix, right)
        assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("problem", PROBLEMS)
def test_condensed_solution_is_that_of_numpy(robot, tangent, problem):
    check_solutions(robot, tangent, problem, CONDENSED)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_tangents_that_are_not_symmetric_are_solved_too(robot, tangent, problem):
    rng = np.random.default_rng(5)
    outer = np.zeros_like(tangent)
    border = np.arange(robot.arrays.platform_index, len(tangent))
    for leg in range(len(robot.arrays.legs)):
        block = block_of(robot, leg)
        outer[np.ix_(block, block)] = 1.0
        outer[np.ix_(block, border)] = outer[np.ix_(border, block)] = 1.0
    outer[np.ix_(border, border)] = 1.0
    changed = tangent * (1.0 + 0.05 * outer * rng.normal(size=tangent.shape))
    assert not np.allclose(changed, changed.T)
    check_solutions(robot, changed, problem, CONDENSED)


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("leg", [0, 1])
def test_a_singular_leg_block_is_solved_with_the_whole_matrix(robot, tangent, problem, leg):
    changed = tangent.copy()
    multiplier = robot.arrays.legs[leg]["multiplier_index"]
    block = block_of(robot, leg)
    changed[multiplier, block] = 0.0
    changed[block, multiplier] = 0.0
    assert np.linalg.matrix_rank(changed[np.ix_(block, block)]) < len(block)
    check_solutions(robot, changed, problem, DENSE)


@pytest.mark.parametrize("problem", ["motors", "efforts"])
def test_a_straight_leg_is_solved_with_the_whole_matrix(robot, problem):
    changed = straight_leg_tangent(robot)
    block = block_of(robot, 0)
    assert np.linalg.cond(dimensionless(robot, changed, problem)[np.ix_(block, block)]) > 1e12
    check_solutions(robot, changed, problem, DENSE)


def test_a_straight_leg_leaves_the_inverse_problem_without_inverse(robot):
    # Neither its motor nor its strain moves the tip along it: no pose can be asked for there.
    changed = straight_leg_tangent(robot)
    matrix = dimensionless(robot, changed, "platform")
    assert np.linalg.matrix_rank(matrix) < len(matrix)
    how, _ = factored(robot, changed, "platform")
    assert how == NO_INVERSE


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("what", ["row", "column"])
def test_a_singular_border_has_no_inverse(robot, tangent, problem, what):
    columns, rows = robot.problems[problem]
    changed = tangent.copy()
    if what == "row":
        changed[rows[0], :] = 0.0
    else:
        changed[:, columns[-1]] = 0.0
    how, _ = factored(robot, changed, problem)
    assert how == NO_INVERSE


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("what", ["row", "column"])
def test_a_singular_whole_has_no_inverse(robot, tangent, problem, what):
    changed = tangent.copy()
    strain = robot.arrays.legs[1]["strain_index"] + 1
    if what == "row":
        changed[strain, :] = 0.0
    else:
        changed[:, strain] = 0.0
    how, _ = factored(robot, changed, problem)
    assert how == NO_INVERSE


@pytest.mark.parametrize("problem", PROBLEMS)
def test_nan_has_no_inverse(robot, tangent, problem):
    how, _ = factored(robot, np.full_like(tangent, np.nan), problem)
    assert how == NO_INVERSE


def test_factors_are_refilled_and_not_added_to(robot, tangent):
    columns, rows = robot.problems["motors"]
    factors = allocate(robot.arrays, len(rows))
    right = np.random.default_rng(7).normal(size=robot.arrays.platform_index + len(rows))
    solutions = []
    for matrix in (tangent, straight_leg_tangent(robot), tangent):
        found = right.copy()
        solve(factors, factor(robot.arrays, matrix, rows, columns, factors), found)
        solutions.append(found)
    assert np.array_equal(solutions[0], solutions[2])
    assert not np.allclose(solutions[0], solutions[1])


@pytest.mark.parametrize("size", [1, 2, 3, 7, 20])
def test_lu_with_row_exchanges_solves_like_numpy(size):
    rng = np.random.default_rng(size)
    for _ in range(20):
        matrix, right = rng.normal(size=(size, size)), rng.normal(size=size)
        if size > 1:
            matrix[0, 0] = 0.0  # the first pivot has to be exchanged
        factors, pivots, found = matrix.copy(), np.full(size, -1), right.copy()
        assert lu_factor(factors, size, pivots, 1e-14)
        lu_solve(factors, size, pivots, found)
        bound = 1e-14 * size * np.linalg.cond(matrix)
        expected = np.linalg.solve(matrix, right)
        assert_allclose(found, expected, rtol=0.0, atol=bound * np.abs(expected).max())


def test_lu_uses_the_leading_square_only():
    matrix = np.full((4, 4), np.nan)
    matrix[:2, :2] = [[0.0, 2.0], [4.0, 1.0]]
    pivots, found = np.zeros(4, np.int64), np.array([2.0, 6.0, 7.0, 8.0])
    assert lu_factor(matrix, 2, pivots, 1e-14)
    lu_solve(matrix, 2, pivots, found)
    assert_allclose(found, [1.25, 1.0, 7.0, 8.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("matrix", "smallest", "regular"),
    [
        (np.zeros((3, 3)), 0.0, False),
        (np.ones((3, 3)), 0.0, False),
        (np.diag([1.0, 1e-3, 1.0]), 1e-2, False),
        (np.diag([1.0, 1e-3, 1.0]), 1e-4, True),
        (np.diag([1.0, np.nan, 1.0]), 0.0, False),
    ],
)
def test_lu_refuses_pivots_that_are_too_small(matrix, smallest, regular):
    assert lu_factor(matrix.copy(), 3, np.zeros(3, np.int64), smallest) == regular
