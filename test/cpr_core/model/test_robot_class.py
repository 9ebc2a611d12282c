# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The class of robots: what must hold for every shipped one."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.shipped_steps import REDUNDANT, STEPS
from helpers.yaml_content import shipped_content

from cpr_core import (
    Robot,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.description.motors import Extensible, Prismatic, RevoluteMotor, Welded
from cpr_core.description.robot_description import HomeGuess
from cpr_core.lie import rotation_exp

HEAVY = {True: [0.5, -2.0, 0.0], False: [0.5, -1.0, -9.81]}


@pytest.fixture(scope="module", params=sorted(shipped_robots()))
def robot(request):
    return load_robot(request.param)


@pytest.fixture(scope="module", params=sorted(set(shipped_robots()) - set(REDUNDANT)))
def square(request):
    return load_robot(request.param)


def moved(robot, start=None, loads=None):
    motors = solve_home(robot).motors + np.array(STEPS[robot.description.name])
    return solve_forward(robot, motors, start=start, loads=loads)


def heavy(robot):
    return robot.default_loads.with_(gravity=HEAVY[robot.planar])


def test_every_shipped_robot_has_a_step():
    assert set(STEPS) == set(shipped_robots())


def test_home_is_stable(robot):
    assert solve_home(robot).converged
    assert solve_home(robot).index_locked == 0
    np.testing.assert_array_equal(solve_home(robot).motors, robot.description.home.motors)


def test_the_inverse_problem_gives_back_the_motors(square):
    forward = moved(square, loads=heavy(square))
    back = solve_inverse(square, forward.pose, loads=heavy(square))
    np.testing.assert_allclose(back.motors, forward.motors, atol=1e-9)
    np.testing.assert_allclose(back.efforts, forward.efforts, atol=1e-6)


def test_the_efforts_lead_back_to_the_motors(robot):
    start = moved(robot, loads=heavy(robot))
    onward = solve_forward(
        robot, start.motors + 0.2 * np.array(STEPS[robot.description.name]), start=start
    )
    back = solve_forward_by_effort(robot, start.efforts, start=onward)
    np.testing.assert_allclose(back.motors, start.motors, atol=1e-8)


def test_the_hessian_is_symmetric_under_conservative_loads(robot):
    loaded = moved(robot, loads=heavy(robot))
    unit = robot.kernel_arrays.unit
    tangent = loaded.tangent * unit[:, None] * unit
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-10 * np.abs(tangent).max())


def test_energy_gained_is_the_work_of_the_motors(robot):
    first = solve_forward(robot, solve_home(robot).motors, loads=heavy(robot))
    last = moved(robot, start=first)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    step, equilibrium, work = last.motors - first.motors, first, 0.0
    for node, weight in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
        equilibrium = solve_forward(robot, first.motors + node * step, start=equilibrium)
        work += weight * equilibrium.efforts @ step
    assert last.energy - first.energy == pytest.approx(work, rel=1e-6)


def turned_description(description, turn, shift):
    """The whole robot somewhere else."""

    def motor(motor):
        if isinstance(motor, RevoluteMotor | Prismatic):
            return type(motor)(tuple(turn @ motor.axis))
        assert isinstance(motor, Extensible | Welded)
        return motor

    home = description.home
    return replace(
        description,
        legs=tuple(
            replace(
                leg,
                base_position=turn @ leg.base_position + shift,
                base_rotation=turn @ leg.base_rotation,
                motor=motor(leg.motor),
            )
            for leg in description.legs
        ),
        home=HomeGuess(
            motors=home.motors,
            platform_position=None
            if home.platform_position is None
            else turn @ home.platform_position + shift,
            platform_rotation=None
            if home.platform_rotation is None
            else turn @ home.platform_rotation,
            strain=home.strain,
            bow=tuple(None if side is None else turn @ side for side in home.bow),
        ),
        loads=description.loads.with_(gravity=turn @ description.gravity),
    )


def test_a_robot_turned_and_shifted_with_its_loads_does_the_same(robot):
    turn = rotation_exp([0.0, 0.0, 0.7] if robot.planar else [0.4, -0.8, 0.5])
    shift = np.array([1.0, -2.0, 0.0 if robot.planar else 0.5])
    wrench = np.array([0.0, 0.0, 0.0, 0.05, -0.08, 0.0 if robot.planar else 0.1])
    other = Robot(turned_description(robot.description, turn, shift))
    original = moved(robot, loads=heavy(robot).with_(wrench_world=wrench))
    turned = moved(
        other,
        loads=other.default_loads.with_(
            gravity=turn @ HEAVY[robot.planar],
            wrench_world=np.concatenate([turn @ wrench[:3], turn @ wrench[3:]]),
        ),
    )
    np.testing.assert_allclose(
        turned.platform_position, turn @ original.platform_position + shift, atol=1e-9
    )
    if not robot.description.point_platform:
        np.testing.assert_allclose(
            turned.platform_rotation, turn @ original.platform_rotation, atol=1e-9
        )
    np.testing.assert_allclose(turned.efforts, original.efforts, atol=1e-8)
    np.testing.assert_allclose(turned.leg_coordinates, original.leg_coordinates, atol=1e-8)
    np.testing.assert_allclose(
        turned.spectrum_locked.eigenvalues,
        original.spectrum_locked.eigenvalues,
        rtol=1e-7,
        atol=1e-9,
    )


@pytest.mark.parametrize("name", sorted(STEPS))
@pytest.mark.parametrize("basis", ["chebyshev", "monomials", "bsplines"])
def test_the_basis_does_not_matter_for_the_same_polynomials(name, basis):
    content = shipped_content(name)
    content["strain"] |= {"basis": basis}
    if basis == "bsplines":  # without knots: Bernstein polynomials
        content["strain"] |= {"degree": 4, "knots": []}
        if content["strain"].get("torsion"):
            content["strain"]["torsion"] = 5
    reference = load_robot(name)
    if content["strain"].get("torsion") == 5:
        legendre = shipped_content(name)
        legendre["strain"]["torsion"] = 5
        reference = load_robot(legendre)
    found, expected = moved(load_robot(content)), moved(reference)
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=1e-8)
    np.testing.assert_allclose(found.efforts, expected.efforts, atol=1e-7)
    np.testing.assert_allclose(
        found.spectrum_locked.eigenvalues, expected.spectrum_locked.eigenvalues, rtol=1e-5
    )


def test_splines_with_knots_approach_the_same_solution():
    content = shipped_content("six_rfs")
    content["strain"] = {"basis": "bsplines", "degree": 4, "knots": [0.2, 0.4, 0.6, 0.8]}
    content["strain"]["torsion"] = 0
    found, expected = moved(load_robot(content)), moved(load_robot("six_rfs", modes=12))
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=2e-5)


@pytest.mark.parametrize("name", sorted(STEPS))
def test_the_error_falls_spectrally_with_the_modes(name):
    exact = moved(load_robot(name, modes=14))
    errors = [
        np.linalg.norm(moved(load_robot(name, modes=m)).platform_position - exact.platform_position)
        for m in (3, 5, 7, 9, 11)
    ]
    # A factor of five a mode on the whole, down to rounding.
    assert errors[-1] < max(errors[0] * 5.0**-8, 1e-10)
