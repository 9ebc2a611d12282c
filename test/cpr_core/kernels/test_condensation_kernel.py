# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Linear solves with the tangent, condensed leg by leg, some slots delayed or none, against numpy."""

from itertools import combinations_with_replacement

import numpy as np
import pytest
from helpers.kernel_entry import entry
from helpers.transposed_solves import solve_transposed, solve_with_efforts_transposed
from numpy.testing import assert_allclose

from cpr_core import solve_home
from cpr_core.kernels import (
    kept_factors,
    linear_problem_kernel,
    model_kernel,
    tangent_kernel,
)
from cpr_core.kernels.condensation_kernel import CONDENSED, DELAYED, NO_INVERSE
from cpr_core.kernels.kept_factors import recalled
from cpr_core.kernels.lanes import load, store
from cpr_core.kernels.lu_kernel import lu_factor, lu_solve
from cpr_core.kernels.square_problem import SquareProblem
from cpr_core.kernels.workspace_arrays import factors_of, workspace
from cpr_core.model.model_state import evaluate
from cpr_core.numba_fence import njit
from cpr_core.solving.load_robot import load_robot

factor = entry(tangent_kernel.factor)
predict = entry(tangent_kernel.predict)
solve = entry(tangent_kernel.solve)
solve_with_efforts = entry(linear_problem_kernel.solve_with_efforts)
keep = entry(kept_factors.keep)
tangent_into = entry(model_kernel.tangent_into)

ROBOTS = ["rfrfr", "six_rfs"]
PROBLEMS = ["motors", "pose", "efforts"]


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return load_robot(request.param)


@pytest.fixture
def tangent(robot):
    return solve_home(robot).tangent


def straight_leg_tangent(robot):
    """Tangent where the first leg is straight: its tip cannot give way along it."""
    home = solve_home(robot)
    state = home.state.copy()
    state[robot.numbers.legs[0].strain] = 0.0
    return evaluate(
        robot, home.load_arrays, state, home.platform_rotation, home.platform_position
    ).tangent


def dimensionless(robot, tangent, problem):
    """The matrix of a problem in the order of the kernel: legs first, then the border."""
    columns, rows = robot.problems[problem]
    legs = np.arange(robot.kernel_arrays.platform_index)
    rows, columns = np.concatenate([legs, rows]), np.concatenate([legs, columns])
    unit = robot.kernel_arrays.unit
    matrix = tangent[np.ix_(rows, columns)]
    return unit[rows, None] * matrix * unit[columns] / robot.kernel_arrays.energy_unit


def by_slots(robot, tangent):
    """A workspace with a tangent whose legs are symmetric: the inverse of ``tangent_into``."""
    arrays = robot.kernel_arrays
    work, inner = workspace(arrays), arrays.slots.inner_count
    platform = arrays.platform_index + np.arange(len(arrays.platform_axes))
    blocks = work.blocks["lane"]
    for group, lane in np.ndindex(len(arrays.groups), arrays.slot_index.shape[2]):
        states = [
            *arrays.slot_index[group, :, lane],
            *platform,
            arrays.motor_slot_index[group, 0, lane],
        ]
        for i, j in combinations_with_replacement(range(len(states)), 2):
            own = i < inner or j == len(states) - 1
            if own and states[i] >= 0 and states[j] >= 0:
                blocks[group, i, j, lane] = tangent[states[i], states[j]]
    axes = arrays.platform_axes
    work.platform_tangent[np.ix_(axes, axes)] = tangent[np.ix_(platform, platform)]
    return work


def square_problem(robot, problem):
    unknowns, equations = robot.problems[problem]
    return SquareProblem(equations, unknowns, False)


def factored(robot, tangent, problem, factors=None):
    work = by_slots(robot, tangent)
    factors = factors or factors_of(robot.kernel_arrays)
    how = factor(robot.kernel_arrays, np.eye(3), square_problem(robot, problem), work, factors)
    return how, work, factors


def solved(robot, problem, factored, right, transposed=False):
    """The solution of a problem, straight or transposed."""
    found = right.copy()
    chosen = solve_transposed if transposed else solve
    chosen(robot.kernel_arrays, square_problem(robot, problem), found, *factored[1:])
    return found


def block_of(robot, leg):
    """State indices of a leg: strain coordinates and multipliers."""
    starts = [leg.strain.start for leg in robot.numbers.legs] + [robot.kernel_arrays.platform_index]
    return np.arange(starts[leg], starts[leg + 1])


def make_singular(robot, tangent, leg):
    """Make the block of a leg singular, so that something is left to the border."""
    multiplier, block = robot.numbers.legs[leg].forces.start, block_of(robot, leg)
    tangent[multiplier, block] = 0.0
    tangent[block, multiplier] = 0.0
    assert np.linalg.matrix_rank(tangent[np.ix_(block, block)]) < len(block)


def check_solutions(robot, tangent, problem, expected_how):
    matrix = dimensionless(robot, tangent, problem)
    assert np.linalg.cond(matrix) < 1e8
    before = tangent.copy()
    made = factored(robot, tangent, problem)
    assert made[0] == expected_how
    assert np.array_equal(tangent, before)
    size = len(matrix)
    for right in (*np.eye(size)[[0, -1]], *np.random.default_rng(3).normal(size=(5, size))):
        for transposed in (False, True):
            expected = np.linalg.solve(matrix.T if transposed else matrix, right)
            found = solved(robot, problem, made, right, transposed)
            assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("problem", PROBLEMS)
def test_condensed_solution_is_that_of_numpy(robot, tangent, problem):
    check_solutions(robot, tangent, problem, CONDENSED)


@pytest.mark.parametrize("expected_how", [CONDENSED, DELAYED])
@pytest.mark.parametrize("problem", ["motors", "pose"])
def test_efforts_are_unknowns_too(robot, tangent, problem, expected_how):
    """The matrix of a linear problem of Section V-C: motor rows of the tangent, less the efforts."""
    if expected_how == DELAYED:
        make_singular(robot, tangent, 0)
    newton, motors = dimensionless(robot, tangent, problem), robot.motor_indices
    columns = np.append(np.arange(robot.kernel_arrays.platform_index), robot.problems[problem][0])
    unit, size = robot.kernel_arrays.unit, len(newton)
    rows = unit[motors, None] * tangent[np.ix_(motors, columns)] * unit[columns]
    matrix = np.block(
        [
            [newton, np.zeros((size, len(motors)))],
            [rows / robot.kernel_arrays.energy_unit, -np.eye(len(motors))],
        ]
    )
    how, *made = factored(robot, tangent, problem)
    assert how == expected_how
    for right in np.random.default_rng(3).normal(size=(5, len(matrix))):
        for chosen, whole in (
            (solve_with_efforts, matrix),
            (solve_with_efforts_transposed, matrix.T),
        ):
            found, expected = right.copy(), np.linalg.solve(whole, right)
            chosen(robot.kernel_arrays, square_problem(robot, problem), found, *made)
            assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("problem", PROBLEMS)
def test_tangents_that_are_not_symmetric_are_solved_too(robot, tangent, problem):
    """Loads that follow the platform make its own block unsymmetric, and states out of balance."""
    rng, changed = np.random.default_rng(5), tangent.copy()
    platform = robot.platform_indices
    unit = robot.kernel_arrays.unit[platform]
    away = (
        rng.normal(size=(len(platform),) * 2)
        * robot.kernel_arrays.energy_unit
        / unit
        / unit[:, None]
    )
    changed[np.ix_(platform, platform)] += away
    assert not np.allclose(changed, changed.T)
    check_solutions(robot, changed, problem, CONDENSED)


def test_a_tangent_put_together_from_slots_is_the_same(robot, tangent):
    found = np.zeros_like(tangent)
    tangent_into(robot.kernel_arrays, by_slots(robot, tangent), found)
    assert_allclose(found, tangent, rtol=0.0, atol=1e-12 * np.abs(tangent).max())


@pytest.mark.parametrize("problem", PROBLEMS)
def test_predictions_are_those_of_numpy(robot, tangent, problem):
    columns, rows = robot.problems[problem]
    arrays, rng = robot.kernel_arrays, np.random.default_rng(2)
    border = np.arange(arrays.platform_index, len(arrays.unit))
    known = np.where(np.isin(border, columns), 0.0, rng.normal(size=len(border)))
    efforts = rng.normal(size=robot.motor_count) if problem == "efforts" else None
    matrix = dimensionless(robot, tangent, problem)
    whole = tangent * arrays.unit[:, None] * arrays.unit / arrays.energy_unit
    equations = np.concatenate([np.arange(arrays.platform_index), rows])
    right = -whole[np.ix_(equations, border)] @ known
    if efforts is not None:
        right[-robot.motor_count :] += efforts
    expected = np.linalg.solve(matrix, right)
    _, work, factors = factored(robot, tangent, problem)
    kept, other = kept_factors.kept_factors(arrays), factors_of(arrays)
    store_and_recall(arrays, factors, kept, other)
    for used in (factors, other):
        if used is factors:
            used.inverse["lane"][:] = 0.0
        found = np.empty(len(arrays.unit))
        efforts = np.zeros(robot.motor_count) if efforts is None else efforts
        square = square_problem(robot, problem)
        assert predict(arrays, np.eye(3), square, known, efforts, found, work, used)
        size = len(expected)
        assert_allclose(found[:size], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


@njit(_nrt=False)
def copy_recalled(robot, kept, other):
    """Factors as they are recalled, into others of their own."""
    upper = recalled(robot, kept, other).upper
    for number in range(upper.shape[0]):
        for i in range(upper.shape[1]):
            for j in range(upper.shape[2]):
                store(other.upper, (number, i, j), load(upper, (number, i, j)))


copy = entry(copy_recalled)


def store_and_recall(arrays, factors, kept, other):
    keep(arrays, factors, kept)
    copy(arrays, kept, other)
    np.testing.assert_array_equal(factors.border, other.border)
    np.testing.assert_array_equal(factors.inverse["lane"], other.inverse["lane"])
    above = np.triu_indices(factors.upper.shape[1], 1, factors.upper.shape[2])  # L^T is unit
    for stored, found in zip(factors.upper["lane"], other.upper["lane"], strict=True):
        np.testing.assert_array_equal(stored[above], found[above])


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("leg", [0, 1])
def test_of_a_singular_leg_block_something_is_left_to_the_border(robot, tangent, problem, leg):
    changed = tangent.copy()
    make_singular(robot, changed, leg)
    check_solutions(robot, changed, problem, DELAYED)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_slots_that_different_legs_leave_are_apart(robot, tangent, problem):
    """The first one is left with couplings to all slots after it, as is another one of another leg."""
    changed, (first, other) = tangent.copy(), (block_of(robot, leg) for leg in (0, 1))
    changed[first[0], first[0]] = 0.0
    before, slot = other[:2], other[2]
    beside = changed[before, slot]
    changed[slot, slot] = beside @ np.linalg.solve(changed[np.ix_(before, before)], beside)
    check_solutions(robot, changed, problem, DELAYED)


@pytest.mark.parametrize("problem", ["motors", "efforts"])
def test_of_a_straight_leg_something_is_left_to_the_border(robot, problem):
    changed = straight_leg_tangent(robot)
    block = block_of(robot, 0)
    assert np.linalg.cond(dimensionless(robot, changed, problem)[np.ix_(block, block)]) > 1e12
    check_solutions(robot, changed, problem, DELAYED)


def test_a_straight_leg_leaves_the_inverse_problem_without_inverse(robot):
    # Neither its motor nor its strain moves the tip along it: no pose can be asked for there.
    changed = straight_leg_tangent(robot)
    matrix = dimensionless(robot, changed, "pose")
    assert np.linalg.matrix_rank(matrix) < len(matrix)
    assert factored(robot, changed, "pose")[0] == NO_INVERSE


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_singular_border_has_no_inverse(robot, tangent, problem):
    changed = tangent.copy()
    changed[robot.platform_indices[0], :] = 0.0
    changed[:, robot.platform_indices[0]] = 0.0
    assert factored(robot, changed, problem)[0] == NO_INVERSE


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_singular_whole_has_no_inverse(robot, tangent, problem):
    changed = tangent.copy()
    strain = robot.numbers.legs[1].strain.start + 1
    changed[strain, :] = 0.0
    changed[:, strain] = 0.0
    assert factored(robot, changed, problem)[0] == NO_INVERSE


@pytest.mark.parametrize("problem", PROBLEMS)
def test_nan_has_no_inverse(robot, tangent, problem):
    assert factored(robot, np.full_like(tangent, np.nan), problem)[0] == NO_INVERSE


def test_factors_are_refilled_and_not_added_to(robot, tangent):
    factors = factors_of(robot.kernel_arrays)
    size = len(dimensionless(robot, tangent, "motors"))
    right = np.random.default_rng(7).normal(size=size)
    solutions = []
    for matrix in (tangent, straight_leg_tangent(robot), tangent):
        made = factored(robot, matrix, "motors", factors)
        solutions.append(solved(robot, "motors", made, right))
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
