# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Solves on a path: at fractions and by arc length, tangents against differences."""

import numpy as np
import pytest
from helpers.ring_robots import three_swinging
from helpers.shipped_steps import SHORT_FORM
from helpers.strain_bases import with_basis

from benchmarks.robustness import RANGES, distance
from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.kernels.record_layout import IMPOSED_MOTORS, POSITION
from cpr_core.solving.path import Path
from cpr_core.solving.requests import target_of

PROBLEMS = ["motors", "pose", "efforts"]


def path_of(robot, problem, loaded=False):
    pattern = np.resize([0.2, -0.1, 0.15, 0.1, -0.2], robot.motor_count)
    reach = 0.2 * RANGES[robot.description.name]
    target = solve_forward(robot, solve_home(robot).motors + pattern * reach)
    loads = solve_home(robot).loads
    if loaded:
        force = 0.1 * robot.kernel_arrays.energy_unit / robot.mean_length
        loads = loads.with_(wrench_world=[0, 0, 0, force, -force, 0])
    return Path(
        solve_home(robot), target_of(solve_home(robot), problem, getattr(target, problem)), loads
    )


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("name", [*SHORT_FORM, "delta", "two_rods"])
def test_tangents_are_those_of_differences(name, problem, loaded):
    path = path_of(load_robot(name), problem, loaded)
    middle = path.begin()
    for fraction in (0.1, 0.2, 0.3):
        middle = path.at(middle, fraction)
    step = 1e-4
    before, after = path.at(middle, 0.3 - step), path.at(middle, 0.3 + step)
    rate = path.tangent(middle)
    unit = middle.equilibrium.robot.kernel_arrays.unit
    inner = middle.equilibrium.robot.kernel_arrays.platform_index
    change = (after.equilibrium.state - before.equilibrium.state)[:inner] / unit[:inner]
    expected = change / (2.0 * step)
    found = rate.unknowns[:inner] / rate.fraction
    np.testing.assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("name", [*SHORT_FORM, "delta", "two_rods"])
def test_points_by_arc_length_lie_on_the_path(name, problem):
    path = path_of(load_robot(name), problem)
    start = path.begin()
    tangent = path.tangent(start)
    found = path.along(start, tangent, 0.02)
    assert found is not None
    direct = path.at(start, found.fraction)
    assert distance(found.equilibrium, direct.equilibrium) < 1e-7
    assert path.tangent(found, tangent).cosine(tangent) > 0.9
    back = path.along(found, path.tangent(found, tangent), -0.02)
    assert abs(back.fraction) < 1e-2


def test_starts_are_points_of_their_paths():
    path = path_of(load_robot("six_rfs"), "pose")
    begin = path.begin()
    assert begin.fraction == 0.0
    assert begin.equilibrium is path.start
    assert (begin.index, begin.sign) == (0, path.start.signs.inverse_sign)


@pytest.mark.parametrize("problem", ["motors", "efforts"])
def test_what_is_the_same_at_both_ends_is_the_same_on_the_way(problem):
    """Commands were not where the equilibrium was, by one bit, under a load that came."""
    robot = load_robot("six_rfs")
    start = solve_forward(robot, solve_home(robot).motors + [0.1, 0.07, 0.03, -0.1, -0.07, 0.01])
    target = target_of(start, problem, getattr(start, problem))
    path = Path(start, target, start.loads.with_(wrench_world=[0, 0, 0, 0.1, 0, 0]))
    begin = path.begin()
    tangent = path.tangent(begin)
    asked = getattr(target, problem)
    for fraction in (0.1, 0.3, 0.7, 1.0):
        np.testing.assert_array_equal(target.given(start, fraction)[0], asked)
        if problem == "motors":
            np.testing.assert_array_equal(path.at(begin, fraction).equilibrium.motors, asked)
            found = path.along(begin, tangent, 0.01 * fraction)
            np.testing.assert_array_equal(found.equilibrium.motors, asked)


def test_coordinates_that_are_not_asked_to_move_stay_to_the_last_bit():
    robot = load_robot("planar_body")
    start = solve_forward(robot, solve_home(robot).motors + [0.1, 0.07, 0.03])
    target = target_of(start, "pose", start.pose + [0.0, 0.05, 0.0])
    for fraction in (0.1, 0.3, 0.7):
        given = target.given(start, fraction)[0, POSITION:IMPOSED_MOTORS]
        np.testing.assert_array_equal(given[[0, 2]], start.platform_position[[0, 2]])


def test_far_fractions_are_refused_not_jumped_to():
    robot = load_robot("six_rfs")
    target = target_of(
        solve_home(robot), "motors", solve_home(robot).motors + [2, -2, 2, -2, 2, -2]
    )
    path = Path(solve_home(robot), target, solve_home(robot).loads)
    assert path.at(path.begin(), 1.0) is None


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("name", [*SHORT_FORM, "delta", "two_rods"])
def test_singular_values_do_not_depend_on_the_strain_basis(name, problem):
    """What tells where branches cross: with monomials all places did."""
    found, expected = (
        path.singular_values(path.at(path.begin(), 0.1))
        for path in (
            path_of(with_basis(name, basis, 5), problem) for basis in ("monomials", "legendre")
        )
    )
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_ways_that_branches_go_on_in_are_those_that_vanish_where_nothing_hangs():
    robot = three_swinging()
    home = solve_home(robot)
    below = target_of(home, "pose", [home.platform_position[2] - 0.02, 0.0, 0.0])
    path = Path(home, below, home.loads)
    crossing = path.begin()
    for fraction in np.linspace(0.05, 0.537, 11):
        crossing = path.at(crossing, fraction)
    assert np.sum(path.singular_values(crossing) < 1e-3) == 2
    assert path.bent_ways(crossing, 1e-3) == 2
    assert path.bent_ways(path.begin(), 1e-3) == 0
