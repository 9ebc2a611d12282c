# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A node of a robot with more motors than controlled coordinates."""

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import GetKinematoStatics, SolveInverse
from geometry_msgs.msg import PoseStamped
from helpers.driver import Driver
from helpers.map_client import MapClient

from cpr_core import kinemato_statics, load_robot, solve_home, solve_inverse

POSE = np.array([-0.04, 0.02, 0.05])


@pytest.fixture(scope="module")
def robot():
    return load_robot("four_rfr")


def platform(x, y, angle):
    message = PoseStamped()
    message.pose.position.x, message.pose.position.y = float(x), float(y)
    message.pose.orientation.z = float(np.sin(0.5 * angle))
    message.pose.orientation.w = float(np.cos(0.5 * angle))
    return message


def inverse(four_rfr, objective):
    request = SolveInverse.Request(
        platform=platform(*POSE), start=SolveInverse.Request.START_HOME, objective=objective
    )
    return four_rfr.client.call(SolveInverse, "/cpr_node/solve_inverse", request)


@pytest.mark.parametrize("objective", ["", "least_motion", "least_effort", "greatest_margin"])
def test_the_inverse_is_that_of_the_library_and_names_its_objective(four_rfr, robot, objective):
    answer = inverse(four_rfr, objective)
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
    assert answer.objective == (objective or "least_motion")
    expected = solve_inverse(robot, POSE, objective=objective or None)
    # The top of the margin is found to what its differences tell.
    error = 1e-5 if objective == "greatest_margin" else 1e-9
    np.testing.assert_allclose(
        answer.solution.motors.position, expected.motors, rtol=0.0, atol=error
    )


def test_another_objective_is_refused_by_name(four_rfr):
    answer = inverse(four_rfr, "least_noise")
    assert answer.error_code.val == ErrorCode.INVALID_ROBOT_STATE
    assert "expected least_motion, least_effort or greatest_margin" in answer.error_code.message


def test_kinemato_statics_are_there(four_rfr, robot):
    request = GetKinematoStatics.Request(at=GetKinematoStatics.Request.AT_HOME)
    answer = four_rfr.client.call(GetKinematoStatics, "/cpr_node/get_kinemato_statics", request)
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
    expected = kinemato_statics(solve_home(robot)).singularity("inverse")
    assert answer.inverse.smallest_singular_value == pytest.approx(expected.smallest, rel=1e-9)
    assert answer.inverse.sign == 0


def test_platform_setpoints_are_followed(four_rfr, robot):
    driver = Driver(four_rfr.client)
    try:
        driver.go_home()
        driver.platform.publish(platform(*POSE))
        driver.until(lambda: np.allclose(driver.position[:2], POSE[:2], rtol=0.0, atol=1e-9))
        driver.until_state(StabilityMetrics.STATE_IDLE)
        expected = solve_inverse(robot, POSE)
        # Least motion from tick to tick is nearly that of the whole way.
        np.testing.assert_allclose(driver.motors, expected.motors, rtol=0.0, atol=2e-3)
        assert driver.metrics.index_locked == 0
    finally:
        driver.close()


def test_a_map_of_poses_is_made(four_rfr, tmp_path):
    client = MapClient(four_rfr.client)
    try:
        axes = {"x": (-0.02, 0.02, 0.02), "y": (-0.02, 0.02, 0.02)}
        _, result = client.make(tmp_path / "map.nc", axes, objective="least_effort")
        assert result.error_code.val == ErrorCode.SUCCESS, result.error_code.message
        assert result.complete and result.reached == result.cells == 9
    finally:
        client.close()
