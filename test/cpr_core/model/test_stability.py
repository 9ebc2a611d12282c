# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Index and margin: known crossings, invariance, reciprocity between the readings of the motors."""

import numpy as np
import pytest
from helpers.fed_robots import fed, plain_content
from scipy.optimize import brentq

from cpr_core import (
    Loads,
    UnstableEquilibrium,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    spectrum,
)
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from cpr_core.model.stability import elastic_hessian, null_space_of


def on_the_axis(robot, y, start):
    return solve_inverse(robot, [0.0, y], start=start)


def crossing(robot, high, low, which):
    """Height on x = 0 at which one more eigenvalue is negative, motors held."""
    start = on_the_axis(robot, high, solve_inverse(robot, [0.0, 0.8]))
    return brentq(
        lambda y: on_the_axis(robot, y, start).spectrum_locked.eigenvalues[which],
        low,
        high,
        xtol=1e-9,
    )


def test_locked_crossings_of_the_rfrfr_robot_on_its_axis():
    robot = load_robot("rfrfr", modes=12)
    assert crossing(robot, 0.1, 0.0, 0) == pytest.approx(0.03571, abs=5e-5)
    assert crossing(robot, -0.03, -0.1, 1) == pytest.approx(-0.05740, abs=5e-5)


@pytest.mark.parametrize("y", [0.8, 0.01642, 0.0164, -0.1])
def test_index_and_condition_number_are_those_of_the_eigenvalues(y):
    """Also close to where stability is lost, at y = 0.016415: a small eigenvalue has a sign."""
    found = on_the_axis(load_robot("rfrfr"), y, None).spectrum_locked
    assert found.index == (0 if y > 0.016415 else 1 if y > 0.0 else 2)
    assert found.index == np.sum(found.eigenvalues < 0.0)
    sizes = sorted(np.abs(found.eigenvalues))
    assert found.inverse_condition_number == pytest.approx(sizes[0] / sizes[-1])
    assert found.inverse_condition_number < 1.0


@pytest.mark.parametrize("name", ["delta", "six_rus"])
def test_eigenvalues_that_are_rounding_are_not_counted(name):
    """Without loads their cranks turn as they like where motors give way."""
    home = solve_home(load_robot(name))
    found = solve_forward(home.robot, home.motors, loads=Loads.none())
    eigenvalues = found.spectrum_free.eigenvalues
    assert abs(eigenvalues[0]) < 1e-12 * eigenvalues[-1]
    assert found.spectrum_free.index == found.index_free == 0


def test_crossings_converge_to_those_of_continuous_rods():
    """Continuous rods (test_conjugate_points.py): 0.035710941 and -0.057398930."""
    robot = load_robot("rfrfr", modes=16)
    assert crossing(robot, 0.1, 0.0, 0) == pytest.approx(0.035710941, abs=1e-6)
    assert crossing(robot, -0.03, -0.1, 1) == pytest.approx(-0.057398930, abs=1e-6)


def test_the_six_rfs_slice_loses_stability_where_continuous_rods_do():
    """z = 0.635 m, ZYZ Euler angles (pi/8, pi/3, 0), x = -0.4: index 0 to 1 at y = 0.16700."""
    robot = load_robot("six_rfs", modes=12)
    turn = rotation_exp([0, 0, np.pi / 8]) @ rotation_exp([0, np.pi / 3, 0])
    quaternion = quaternion_from_rotation(turn)

    def at(y, start):
        return solve_inverse(robot, [-0.4, y, 0.635, *quaternion], start=start)

    start = at(0.1, None)
    assert (start.index_locked, at(0.2, start).index_locked) == (0, 1)
    found = brentq(lambda y: at(y, start).spectrum_locked.smallest, 0.1, 0.2, xtol=1e-8)
    assert found == pytest.approx(0.167003, abs=5e-5)


def test_index_counts_the_negative_eigenvalues():
    robot = load_robot("rfrfr", modes=12)
    start = solve_inverse(robot, [0.0, 0.8])
    for y, index in ((0.8, 0), (0.05, 0), (0.03, 1), (-0.05, 1), (-0.1, 2)):
        start = on_the_axis(robot, y, start)
        assert start.index_locked == index


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_free_index_is_the_locked_one_plus_the_softening_motor_directions(name):
    """index(free) = index(locked) + negative eigenvalues of dtau_a/dq_a, by differences."""
    robot = load_robot(name)
    if robot.planar:
        points = [solve_inverse(robot, [0.1, y]) for y in (0.8, 0.3, -0.1)]
    else:
        points = [
            solve_forward(
                robot, solve_home(robot).motors + t * np.array([2, 2, -1.6, -1.6, -2, -2])
            )
            for t in (0.0, 0.6, 1.0)
        ]
    assert {point.index_free for point in points} != {0}
    for point in points:
        columns = []
        for motor in range(robot.motor_count):
            step = 1e-4 * np.eye(robot.motor_count)[motor]
            ahead = solve_forward(robot, point.motors + step, start=point)
            behind = solve_forward(robot, point.motors - step, start=point)
            columns.append((ahead.efforts - behind.efforts) / 2e-4)
        stiffness = np.array(columns)
        np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-6 * np.abs(stiffness).max())
        softening = int(np.sum(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)) < 0.0))
        assert point.index_free == point.index_locked + softening


def test_margin_is_one_without_forces_and_zero_at_the_crossing():
    content = load_robot("rfrfr", modes=12)
    near = on_the_axis(content, 0.0358, on_the_axis(content, 0.1, solve_inverse(content, [0, 0.8])))
    assert 0.0 < near.spectrum_locked.margin < 2e-3
    margins = []
    for load in (0.0, 0.05, 0.1):
        loads = Loads.none().with_(wrench_world=[0, 0, 0, 0, -load, 0])
        margins.append(solve_forward(content, [2.59, 0.55], loads=loads).spectrum_locked.margin)
    assert 1.0 > margins[0] > margins[1] > margins[2] > 0.0


@pytest.mark.parametrize("motors_are", ["locked", "free"])
def test_smallest_eigenvalues_converge_with_the_modes(motors_are):
    values = [
        spectrum(solve_home(load_robot("six_rfs", modes=modes)), motors_are).eigenvalues[0]
        for modes in (5, 8, 12)
    ]
    assert values[0] == pytest.approx(values[2], rel=2e-3)
    assert values[1] == pytest.approx(values[2], rel=1e-5)


def test_a_non_conservative_load_is_said():
    robot = load_robot("six_rfs")
    moment = Loads.none().with_(wrench_world=[0, 0, 0.01, 0, 0, 0])
    following = Loads.none().with_(wrench_body=[0, 0, 0, 0, 0, 0.1])
    force = Loads.none().with_(wrench_world=[0, 0, 0, 0, 0, 0.1])
    for loads, applies in ((moment, False), (following, False), (force, True)):
        found = solve_forward(robot, solve_home(robot).motors, loads=loads)
        assert found.spectrum_locked.energy_criterion_applies is applies
        assert found.spectrum_free.energy_criterion_applies is applies


@pytest.mark.parametrize("described", ["six_rfs", "gough_stewart", fed(plain_content())])
def test_elastic_stiffness_is_the_second_derivative_of_the_elastic_energy(described):
    """l0/l q^T K q / 2 of every leg; a motor that feeds the rod changes l."""
    robot = load_robot(described, modes=3)
    equilibrium = solve_forward(robot, solve_home(robot).motors + 0.02)
    motions = np.random.default_rng(3).standard_normal((2, robot.state_size))

    def energy(first, second):
        state, total = equilibrium.state + 1e-4 * (first * motions[0] + second * motions[1]), 0.0
        for rod in robot.numbers.rods:
            described, strain = rod.element.rod, state[rod.strain]
            stiffness = described.stiffness(rod.element.modes, robot.grid)
            total += 0.5 * described.length / rod.length(state) * strain @ stiffness @ strain
        return total

    mixed = energy(1, 1) - energy(1, -1) - energy(-1, 1) + energy(-1, -1)
    found = motions[0] @ elastic_hessian(equilibrium) @ motions[1]
    assert found == pytest.approx(0.25e8 * mixed, rel=1e-5)


@pytest.mark.parametrize("rank", [0, 1, 3, 5])
def test_a_null_space_is_all_that_a_matrix_does_not_see(rank):
    """Rows that depend on others, as those of a robot that is held twice, take nothing away."""
    random = np.random.default_rng(rank)
    matrix = random.standard_normal((5, rank)) @ random.standard_normal((rank, 9))
    matrix *= 10.0 ** random.uniform(-3, 3, (5, 1))
    basis = null_space_of(matrix)
    assert basis.shape == (9, 9 - rank)
    np.testing.assert_allclose(basis.T @ basis, np.eye(9 - rank), atol=1e-14)
    np.testing.assert_allclose(matrix @ basis, 0.0, atol=1e-12 * np.abs(matrix).max(initial=1.0))
    assert null_space_of(np.zeros((0, 4))).shape == (4, 4)


def nearly_straight(curvature):
    """A cantilever, slightly bent in its stiff plane, that buckles out of it; and Euler's force [N]."""
    content = {
        "name": "column",
        "space": "spatial",
        "rod": {
            "length": 0.5,
            "section": {"shape": "rectangular", "width": 0.004, "height": 0.002},
            "young_modulus": 210e9,
            "shear_modulus": 82e9,
            "rest_curvature": {"bending_3": [curvature]},
        },
        "strain": {"torsion": 2, "bending_2": 5, "bending_3": 5},
        "platform": {"mass": 0.0},
        "legs": [
            {
                "base": {"position": [0, 0, 0], "tangent": [0, 0, 1], "normal": [1, 0, 0]},
                "motor": {"type": "revolute", "axis": [0, 1, 0]},
                "tip": {
                    "type": "fixed",
                    "position": [0, 0, 0],
                    "tangent": [0, 0, 1],
                    "normal": [1, 0, 0],
                },
            }
        ],
        "controlled": ["x"],
        "home": {"motors": [0.0], "platform": {"position": [0, 0, 0.5]}},
    }
    robot = load_robot(content)
    _, *bending = robot.description.rods[0].rod.rigidities
    return robot, np.pi**2 * min(bending) / (4.0 * 0.5**2)


@pytest.mark.parametrize("curvature", [0.02, 0.007, 0.004, 0.003, 0.002])
def test_a_nearly_straight_leg_hides_no_instability(curvature):
    """Its stiffness along itself is a thousand million times that of what buckles."""
    robot, euler = nearly_straight(curvature)
    home = solve_home(robot)
    for part in (0.99, 0.9999, 1.0001, 1.001, 1.005):
        pushed = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, 0, -part * euler])
        found = solve_forward(robot, home.motors, start=home, loads=pushed)
        assert found.index_locked == int(part > 1.0) == found.spectrum_locked.index
        assert found.stable == (part < 1.0) == (found.margin > 0.0)
    with pytest.raises(UnstableEquilibrium, match=r"99\.50 % of the way"):
        solve_forward(robot, home.motors, start=home, loads=pushed, stable_only=True)
