# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Continuous rods by shooting against the reference paths, differences and their own order."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.reference_paths import numbers, read, straight_path
from helpers.rough_homes import ROUGH, continuous_home
from numpy.testing import assert_allclose

from cpr_core import (
    InvalidRequest,
    Loads,
    NoForwardSolution,
    NoInverseSolution,
    NonFiniteInput,
    Robot,
    find_equilibria,
    load_robot,
    solve_home,
)
from cpr_core.lie import rotation_exp
from cpr_core.reference import continuous_rods
from cpr_core.reference.continuous_rods import (
    follow_motors,
    follow_platform,
    solve_continuous,
    solve_continuous_rough,
)
from cpr_core.reference.shooting_linearisation import ShootingState, linear_memory, linearise
from cpr_core.reference.shooting_method import TABLEAUS, ShootingMethod
from cpr_core.reference.shooting_robot import shooting_of
from cpr_core.rods.sections import SECTIONS

PATHS = {
    "rfrfr": ("rfrfr_forward_path.csv", ["q1", "q2"], ["x", "y"]),
    "six_rfs": ("6rfs_forward_path.csv", [f"q{k}" for k in range(1, 7)], ["px", "py", "pz"]),
}
GRAVITY = Loads.none().with_(gravity=[0.0, -9.81, 0.0])


def path(name):
    file, motors, place = PATHS[name]
    rows = read(file)
    home = continuous_home(load_robot(name))
    return rows, place, follow_motors(home, straight_path(rows, motors))


@pytest.mark.parametrize("name", PATHS)
def test_forward_and_inverse_paths_agree_with_the_reference(name):
    rows, place, points = path(name)
    for row in rows:
        point = points[int(row["t"])]
        assert_allclose(point.platform_position[: len(place)], numbers(row, *place), atol=1e-11)
        efforts = numbers(row, *(f"tau{k + 1}" for k in range(len(point.motors))))
        assert_allclose(point.efforts, efforts, atol=1e-11)
        assert point.residual < 1e-11
        if name == "six_rfs":
            quaternion = numbers(row, "qw", "qx", "qy", "qz")
            assert_allclose(point.platform_quaternion, quaternion, atol=1e-11)
    # The inverse problem of the 6-RFS path is singular near t = 47.8.
    points = points[: 51 if name == "rfrfr" else 46]
    positions = [point.platform_position for point in points]
    rotations = [point.platform_rotation for point in points]
    for point, back in zip(points, follow_platform(points[0], positions, rotations), strict=True):
        assert_allclose(back.motors, point.motors, atol=1e-9)


@pytest.mark.parametrize("name", PATHS)
def test_home_needs_no_strain_modes(name):
    robot = load_robot(name)
    alone, refined = continuous_home(robot), solve_continuous(solve_home(robot))
    assert_allclose(alone.platform_position, refined.platform_position, atol=1e-11)
    assert_allclose(alone.base_wrenches, refined.base_wrenches, atol=1e-10)
    assert alone.integration_error < 1e-11


@pytest.mark.parametrize("loads", [Loads.none(), GRAVITY], ids=["bare", "heavy"])
@pytest.mark.parametrize("name", PATHS)
def test_linearisation_agrees_with_differences(name, loads):
    robot = load_robot(name)
    start = continuous_home(robot, loads=loads)
    shooting, units = shooting_of(robot, loads, start.method)
    exact = units.without_dimensions(continuous_rods._state_of(start))
    workspace = linear_memory(shooting)
    assert linearise(shooting, exact, workspace) < 1e-11
    block = 3 if robot.planar else 6
    wrench = [2, 3, 4] if robot.planar else range(6)
    step = 1e-5

    def differences(change):
        """Of what closes the gaps, and of the imbalance: at an equilibrium, derivatives."""
        ends = []
        for sign in (step, -step):
            state, perturbed = (
                ShootingState(*[part.copy() for part in exact]),
                linear_memory(shooting),
            )
            state = change(state, sign) or state
            linearise(shooting, state, perturbed)
            ends.append(
                (perturbed.legs[:, :block, 0].copy(), perturbed.gap[: len(shooting.axes)].copy())
            )
        return [(a - b) / (2 * step) for a, b in zip(*ends, strict=True)]

    for leg in range(robot.motor_count):
        for row, component in enumerate(wrench):

            def push(state, h, leg=leg, component=component):
                state.wrenches[leg, component] += h

            legs, _ = differences(push)
            expected = np.zeros_like(legs)
            expected[leg, row] = 1.0
            assert_allclose(legs, expected, atol=1e-7)

        def turn(state, h, leg=leg):
            state.motors[leg] += h

        legs, gap = differences(turn)
        assert_allclose(legs[leg], workspace.legs[leg, :block, -1], atol=1e-7)
        assert_allclose(gap, workspace.turns[: len(gap), leg], atol=1e-6)
    for number, axis in enumerate(shooting.axes):

        def move(state, h, axis=axis):
            if axis >= 3:
                state.position[axis - 3] += h
                return None
            return state._replace(rotation=rotation_exp(h * np.eye(3)[axis]) @ state.rotation)

        legs, gap = differences(move)
        assert_allclose(legs, workspace.legs[:, :block, 1 + number], atol=1e-6)
        assert_allclose(gap, workspace.motion[: len(gap), number], atol=1e-6)


@pytest.mark.parametrize(("tableau", "order"), [("RK4", 4), ("DOPRI5", 5), ("DOP853", 8)])
@pytest.mark.parametrize("name", PATHS)
def test_integrators_have_their_order(name, tableau, order):
    file, motors, _ = PATHS[name]
    targets = straight_path(read(file), motors)[::10]
    start = continuous_home(load_robot(name))
    exact = follow_motors(start, targets)
    errors = []
    for count in (4, 8) if tableau == "DOP853" else (16, 32):
        found = follow_motors(start, targets, method=ShootingMethod(tableau, count))
        pairs = zip(found, exact, strict=True)
        errors.append(
            np.mean([np.linalg.norm(a.platform_position - b.platform_position) for a, b in pairs])
        )
    assert np.log2(errors[0] / errors[1]) > order - 0.6
    assert set(TABLEAUS) == {"RK4", "DOPRI5", "DOP853"}


def test_what_cannot_be_reached_is_an_error():
    home = continuous_home(load_robot("rfrfr"))
    with pytest.raises(NoInverseSolution, match="0 of 1"):
        follow_platform(home, [[3.0, 0.0, 0.0]])
    with pytest.raises(NoForwardSolution, match="of 2"):
        follow_motors(home, [home.motors, home.motors + [40.0, 0.0]])
    with pytest.raises(InvalidRequest, match="motors"):
        follow_motors(home, [[1.0, 2.0, 3.0]])
    with pytest.raises(NonFiniteInput, match="position"):
        follow_platform(home, [[np.nan, 0.0, 0.0]])
    robot, (curvatures, place, _) = home.robot, ROUGH["rfrfr"]
    with pytest.raises(InvalidRequest, match="curvatures"):
        solve_continuous_rough(robot, home.motors, curvatures[:1], place)
    with pytest.raises(NonFiniteInput, match="platform_position"):
        solve_continuous_rough(robot, home.motors, curvatures, [0.0, np.inf, 0.0])
    with pytest.raises(InvalidRequest, match="as many motors"):
        follow_platform(solve_continuous(solve_home(load_robot("three_rfs"))), [[0.0, 0.0, 0.5]])


def test_a_rod_stiffer_to_one_side_is_refused():
    description = load_robot("six_rfs").description
    section = SECTIONS["given"](torsion=0.2, bending_2=0.1, bending_3=0.3)
    leg = description.legs[0]
    legs = (replace(leg, rod=replace(leg.rod, section=section)), *description.legs[1:])
    with pytest.raises(InvalidRequest, match="leg1: expected a rod equally stiff"):
        continuous_home(Robot(replace(description, legs=legs)))


def test_integration_error_is_what_twice_the_steps_show():
    robot = load_robot("six_rfs")
    errors = [
        continuous_home(robot, method=ShootingMethod("RK4", steps)).integration_error
        for steps in (16, 32)
    ]
    assert 1e-7 < errors[1] < errors[0] < 1e-3
    assert 0.0 < continuous_home(robot).integration_error < 1e-11


def test_another_equilibrium_than_that_of_the_start_is_refused():
    """Five modes have an equilibrium that continuous rods have not: shooting went 0.4 m away from it."""
    robot = load_robot("rfrfr", modes=5)
    places = [[-0.6415, 0.0470, 0.0], [0.5458, 0.1327, 0.0]]
    found = [each.equilibrium for each in find_equilibria(robot, [2.59, 0.55], starts=60)]
    alone, real = (
        min(found, key=lambda each, place=place: np.linalg.norm(each.platform_position - place))
        for place in places
    )
    with pytest.raises(NoForwardSolution, match=r"comes to another equilibrium, 0\.38 rod lengths"):
        solve_continuous(alone)
    rods = solve_continuous(real)
    assert_allclose(rods.platform_position, real.platform_position, atol=1e-3)
