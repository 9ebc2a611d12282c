# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Linear solves for legs that are chains, with motors in several slots and legs, against numpy."""

import numpy as np
import pytest
from helpers.chain_robots import ALL_DIFFERENT, robot_of
from helpers.differences import random_state
from helpers.kernel_entry import entry
from helpers.transposed_solves import solve_transposed
from numpy.testing import assert_allclose

from cpr_core import Loads
from cpr_core.kernels import (
    inertia_kernel,
    model_kernel,
    tangent_kernel,
)
from cpr_core.kernels.condensation_kernel import CONDENSED, DELAYED
from cpr_core.kernels.record_layout import INDEX_FREE, INDEX_LOCKED
from cpr_core.kernels.square_problem import SquareProblem
from cpr_core.kernels.workspace_arrays import workspace

evaluate = entry(model_kernel.evaluate)
tangent_into = entry(model_kernel.tangent_into)
factor = entry(tangent_kernel.factor)
solve = entry(tangent_kernel.solve)
signs_of = entry(inertia_kernel.signs_of)

GRAVITY = Loads.none().with_(gravity=[1.0, -9.0, 3.0])
LEGS = {
    "all different": ALL_DIFFERENT,
    "two motors a leg": ("two motors",) * 3,
    "fed and turned": ("fed and turned",) * 2 + ("motor",),
    "one motor twice": ("one motor twice",) * 3,
    "one without a rod": ("no rod", "two rods", "joint between rods"),
}


def evaluated(robot, straight):
    """A workspace with the tangent somewhere, and the tangent by states."""
    state, rotation, position = random_state(robot, np.random.default_rng(4))
    if straight:
        state[robot.numbers.legs[-1].strain] = 0.0
    work, residual = workspace(robot.kernel_arrays), np.empty(robot.state_size)
    tangent = np.zeros((robot.state_size, robot.state_size))
    loads = robot.load_arrays(GRAVITY)
    evaluate(robot.kernel_arrays, loads, state, rotation, position, residual, work)
    tangent_into(robot.kernel_arrays, work, tangent)
    return work, tangent, rotation


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("legs", LEGS)
@pytest.mark.parametrize("problem", ["motors", "efforts"])
def test_solutions_are_those_of_numpy_and_so_are_the_signs(legs, shared, straight, problem):
    robot = robot_of(LEGS[legs], "fixed", shared)
    work, tangent, rotation = evaluated(robot, straight)
    unknowns, equations = robot.problems[problem]
    unit, inner = robot.kernel_arrays.unit, np.arange(robot.kernel_arrays.platform_index)
    whole = tangent * unit[:, None] * unit / robot.kernel_arrays.energy_unit
    matrix = whole[np.ix_(np.append(inner, equations), np.append(inner, unknowns))]
    square = SquareProblem(equations, unknowns, False)
    how = factor(robot.kernel_arrays, rotation, square, work, work.factors)
    assert how in (CONDENSED, DELAYED)
    size = len(matrix)
    for right in np.random.default_rng(3).normal(size=(4, size)):
        for chosen, transposed in ((solve, matrix), (solve_transposed, matrix.T)):
            found, expected = right.copy(), np.linalg.solve(transposed, right)
            chosen(robot.kernel_arrays, square, found, work, work.factors)
            assert_allclose(found, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max())
    signs = np.zeros(3, np.int64)
    signs_of(robot.kernel_arrays, rotation, work, signs)
    symmetric = 0.5 * (whole + whole.T)
    held = robot.kernel_arrays.constraint_count
    for index, last in ((INDEX_LOCKED, robot.kernel_arrays.motor_index), (INDEX_FREE, len(unit))):
        negative = np.sum(np.linalg.eigvalsh(symmetric[:last, :last]) < 0.0)
        assert signs[index] == negative - held


def test_some_of_these_have_slots_left_to_the_border():
    robot = robot_of(LEGS["one without a rod"], "fixed")
    work, _, rotation = evaluated(robot, True)
    unknowns, equations = robot.problems["motors"]
    square = SquareProblem(equations, unknowns, False)
    assert factor(robot.kernel_arrays, rotation, square, work, work.factors) == DELAYED
