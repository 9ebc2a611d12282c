# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A node of every shipped robot whose legs are chains: services, setpoints, markers."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveInverse
from helpers.driver import Driver
from helpers.node_process import running_node
from helpers.shipped_steps import CHAINS, REDUNDANT, STEPS
from visualization_msgs.msg import MarkerArray

from cpr_core import leg_shapes, load_robot, solve_forward, solve_home
from cpr_ros.messages.equilibrium_messages import platform_pose
from cpr_ros.messages.frames import Frames


@pytest.fixture(params=CHAINS, scope="module")
def running(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    with running_node(folder, f"robot:={request.param}", "max_speed:=4.0") as node:
        yield load_robot(request.param), node


def test_forward_is_that_of_the_library_and_setpoints_are_followed(running):
    robot, node = running
    wanted = (solve_home(robot).motors + 0.5 * np.array(STEPS[robot.description.name])).tolist()
    expected = solve_forward(robot, wanted)
    markers = []
    subscription = node.client.node.create_subscription(
        MarkerArray, "/cpr_node/leg_markers", markers.append, 10
    )
    driver = Driver(node.client)
    try:
        answer = driver.forward(*wanted)
        assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
        point = answer.solution.platform_in_base.position
        np.testing.assert_allclose(
            [point.x, point.y, point.z], expected.platform_position, atol=1e-10
        )
        driver.send_motors(*wanted)
        # Topics come one by one: the pose of a tick after its joints, markers when it is their turn.
        driver.until(lambda: np.array_equal(driver.motors, wanted))
        position = expected.platform_position
        driver.until(lambda: np.allclose(driver.position, position, rtol=0.0, atol=1e-9))
        tips = [
            position + expected.platform_rotation @ leg.joint.position
            for leg in robot.description.legs
        ]
        ends = [
            shape.position[shape.rod == rod][-1]
            for shape in leg_shapes(expected)
            for rod in range(shape.rod.max() + 1)
        ]
        node.client.spin_until(
            lambda: markers and np.allclose(_ends(markers[-1]), ends, rtol=0.0, atol=1e-6)
        )
        assert all(_reaches(markers[-1], tip) for tip in tips)
    finally:
        driver.close()
        node.client.node.destroy_subscription(subscription)


@pytest.mark.parametrize("running", sorted(set(CHAINS) - set(REDUNDANT)), indirect=True)
def test_inverse_and_platform_setpoints_lead_back_to_the_motors(running):
    robot, node = running
    home = solve_home(robot).motors
    target = solve_forward(robot, home + 0.5 * np.array(STEPS[robot.description.name]))
    pose = platform_pose(target, Frames("base", "platform"), Time())
    request = SolveInverse.Request(platform=pose, start=SolveInverse.Request.START_HOME)
    driver = Driver(node.client)
    try:
        answer = node.client.call(SolveInverse, "/cpr_node/solve_inverse", request)
        assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message
        np.testing.assert_allclose(answer.solution.motors.position, target.motors, atol=1e-8)
        driver.send_motors(*home)
        driver.until(lambda: np.array_equal(driver.motors, home))
        driver.platform.publish(pose)
        driver.until(lambda: np.allclose(driver.motors, target.motors, rtol=0.0, atol=1e-8))
    finally:
        driver.close()


def _ends(message):
    """Where the lines of the rods end, (R, 3)."""
    ends = [marker.points[-1] for marker in message.markers if marker.ns == "legs"]
    return np.array([[end.x, end.y, end.z] for end in ends])


def _reaches(message, tip):
    """Whether a rod, or a link behind it, ends at a tip, (3,)."""
    links = [point for marker in message.markers if marker.ns == "links" for point in marker.points]
    ends = [*_ends(message), *([point.x, point.y, point.z] for point in links)]
    return np.abs(np.array(ends) - tip).max(axis=1).min() < 1e-6
