# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Kinemato-statics, prediction and stability services, called from another process."""

import math

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict, SolveForward
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

import cpr_core

NAMES = [f"motor{k}" for k in range(1, 7)]
MOTORS = np.array([5.86, 5.56, 5.86, 5.46, 5.86, 5.26]) + [0.2, -0.1, 0.15, 0.1, -0.2, 0.05]


@pytest.fixture(scope="module")
def given(six_rfs):
    """An equilibrium off home: as the node answered it, and in the library."""
    answer = six_rfs.client.call(
        SolveForward,
        "/cpr_node/solve_forward",
        SolveForward.Request(motors=JointState(name=NAMES, position=MOTORS.tolist())),
    )
    assert answer.error_code.val == ErrorCode.SUCCESS
    return answer.solution, cpr_core.solve_forward(cpr_core.load_robot("six_rfs"), MOTORS)


def ask(running, kind, name, **fields):
    return running.client.call(kind, f"/cpr_node/{name}", kind.Request(**fields))


def linear_first(matrix):
    return matrix[[3, 4, 5, 0, 1, 2]]


def test_matrices_are_those_of_the_library_with_linear_parts_first(six_rfs, given):
    message, equilibrium = given
    answer = ask(
        six_rfs,
        GetKinematoStatics,
        "get_kinemato_statics",
        at=GetKinematoStatics.Request.AT_GIVEN,
        equilibrium=[message],
    )
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
    model = cpr_core.kinemato_statics(equilibrium)
    assert list(answer.motor_names) == NAMES

    def matrix(field, *shape):
        return np.reshape(getattr(answer, field), shape)

    close = {"rtol": 1e-6, "atol": 1e-9}
    np.testing.assert_allclose(matrix("jacobian", 6, 6), linear_first(model.jacobian), **close)
    np.testing.assert_allclose(matrix("efforts_by_motors", 6, 6), model.efforts_by_motors, **close)
    np.testing.assert_allclose(
        matrix("efforts_by_wrench", 6, 6), linear_first(model.efforts_by_wrench.T).T, **close
    )
    compliance = linear_first(linear_first(model.compliance()).T).T
    np.testing.assert_allclose(matrix("compliance", 6, 6), compliance, **close)
    np.testing.assert_allclose(
        matrix("stiffness", 6, 6) @ matrix("compliance", 6, 6), np.eye(6), atol=1e-8
    )
    for problem in ("forward", "inverse", "inverse_by_effort"):
        expected, found = model.singularity(problem), getattr(answer, problem)
        assert found.smallest_singular_value == pytest.approx(expected.smallest, rel=1e-6)
        assert found.sign == expected.sign


def test_a_planar_platform_has_zeros_for_what_it_cannot_do(rfrfr):
    answer = ask(rfrfr, GetKinematoStatics, "get_kinemato_statics")
    assert answer.error_code.val == ErrorCode.SUCCESS
    jacobian = np.reshape(answer.jacobian, (6, 2))
    assert np.all(jacobian[:2] != 0.0)
    np.testing.assert_array_equal(jacobian[2:], 0.0)
    np.testing.assert_array_equal(np.reshape(answer.stiffness, (6, 6))[2:], 0.0)


def test_prediction_forward_and_back(six_rfs, given):
    message, equilibrium = given
    step = 1e-3 * np.arange(1.0, 7.0)
    at = {"at": Predict.Request.AT_GIVEN, "equilibrium": [message]}
    forward = ask(six_rfs, Predict, "predict", motor_increments=step.tolist(), **at)
    assert forward.error_code.val == ErrorCode.SUCCESS
    moved = cpr_core.solve_forward(equilibrium.robot, MOTORS + step, start=equilibrium)
    shift = equilibrium.platform_rotation.T @ (
        moved.platform_position - equilibrium.platform_position
    )
    linear = forward.platform_increment.linear
    np.testing.assert_allclose([linear.x, linear.y, linear.z], shift, atol=2e-5)
    np.testing.assert_allclose(
        forward.effort_increments, moved.efforts - equilibrium.efforts, atol=2e-5
    )
    back = ask(
        six_rfs,
        Predict,
        "predict",
        problem=Predict.Request.INVERSE,
        platform_increment=forward.platform_increment,
        **at,
    )
    assert back.error_code.val == ErrorCode.SUCCESS
    np.testing.assert_allclose(back.motor_increments, step, rtol=1e-6)


def test_under_a_load_without_potential_stability_is_not_told(six_rfs):
    pushed = WrenchStamped(header=Header(frame_id="platform"))
    pushed.wrench.force.x = 0.02
    motors = JointState(name=NAMES, position=MOTORS.tolist())
    found = ask(six_rfs, SolveForward, "solve_forward", motors=motors, wrench=[pushed])
    assert found.error_code.val == ErrorCode.SUCCESS, found.error_code.message
    at = CheckStability.Request.AT_GIVEN
    answer = ask(six_rfs, CheckStability, "check_stability", at=at, equilibrium=[found.solution])
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
    assert not answer.energy_criterion_applies and not answer.stable


@pytest.mark.parametrize("motors_are", ["locked", "free"])
def test_stability_is_that_of_the_library(six_rfs, given, motors_are):
    message, equilibrium = given
    answer = ask(
        six_rfs,
        CheckStability,
        "check_stability",
        motors_are=["locked", "free"].index(motors_are),
        at=CheckStability.Request.AT_GIVEN,
        equilibrium=[message],
    )
    assert answer.error_code.val == ErrorCode.SUCCESS
    expected = cpr_core.spectrum(equilibrium, motors_are)
    assert answer.index == expected.index
    assert answer.stable is (expected.index == 0)
    np.testing.assert_allclose(answer.eigenvalues, expected.eigenvalues[:6], rtol=1e-6)
    assert answer.margin == pytest.approx(expected.margin, rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "name", "fields", "code"),
    [
        (CheckStability, "check_stability", {"at": 9}, ErrorCode.INVALID_ROBOT_STATE),
        (CheckStability, "check_stability", {"motors_are": 5}, ErrorCode.INVALID_ROBOT_STATE),
        (CheckStability, "check_stability", {"at": 2}, ErrorCode.INVALID_ROBOT_STATE),
        (Predict, "predict", {"problem": 4}, ErrorCode.INVALID_ROBOT_STATE),
        (Predict, "predict", {"motor_increments": [1.0]}, ErrorCode.INVALID_ROBOT_STATE),
        (
            Predict,
            "predict",
            {"motor_increments": [math.nan, 0.0]},
            ErrorCode.NON_FINITE_INPUT,
        ),
        (
            GetKinematoStatics,
            "get_kinemato_statics",
            {"characteristic_length": 1e300},
            ErrorCode.INVALID_ROBOT_STATE,
        ),
        (
            GetKinematoStatics,
            "get_kinemato_statics",
            {"motor_stiffness": [1.0, 2.0, 3.0]},
            ErrorCode.INVALID_ROBOT_STATE,
        ),
        (
            GetKinematoStatics,
            "get_kinemato_statics",
            {"motor_stiffness": [1.0, -2.0]},
            ErrorCode.INVALID_ROBOT_STATE,
        ),
        (
            GetKinematoStatics,
            "get_kinemato_statics",
            {"characteristic_length": -1.0},
            ErrorCode.INVALID_ROBOT_STATE,
        ),
        (
            GetKinematoStatics,
            "get_kinemato_statics",
            {"characteristic_length": math.nan},
            ErrorCode.NON_FINITE_INPUT,
        ),
    ],
)
def test_bad_questions_are_refused_with_a_reason(rfrfr, kind, name, fields, code):
    answer = ask(rfrfr, kind, name, **fields)
    assert answer.error_code.val == code, answer.error_code.message
    assert answer.error_code.message
    assert getattr(answer, "index", -1) == -1  # 0 would be stable
    assert math.isnan(getattr(answer, "margin", math.nan))  # 0 would be critical
    assert ask(rfrfr, CheckStability, "check_stability").error_code.val == ErrorCode.SUCCESS
