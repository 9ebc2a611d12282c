# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods that motors feed through rollers or by screws, from another zero than that of their length."""

import numpy as np
import pytest
import yaml
from helpers.chain_robots import as_chains
from helpers.differences import check_residual, check_tangent
from helpers.fed_robots import RATIOS, fed, motors_of, plain_content

from cpr_core import (
    CalibrationWarning,
    DescriptionError,
    InvalidRequest,
    Loads,
    Measurement,
    NotReached,
    StandardDeviations,
    calibrate,
    continued,
    derivatives,
    error_of,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace,
)
from cpr_core.reference.continuous_rods import solve_continuous


@pytest.fixture(scope="module")
def plain():
    return load_robot("gough_stewart")


@pytest.fixture(scope="module", params=["short", "chain"])
def robot(request):
    short = request.param == "short"
    return load_robot(fed(plain_content() if short else as_chains("gough_stewart", links=False)))


ONE_FED_LEG = """
name: feed
space: planar
gravity: [0, -9.81, 0]
platform: {shape: body, mass: 0.1}
strain: {bending_3: 5}
rod:
  length: 0.3
  section: {shape: circular, radius: 0.001}
  young_modulus: 2.1e+11
  shear_modulus: 8.0e+10
legs:
- base: {position: [0, 0, 0], tangent: [1, 0, 0]}
  motor: {type: extensible}
  tip: {type: fixed, position: [0, 0, 0], tangent: [1, 0, 0]}
controlled: [x]
home: {motors: [0.3], bow: left}
"""

FAR = np.array([0.05, -0.04, 0.02, 0.05, -0.03, 0.04])


def test_lengths_are_those_of_the_rods_and_motors_turn(plain, robot):
    assert {(each.unit, each.moves) for each in robot.description.motors} == {("rad", "m")}
    lengths = solve_home(plain).motors + FAR
    expected, found = solve_forward(plain, lengths), solve_forward(robot, motors_of(lengths))
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=1e-9)
    np.testing.assert_allclose(found.platform_rotation, expected.platform_rotation, atol=1e-9)
    np.testing.assert_allclose(found.efforts, expected.efforts * RATIOS, atol=1e-9)
    assert found.margin == pytest.approx(expected.margin, abs=1e-9)
    shapes = [each[0].arc_length[-1] for each in (leg_shapes(found), leg_shapes(expected))]
    assert shapes[0] == pytest.approx(shapes[1]) == pytest.approx(lengths[0])
    pose = solve_forward(plain, solve_home(plain).motors + 0.3 * FAR).pose
    back = solve_inverse(plain, pose).motors
    np.testing.assert_allclose(solve_inverse(robot, pose).motors, motors_of(back), atol=1e-6)


def test_its_equations_are_derivatives(robot):
    check_residual(robot, Loads.none().with_(gravity=[0.3, -0.2, -9.81]))
    check_tangent(robot, Loads.none().with_(gravity=[0.3, -0.2, -9.81]))


def test_elastic_energy_is_measured_as_without_rollers(plain, robot):
    """Eigenvalues in which displacements count by the elastic energy they store."""
    lengths = solve_home(plain).motors + FAR
    expected, found = solve_forward(plain, lengths), solve_forward(robot, motors_of(lengths))
    for reading in ("locked", "free"):
        spectra = [getattr(each, f"spectrum_{reading}") for each in (found, expected)]
        assert spectra[0].margin == pytest.approx(spectra[1].margin, rel=1e-7)


def test_so_are_continuous_rods(plain, robot):
    """Another method, which knows nothing of modes: fed, bent and loaded."""
    wrench = [0.0, 0.0, 0.002, 0.1, -0.1, -0.5]
    lengths = solve_home(plain).motors + FAR
    expected, found = (
        solve_continuous(
            solve_forward(each, motors, loads=each.default_loads.with_(wrench_world=wrench))
        )
        for each, motors in ((plain, lengths), (robot, motors_of(lengths)))
    )
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=1e-9)
    np.testing.assert_allclose(found.efforts, expected.efforts * RATIOS, rtol=1e-7, atol=1e-9)


def test_offset_and_lead_are_parameters_of_which_derivatives_are_known(robot):
    paths = ["offset", "lead"]
    short = robot.description.written.content["legs"][0].get("motor") is not None
    paths = [f"legs[0].{'motor' if short else 'chain[0]'}.{name}" for name in paths]
    at = solve_forward(robot, solve_home(robot).motors + FAR / RATIOS)
    by = derivatives(at, paths, of=("pose", "motors", "efforts", "margin"))
    for column, (path, step) in enumerate(zip(paths, (1e-5, 1e-6), strict=True)):
        (value,) = robot.parameter_values(path)
        ends = [
            continued(at, robot.with_parameters({path: value + sign * step}))
            for sign in (-1.0, 1.0)
        ]
        for rates, quantity in (
            (by.position, "platform_position"),
            (by.efforts, "efforts"),
            (by.margin[None], "margin"),
        ):
            low, high = (np.atleast_1d(getattr(end, quantity)) for end in ends)
            differs = (high - low) / (2.0 * step)
            size = np.abs(differs).max()
            assert rates[:, column] == pytest.approx(differs, abs=1e-5 * size), (path, quantity)


def test_zeros_of_feeds_are_calibrated(plain):
    """There was no number for them: encoders of fed rods had to be at zero where nothing is out."""
    paths = [f"legs[{leg}].motor.offset" for leg in range(6)]
    truth = plain.with_parameters(dict(zip(paths, 0.002 * np.cos(np.arange(6)), strict=True)))
    rows, home = [], solve_home(plain)
    for seed in range(6):
        motors = home.motors + np.random.default_rng(seed).uniform(-0.05, 0.05, 6)
        at = solve_forward(truth, motors)
        rows.append(
            Measurement(motors, at.platform_position, quaternion_wxyz=at.platform_quaternion)
        )
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(plain, rows, paths, StandardDeviations(position=1e-4, rotation=1e-3))
    assert found.values == pytest.approx(0.002 * np.cos(np.arange(6)), abs=1e-8)
    assert found.undetermined == ()


def test_a_rod_that_would_be_pulled_in_is_refused(robot):
    motors = solve_home(robot).motors.copy()
    motors[1] = 0.25 / abs(RATIOS[1])  # of the one that turns the other way
    for ask in (solve_forward, lambda robot, motors: trace(robot, motors=motors)):
        with pytest.raises(
            InvalidRequest, match=r"motor2: expected a rod length above 0 m, got -0\.05"
        ):
            ask(robot, motors)


def test_states_tell_whether_rods_exist(robot):
    for lengths, exist in (([0.4] * 6, True), ([0.4, 0.4, 0.4, 0.4, -0.01, 0.4], False)):
        state = solve_home(robot).state.copy()
        state[robot.motor_indices] = motors_of(lengths)
        assert robot.rods_exist(state) is exist


def test_a_rod_without_length_does_not_exist(plain):
    assert not plain.rods_exist(np.zeros(plain.state_size))


def test_limits_and_homes_without_a_rod_are_refused():
    content = fed(plain_content())
    content["legs"][1]["motor"]["limits"] = {"position": [-10.0, 70.0]}
    with pytest.raises(
        DescriptionError, match=r"expected a positive length, got -0\.0228\S* at 70"
    ):
        load_robot(content)
    content["legs"][1]["motor"]["limits"] = {"position": [-60.0, 60.0]}
    load_robot(content)
    content["home"]["motors"][1] = 70.0
    with pytest.raises(
        DescriptionError, match=r"home\.motors: expected positive rod lengths, got -0"
    ):
        load_robot(content)


def test_limits_of_a_motor_hold_for_every_rod_it_feeds():
    """One that was fed the other way vanished within them."""
    content = as_chains("gough_stewart", links=False)
    for leg, fields in zip(content["legs"][:2], ({}, {"ratio": -0.3, "offset": 0.5}), strict=True):
        leg["chain"][0] |= {"motor": "both"} | fields
    content["legs"][0]["chain"][0]["limits"] = {"position": [0.01, 5.0]}
    content["home"]["motors"] = content["home"]["motors"][:5]
    content["controlled"] = ["x", "y", "z", "roll", "pitch"]
    problem = r"legs\[1\]\.chain: expected a positive length, got -1 at 5 of both"
    with pytest.raises(DescriptionError, match=problem):
        load_robot(content)


@pytest.mark.parametrize("field", ["offset", "ratio", "lead"])
def test_a_rod_that_nothing_feeds_has_no_roller(field):
    content = as_chains("six_rfs", links=False)
    next(element for element in content["legs"][0]["chain"] if "rod" in element)[field] = 0.5
    with pytest.raises(DescriptionError, match=rf"{field}: no motor feeds this rod"):
        load_robot(content)


def test_errors_of_modes_are_those_without_rollers(plain, robot):
    lengths = solve_home(plain).motors + FAR
    errors = [
        error_of(solve_forward(each, motors)).position
        for each, motors in ((plain, lengths), (robot, motors_of(lengths)))
    ]
    assert errors[1] == pytest.approx(errors[0], rel=1e-3)


@pytest.mark.parametrize("ratios", [(1.0, -0.3), (-0.3, 1.0), (0.3, -1.0)])
def test_what_goes_farthest_says_how_far_a_motor_of_several_rods_goes(ratios):
    content = as_chains("gough_stewart", links=False)
    for leg, ratio in zip(content["legs"][:2], ratios, strict=True):
        leg["chain"][0] |= {"motor": "both", "ratio": ratio, "offset": 0.2 if ratio > 0.0 else 0.5}
    content["home"]["motors"] = content["home"]["motors"][:5]
    content["controlled"] = ["x", "y", "z", "roll", "pitch"]
    robot = load_robot(content)
    assert robot.motor_units[0] == pytest.approx(robot.mean_length)
    assert robot.description.motors[0].ratio == max(ratios, key=abs)


def test_a_rod_that_is_drawn_in_altogether_is_named():
    """By effort the way ended where branches cross, at a length that was not its end."""
    home = solve_home(load_robot(yaml.safe_load(ONE_FED_LEG)))
    robot = home.robot
    for solve in (
        lambda: solve_inverse(robot, [-0.1]),
        lambda: solve_forward_by_effort(robot, [5.0]),
    ):
        with pytest.raises(
            NotReached, match="motor1 has drawn in its rod: no length is left"
        ) as end:
            solve()
        assert end.value.event.kind == "lost"
        assert 0.0 < end.value.last.motors[0] < 1e-6
    assert robot.fed_rods.drawn_in(home.motors) == ""
