# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The linear problems: their matrices, units and singularities."""

import numpy as np
import pytest
from helpers.placed_equilibria import close, placed

from cpr_core import load_robot, solve_forward, solve_home, solve_inverse
from cpr_core.description.chain import Turn
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.kinemato_statics import kinemato_statics
from cpr_core.model.problem_units import problem_units


@pytest.fixture(scope="module", params=sorted(shipped_robots()))
def equilibrium(request):
    return placed(request.param)


def test_the_papers_matrices_hold_for_any_motion(equilibrium):
    """A dq_a + P dSigma_p + E dq_e = W dw for the responses to motors and to wrenches."""
    model, robot = kinemato_statics(equilibrium), equilibrium.robot
    a, p, e, w = model.matrices()
    n, unit = robot.motor_count, robot.kernel_arrays.unit
    r = n + len(robot.elastic_indices) + len(robot.platform_indices)
    assert (len(a), len(p), len(e), len(w)) == (r, r, r, r)
    energy = robot.kernel_arrays.energy_unit
    motors, platform = unit[robot.motor_indices], unit[robot.platform_indices]
    legs = robot.unit_motions[np.ix_(robot.elastic_indices, robot.elastic_indices)]
    left = (
        a
        + p @ (model.jacobian / platform[:, None] * motors)
        + e @ (np.linalg.solve(legs, model.legs_by_motors) * motors)
    )
    right = w[:, :n] @ (model.efforts_by_motors * motors[:, None] * motors / energy)
    np.testing.assert_allclose(left, right, atol=1e-8 * max(np.abs(right).max(), 1.0))


def test_the_inverse_singularity_of_the_six_rfs_path():
    """Near t = 48 of Eq. (53) the indicator changes sign; motor 6 moves nothing."""
    robot = load_robot("six_rfs")
    first = np.array([5.86, 5.56, 5.86, 5.46, 5.86, 5.26])
    last = np.array([7.95, 7.65, 4.29, 3.89, 3.77, 3.17])

    def at(t, start):
        return solve_forward(robot, first + (last - first) * t / 50, start=start)

    solution, signs = solve_home(robot), []
    for t in range(51):
        solution = at(t, solution)
        signs.append(kinemato_statics(solution).singularity("inverse").sign)
    changes = [t for t in range(50) if signs[t] != signs[t + 1]]
    assert changes == [47]
    low, high, solution = 47.0, 48.0, at(47.0, solution)
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        solution = at(middle, solution)
        if kinemato_statics(solution).singularity("inverse").sign == signs[47]:
            low = middle
        else:
            high = middle
    singular = kinemato_statics(solution).singularity("inverse")
    assert singular.smallest < 1e-8
    assert low == pytest.approx(47.814, abs=2e-3)
    direction = np.abs(singular.motors) / np.linalg.norm(singular.motors)
    assert robot.motor_names[int(direction.argmax())] == "motor6"
    assert direction.max() > 0.9
    np.testing.assert_allclose(singular.platform, 0.0, atol=1e-12)


def test_the_forward_problem_is_singular_where_locked_stability_is_lost():
    robot = load_robot("rfrfr", modes=12)
    solution = solve_inverse(robot, [0.0, 0.1], start=solve_inverse(robot, [0.0, 0.8]))
    signs, values = [], []
    for y in (0.05, 0.0358, 0.0356, 0.02):
        solution = solve_inverse(robot, [0.0, y], start=solution)
        forward = kinemato_statics(solution).singularity("forward")
        signs.append(forward.sign)
        values.append(forward.smallest)
    assert signs[0] == signs[1] == -signs[2] == -signs[3]
    assert max(values[1:3]) < 0.05 * min(values[0], values[3])


def test_the_characteristic_length_decides_and_units_do_not():
    solution = placed("six_rfs")
    model = kinemato_statics(solution)
    default = model.singularity("inverse")
    assert model.singularity("inverse", 1.0).smallest == pytest.approx(default.smallest, rel=1e-9)
    assert model.singularity("inverse", 0.1).smallest != pytest.approx(default.smallest, rel=1e-2)


@pytest.mark.parametrize("problem", ["forward", "inverse", "inverse_by_effort"])
@pytest.mark.parametrize("length", [None, 0.3])
def test_singular_values_alone_are_the_same(equilibrium, problem, length):
    if problem == "inverse" and not equilibrium.robot.description.controlled:
        return
    model = kinemato_statics(equilibrium)
    whole = model.singularity(problem, length).singular_values
    np.testing.assert_allclose(
        model.singular_values(problem, length), whole, rtol=1e-9, atol=1e-12 * whole[-1]
    )


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart"])
def test_natural_units_follow_from_a_length_and_an_energy(name):
    """Curvatures are over the length, forces the energy over it, moments the energy, shifts lengths."""
    robot, length = load_robot(name), 0.3
    units = problem_units(robot, length)
    unit, energy = units.states, units.energy
    expected = np.full(robot.state_size, np.nan)
    for leg, numbers in zip(robot.description.legs, robot.numbers.legs, strict=True):
        expected[numbers.strain] = 1.0 / length
        expected[numbers.forces], expected[numbers.moments] = energy / length, energy
        for element, index in zip(leg.chain, numbers.coordinates, strict=True):
            if index is not None:
                expected[index] = 1.0 if isinstance(element, Turn) else length
    expected[robot.platform_indices] = np.where(robot.platform_axes < 3, 1.0, length)
    np.testing.assert_allclose(unit, expected, rtol=1e-12)
    # Both of the same rods: E J over the length.
    assert energy * length == pytest.approx(robot.kernel_arrays.energy_unit * robot.mean_length)


@pytest.mark.parametrize("name", ["rfrfr", "gough_stewart", "three_prs"])
def test_null_directions_are_in_rad_and_m(name):
    """They are those of the dimensionless matrices, of either sign, in units of motors and platform."""
    solution = placed(name)
    model, robot = kinemato_statics(solution), solution.robot
    for length in (robot.mean_length, 0.3 * robot.mean_length):
        (a, p, e, w), n = model.matrices(length), robot.motor_count
        for problem, part, indices, first, wrench in (
            ("inverse_by_effort", "motors", robot.motor_indices, a, w[:, n:]),
            ("forward", "platform", robot.platform_indices, p, w[:, :n]),
        ):
            null = np.linalg.svd(np.hstack([first, e, -wrench]))[2][-1, : first.shape[1]]
            units = problem_units(robot, length).states[indices]
            found = getattr(model.singularity(problem, length), part)
            close(found * np.sign(found @ (null * units)), null * units)


@pytest.mark.parametrize("motor", range(4))
def test_motors_that_are_held_are_no_unknowns_of_the_inverse_problem(motor):
    """All of them were: the values were those of the free robot, and there was no sign but an error."""
    robot = load_robot("four_rfr").holding((motor,))
    home = solve_home(robot)
    model = kinemato_statics(home)
    found = model.singularity("inverse")
    assert found.smallest == pytest.approx(model.smallest_singular_value("inverse"), rel=1e-6)
    np.testing.assert_allclose(found.singular_values, model.singular_values("inverse"), rtol=1e-9)
    assert found.sign == home.signs.inverse_sign
    assert found.motors[motor] == 0.0 and np.all(np.delete(found.motors, motor) != 0.0)
    way = np.array([1e-4, -2e-4, 0.0])
    predicted = model.predict_inverse([0.0, *(home.platform_rotation.T @ way)[:2]])
    ends = [solve_inverse(robot, home.pose + sign * way).motors for sign in (1.0, -1.0)]
    np.testing.assert_allclose(predicted.motors, (ends[0] - ends[1]) / 2, rtol=1e-4, atol=1e-9)
    assert predicted.motors[motor] == 0.0
