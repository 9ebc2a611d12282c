# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pencils of straight legs, whose multipliers are left to the border, against LAPACK."""

from functools import partial

import numpy as np
import pytest
from helpers.columns import AT_TIP, column
from helpers.kernel_entry import entry

from cpr_core import Loads, load_robot, solve_forward, solve_home
from cpr_core.description import joints, motors
from cpr_core.kernels import delayed_pencil_kernel, pencil_kernel, recall_kernel
from cpr_core.kernels.linearisation_kernel import linearise
from cpr_core.kernels.pencil import pencil_of
from cpr_core.kernels.pencil_kernel import Measure, is_diagonal
from cpr_core.model.equilibrium_steps import evaluated_again
from cpr_core.model.stability import _Dense

gather_pencil = entry(delayed_pencil_kernel.gather_pencil)
recall_pencil = entry(recall_kernel.recall_pencil)


@entry
def eliminate_pencil(robot, pencil, free, shift):
    measure = Measure(pencil.gram, is_diagonal(pencil.gram), pencil.weights, 1.0, free)
    return pencil_kernel.eliminate_pencil(pencil, measure, shift)


def found_by_tangent(found):
    """Margin, smallest eigenvalues with motors held and free [J], from the tangent."""
    evaluated_again(found)
    eigenvalues, prepared = np.empty(3), found.robot.prepared
    response = np.empty((len(found.robot.kernel_arrays.border_indices),) * 2)
    linearise(prepared, found.factors, found.record, True, True, eigenvalues, response)
    return eigenvalues


def straight_column(*, planar):
    """One clamped rod, straight, that holds the platform at its tip."""
    return solve_home(column(motors.Welded(), joints.Fixed(AT_TIP), planar=planar))


def straight_platform(change, loads=None):
    """Six legs nearly straight, with forces and moments at their tips."""
    robot = load_robot("gough_stewart", modes=3)
    home = solve_home(robot)
    away = np.cos(np.arange(6.0)) * change
    return solve_forward(robot, home.motors + away, loads=loads or robot.default_loads)


def pulled_straight(change):
    """Legs of five modes, bent at home, that hold the platform between them."""
    robot = load_robot("gough_stewart")
    home = solve_home(robot)
    return solve_forward(robot, home.motors + change * np.array([1, -1, 1, -1, 1, -1]))


STRAIGHT = {
    "a rod in the plane": lambda: straight_column(planar=True),
    "a rod in space": lambda: straight_column(planar=False),
    "six legs at home": lambda: straight_platform(0.0),
    "six legs near it": lambda: straight_platform(1e-5),
    "six legs without gravity": lambda: straight_platform(1e-4, Loads.none()),
    "six legs twisted": lambda: straight_platform(
        2e-4, Loads.none().with_(wrench_world=[0.01, 0.02, -0.01, 0.1, -0.1, 0.2])
    ),
} | {
    f"six legs pulled straight by {millimetres} mm": partial(pulled_straight, 1e-3 * millimetres)
    for millimetres in (2.55, 2.7, 2.85, 3.0, 3.15)
}
DRIVEN = [name for name in STRAIGHT if name.startswith("six legs")]


def gathered(found):
    """The pencil of an equilibrium, in the memory of its robot."""
    evaluated_again(found)
    work, pencil = found.robot.prepared.values[1:]
    assert gather_pencil(found.robot.kernel_arrays, work, pencil)
    assert pencil.delayed_count[0] > 0
    return pencil


@pytest.mark.parametrize(
    ("name", "free"), [*((name, False) for name in STRAIGHT), *((name, True) for name in DRIVEN)]
)
def test_eigenvalues_are_counted_and_the_smallest_is_found(name, free):
    found = STRAIGHT[name]()
    expected = _Dense(found, "free" if free else "locked").eigenvalues()
    size = np.abs(expected).max()
    smallest = found_by_tangent(found)[2 if free else 1]
    assert smallest == pytest.approx(expected[0], rel=1e-10, abs=1e-10 * size)
    pencil, arrays = gathered(found), found.robot.kernel_arrays
    gaps = np.flatnonzero(np.diff(expected) > 1e-7 * size)  # some come in pairs
    shifts = [0.9 * expected[0], *(0.5 * (expected[gap] + expected[gap + 1]) for gap in gaps)]
    assert len(shifts) > 2
    for shift in shifts:
        below = eliminate_pencil(arrays, pencil, free, shift / arrays.energy_unit)
        assert below == np.sum(expected < shift)


@pytest.mark.parametrize("name", STRAIGHT)
def test_the_margin_is_that_of_the_dense_matrix(name):
    found = STRAIGHT[name]()
    expected = _Dense(found, "locked").margin()
    assert found_by_tangent(found)[0] == pytest.approx(expected, rel=1e-10)


def bent_column(*, planar):
    """A rod that is pushed at its end, and no motor."""
    robot = column(motors.Welded(), joints.Fixed(AT_TIP), planar=planar)
    pushed = [0.0, 0.02 * (not planar), 0.05, 0.0, 0.1, 0.2 * (not planar)]
    return solve_forward(robot, [], loads=robot.default_loads.with_(wrench_world=pushed))


BENT = {
    name: partial(lambda name: solve_home(load_robot(name)), name)
    for name in ("rfrfr", "six_rfs", "three_rfs", "six_rus", "three_prs", "delta")
} | {
    "a rod in the plane": partial(bent_column, planar=True),
    "a rod in space": partial(bent_column, planar=False),
}


@pytest.mark.parametrize("name", BENT)
def test_factors_and_tangent_tell_the_same(name):
    """Of bent legs the pencil is there both ways; nothing is delayed then."""
    found = BENT[name]()
    arrays, grams = found.robot.kernel_arrays, found.robot.strain_grams
    recalled, pencil = pencil_of(arrays, grams), pencil_of(arrays, grams)
    assert recall_pencil(arrays, found.factors, recalled, 1e5)
    evaluated_again(found)
    assert gather_pencil(arrays, found.robot.prepared.values.work, pencil)
    assert pencil.delayed_count[0] == 0
    rows = arrays.slots.inner_count + arrays.one_slot_a_motor  # else there are no rows of motors
    kept = [*range(rows), *range(arrays.slots.inner_count + 1, pencil.blocks.shape[2])]
    first, last = (each.blocks["lane"][:, :rows, kept] for each in (recalled, pencil))
    rounding = 1e-12 * np.abs(last).max()
    np.testing.assert_allclose(first, last, rtol=0.0, atol=rounding)
    # The platform's part is what the legs had left of it and what they had taken: as large as both are.
    border = np.abs(recalled.condensed[: len(pencil.corner), : len(pencil.corner)]).max()
    rounding = max(rounding, 64.0 * np.finfo(float).eps * border)
    first, last = (np.triu(each.corner) for each in (recalled, pencil))
    np.testing.assert_allclose(first, last, rtol=0.0, atol=rounding)


def test_a_rod_about_to_buckle_on_its_own_is_left_to_the_dense_method():
    """A small pivot of strain: M sees it."""
    found = solve_home(load_robot("rfrfr"))
    evaluated_again(found)
    work, pencil = found.robot.prepared.values[1:]
    work.blocks["lane"][0, 0, 0, 0] = 0.0
    assert not gather_pencil(found.robot.kernel_arrays, work, pencil)
