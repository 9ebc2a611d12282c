# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Indices and signs without eigenvalues against eigenvalues and determinants."""

import numpy as np
import pytest
from helpers.bordered_index import index_by_eigenvalues
from helpers.shipped_steps import SHORT_FORM
from helpers.yaml_content import shipped_content
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.robustness import RANGES
from cpr_core import (
    Loads,
    NotReached,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.kernels.inertia_kernel import eliminate


def symmetric(eigenvalues, random):
    turned = np.linalg.qr(random.normal(size=(len(eigenvalues),) * 2))[0]
    matrix = turned @ np.diag(eigenvalues) @ turned.T
    return 0.5 * (matrix + matrix.T)


@settings(deadline=None, max_examples=200)
@given(
    st.lists(
        st.floats(0.01, 10.0).flatmap(lambda v: st.sampled_from([v, -v])), min_size=1, max_size=12
    ),
    st.integers(0, 2**31),
)
def test_elimination_counts_negative_eigenvalues(eigenvalues, seed):
    matrix = symmetric(eigenvalues, np.random.default_rng(seed))
    negative, zero = eliminate(matrix.copy(), 0, len(matrix), len(matrix), 1e-9)
    assert (negative, zero) == (sum(value < 0.0 for value in eigenvalues), 0)


@pytest.mark.parametrize("size", [1, 2, 4])
def test_elimination_counts_where_there_is_nothing_on_the_diagonal(size):
    """Every pivot is of two rows: one of either sign."""
    beside, none = np.random.default_rng(size).normal(size=(size, size)), np.zeros((size, size))
    matrix = np.block([[none, beside], [beside.T, none]])
    assert eliminate(matrix, 0, 2 * size, 2 * size, 1e-9) == (size, 0)


@pytest.mark.parametrize("zeros", [1, 2, 3])
def test_elimination_counts_zeros(zeros):
    matrix = symmetric([1.0, -2.0, 3.0, *[0.0] * zeros], np.random.default_rng(zeros))
    assert eliminate(matrix.copy(), 0, len(matrix), len(matrix), 1e-9) == (1, zeros)


def test_elimination_leaves_the_schur_complement():
    matrix = symmetric([3.0, -2.0, 1.0, 4.0, -5.0, 0.5], np.random.default_rng(1))
    whole = matrix.copy()
    eliminate(whole, 0, 4, len(whole), 1e-9)
    expected = matrix[4:, 4:] - matrix[4:, :4] @ np.linalg.solve(matrix[:4, :4], matrix[:4, 4:])
    np.testing.assert_allclose(whole[4:, 4:], expected, atol=1e-12)


@pytest.mark.parametrize("name", [*SHORT_FORM, "six_rus", "two_rods"])
def test_indices_are_those_of_the_spectra_and_signs_those_of_the_determinant(name):
    """Also where the robot is unstable: poses far down are reached through stability crossings."""
    robot, random = load_robot(name), np.random.default_rng(3)
    home, seen = solve_home(robot), set()
    same_side = kinemato_statics(home).singularity("inverse").sign * home.signs.inverse_sign
    load = 3.0 * robot.kernel_arrays.energy_unit / robot.mean_length
    for _ in range(60):
        away = random.uniform(-1.0, 1.0, robot.motor_count) * RANGES[name]
        force = random.normal(size=3) * load * (1.0 if not robot.planar else [1.0, 1.0, 0.0])
        try:
            equilibrium = solve_forward(robot, home.motors + 0.3 * away)
            equilibrium = solve_forward(
                robot,
                equilibrium.motors,
                start=equilibrium,
                loads=equilibrium.loads.with_(wrench_world=[0, 0, 0, *force]),
            )
        except NotReached as end:
            equilibrium = end.last
        assert equilibrium.signs.index_locked == equilibrium.spectrum_locked.index
        assert equilibrium.signs.index_free == equilibrium.spectrum_free.index
        sign = kinemato_statics(equilibrium).singularity("inverse").sign
        assert equilibrium.signs.inverse_sign == same_side * sign
        assert index_by_eigenvalues(equilibrium) == equilibrium.signs.index_locked
        seen.add(equilibrium.signs.index_free)
    assert len(seen) > 1 or name in ("gough_stewart", "planar_body")


@pytest.mark.parametrize("controlled", [["z", "pitch", "yaw"], ["x", "y", "yaw"]])
def test_signs_are_those_of_the_determinant_where_roll_or_pitch_is_unknown(controlled):
    robot = load_robot(shipped_content("three_rfs") | {"controlled": controlled})
    home, random = solve_home(robot), np.random.default_rng(3)
    signs, same_side = set[int](), set[float]()
    for away in 0.25 * robot.motor_units * random.uniform(-1.0, 1.0, (40, 3)):
        equilibrium = solve_forward(robot, home.motors + away)
        sign = equilibrium.signs.inverse_sign
        signs.add(sign)
        same_side.add(sign * kinemato_statics(equilibrium).singularity("inverse").sign)
    assert signs == {-1, 1}
    assert len(same_side) == 1


def test_indices_beyond_two_crossings():
    robot = load_robot("rfrfr")
    equilibrium = solve_inverse(robot, [0.0, 0.8])
    for y in np.linspace(0.75, -0.2, 20):
        equilibrium = solve_inverse(robot, [0.0, y], start=equilibrium)
        assert equilibrium.signs.index_locked == equilibrium.spectrum_locked.index
        assert equilibrium.signs.index_free == equilibrium.spectrum_free.index
    assert equilibrium.signs.index_locked == 2


def test_straight_legs_are_counted_all_the_same():
    """A straight rod under no force cannot be eliminated on its own."""
    from helpers.columns import AT_TIP, column

    from cpr_core.description import joints, motors

    home = solve_home(column(motors.Welded(), joints.Fixed(AT_TIP)))
    assert home.signs.index_locked == 0
    pushed = solve_forward(
        home.robot, [], loads=Loads.none().with_(wrench_world=[0, 0, 0, 1e-3, 0, 0])
    )
    assert pushed.signs.index_locked == pushed.spectrum_locked.index == 0


def test_the_sign_is_that_of_the_determinant_under_loads_without_a_potential_too():
    """It was that of the symmetric part: of strong loads another one."""
    robot, random = load_robot("three_rfs"), np.random.default_rng(7)
    home, seen = solve_home(robot), []
    unit = robot.kernel_arrays.energy_unit * np.array([1.0] * 3 + [1.0 / robot.mean_length] * 3)
    for _ in range(40):
        loads = Loads.none().with_(
            wrench_body=unit * random.normal(size=6),
            wrench_world=np.append(unit[:3] * random.normal(size=3), np.zeros(3)),
        )
        away = 0.6 * random.normal(size=3) * robot.motor_units
        try:
            equilibrium = solve_forward(robot, home.motors + away, loads=loads)
        except NotReached:
            continue
        sign = kinemato_statics(equilibrium).singularity("inverse").sign
        assert equilibrium.signs.inverse_sign == sign
        seen.append(sign)
    assert len(seen) > 5
    assert set(seen) == {-1, 1}
