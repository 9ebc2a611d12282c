# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What has to come in time, takes all that the machine can do, or measures how far the robot lags."""

import math
import os
import re
import subprocess
import sys
import time
from itertools import pairwise

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveInverse
from geometry_msgs.msg import WrenchStamped
from helpers.driver import Driver, pose_at
from helpers.example_process import started_example
from helpers.node_process import TIMEOUT
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

import cpr_core
from cpr_core import solve_home

pytestmark = pytest.mark.alone(reason="other nodes would take the time that messages have")

HOME = [2.59, 0.55]


def following(drive):
    """What was told on the way."""
    told = drive.all(StabilityMetrics)
    return [metrics for metrics in told if metrics.state == metrics.STATE_FOLLOWING]


def test_trend_and_age_tell_of_motion(drive):
    drive.set_parameters(max_speed=1.0)
    try:
        drive.send_platform(0.0, 0.3)
        drive.client.spin_until(lambda: len(following(drive)) > 5)
        moving = following(drive)
        for before, after in pairwise(moving):
            assert after.margin < before.margin
            assert after.margin_trend < 0.0
            assert after.setpoint_age > before.setpoint_age >= 0.0
    finally:
        drive.set_parameters(max_speed=4.0)


def send_wrench(drive, fx, fy, frame=""):
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.force.x, message.wrench.force.y = float(fx), float(fy)
    drive.wrench.publish(message)


@pytest.mark.parametrize("frame", ["", "base", "platform"])
def test_an_external_wrench_acts_and_ends_with_its_timeout(drive, frame):
    robot = cpr_core.load_robot("rfrfr")
    field = "wrench_body" if frame == "platform" else "wrench_world"
    pushed = robot.default_loads.with_(**{field: [0, 0, 0, 0.2, -0.3, 0]})
    expected = cpr_core.solve_forward(
        robot, solve_home(robot).motors, loads=pushed
    ).platform_position
    assert drive.set_parameters(
        wrench_timeout=600.0
    ).successful  # not while this process is held up
    for _ in range(30):
        send_wrench(drive, 0.2, -0.3, frame)
        drive.spin(0.03)
    drive.until(lambda: np.allclose(drive.position, expected, atol=1e-9))
    assert drive.metrics.wrench_age >= 0.0
    assert drive.metrics.energy_criterion_applies  # a point does not turn: nothing follows it
    assert drive.set_parameters(wrench_timeout=0.5).successful
    home = solve_home(robot).platform_position
    drive.until(lambda: np.allclose(drive.position, home, atol=1e-9), timeout=5.0)
    drive.until(lambda: True)
    assert drive.metrics.wrench_age == -1.0


def test_a_bad_message_does_not_feed_the_watchdog_of_a_good_one(drive):
    assert drive.set_parameters(setpoint_timeout=0.3).successful
    try:
        drive.send_platform(0.0, -0.2)
        drive.client.spin_until(lambda: following(drive))
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            drive.platform.publish(pose_at(math.nan, 0.0))
            drive.spin(0.02)
        drive.until(lambda: True)
        assert drive.metrics.state == StabilityMetrics.STATE_STALE
        assert drive.metrics.status == StabilityMetrics.STATUS_STALE_COMMAND
        assert drive.metrics.setpoint_age > 0.9
    finally:
        assert drive.set_parameters(setpoint_timeout=0.0).successful


def test_a_timeout_below_a_second_is_kept(drive):
    def stale():
        told = drive.all(StabilityMetrics)
        return [metrics for metrics in told if metrics.state == StabilityMetrics.STATE_STALE]

    assert drive.set_parameters(setpoint_timeout=0.2, max_speed=0.05).successful
    try:
        drive.forget()
        drive.send_motors(2.9, 0.55)
        drive.client.spin_until(stale, timeout=5.0)
        drive.catch_up(stale()[0])
        held = drive.motors
        assert stale()[0].setpoint_age > 0.2
        farthest = 0.05 * (0.2 + 1 / 200)  # with no tick late
        assert HOME[0] < held[0] <= HOME[0] + farthest + 1e-12
        drive.spin(0.3)
        np.testing.assert_array_equal(drive.motors, held)
    finally:
        assert drive.set_parameters(setpoint_timeout=0.0, max_speed=4.0).successful


def test_a_motor_stops_whose_controller_is_gone_while_another_one_goes_on(drive):
    assert drive.set_parameters(setpoint_timeout=0.2, max_speed=0.05).successful
    try:
        drive.send_motors(HOME[0] + 0.3, names=["motor1"])
        end = time.monotonic() + 1.5
        while time.monotonic() < end:
            drive.send_motors(HOME[1], names=["motor2"])
            drive.spin(0.02)
        drive.until(lambda: True)
        held = drive.motors
        assert HOME[0] < held[0] < HOME[0] + 0.05 * 1.0  # it had a second more to go on
        drive.spin(0.3)
        np.testing.assert_array_equal(drive.motors, held)
    finally:
        assert drive.set_parameters(setpoint_timeout=0.0, max_speed=4.0).successful


FLOOD = """
import cpr_ros, rclpy, time
from sensor_msgs.msg import JointState
rclpy.init()
node = rclpy.create_node("flood")
publisher = node.create_publisher(JointState, "/cpr_node/motor_setpoint", 10)
while not publisher.get_subscription_count():
    time.sleep(0.01)
begin = time.perf_counter()
message = JointState(name=["motor1", "motor2"], position=[2.6, 0.5])
for k in range(10_000):
    message.position[0] = 2.6 + 1e-6 * (k % 50)
    publisher.publish(message)
    while time.perf_counter() - begin < k / 5000:
        pass
message.position[0] = 2.64
publisher.publish(message)
assert publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=10))
rclpy.shutdown()
"""


def test_a_flood_of_setpoints_at_5_khz(rfrfr, drive):
    """Two seconds, from a process of its own; the last one wins and services answer meanwhile."""
    flood = subprocess.Popen(
        [sys.executable, "-c", FLOOD],
        env=os.environ | {"ROS_DOMAIN_ID": str(rfrfr.client.context.get_domain_id())},
    )
    answers = 0
    while flood.poll() is None:
        assert drive.forward(*HOME).error_code.val == ErrorCode.SUCCESS
        answers += 1
    assert flood.returncode == 0
    assert answers > 10
    states = list(drive.all(JointState))  # those of the flood; waiting forgets them
    drive.until(lambda: np.array_equal(drive.motors, [2.64, 0.5]))
    stamps = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in states]
    assert len(stamps) > 10
    assert np.all(np.diff(stamps) > 0.0)


def test_a_burst_of_a_thousand_parallel_calls(drive):
    client = drive.client.node.create_client(
        SolveInverse, "/cpr_node/solve_inverse", qos_profile=QoSProfile(depth=1000)
    )
    assert client.wait_for_service(TIMEOUT)
    requests = [
        SolveInverse.Request(platform=pose_at(0.0, 0.8), start=SolveInverse.Request.START_HOME)
        for _ in range(1000)
    ]
    futures = [client.call_async(request) for request in requests]
    drive.client.spin_until(lambda: all(future.done() for future in futures), timeout=120.0)
    answers = [future.result() for future in futures]
    assert all(answer.error_code.val == ErrorCode.SUCCESS for answer in answers)
    # Motion went on meanwhile: the ticks are not behind the requests in any line.
    drive.send_motors(2.6, 0.5)
    drive.until(lambda: np.array_equal(drive.motors, [2.6, 0.5]))


def test_the_circle_is_driven(six_rfs):
    drive = Driver(six_rfs.client)
    try:
        drive.until(lambda: True)
        first = drive.position
        circle = started_example(six_rfs.client, "circle.py", "--radius", "0.03", "--period", "4")
        drive.client.spin_until(lambda: circle.poll() is not None, timeout=60.0)
        said = circle.stdout.read()
        assert circle.returncode == 0, said
        away = float(re.search(r"setpoint: ([\d.]+) mm", said)[1])
        assert away < 10.0
        drive.until_state(StabilityMetrics.STATE_IDLE)
        poses = [
            [pose.pose.position.x, pose.pose.position.y, pose.pose.position.z]
            for kind, messages in drive.outputs.items()
            if kind.__name__ == "PoseStamped"
            for pose in messages
        ]
        drive.go_home()
    finally:
        drive.close()
    assert poses
    assert np.linalg.norm(np.array(poses)[-1] - first) < 0.01
