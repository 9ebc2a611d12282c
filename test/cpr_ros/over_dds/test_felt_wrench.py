# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot that measures efforts at 200 Hz under a changing wrench: what the node tells, and when."""

import time

import numpy as np
import pytest
from cpr_msgs.msg import WrenchEstimate
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, WrenchStamped
from helpers.driver import EVERY_MESSAGE, set_parameters
from helpers.node_process import running_node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from cpr_core import load_robot, solve_forward, solve_home

PERIOD = 0.005


class MeasuredRobot:
    """A simulated robot that publishes what it measures, and hears what the node makes of it."""

    def __init__(self, client):
        self.client, node = client, client.node
        self.robot = load_robot("six_rfs")
        self.true = solve_home(self.robot)
        self.published, self.estimates, self.wrenches, self.diagnostics = {}, [], [], []
        self.joints = node.create_publisher(
            JointState, "/measured_joint_states", qos_profile_sensor_data
        )
        self.pose = node.create_publisher(
            PoseStamped, "/cpr_node/measured_platform_pose", qos_profile_sensor_data
        )
        for kind, topic, take in (
            (WrenchEstimate, "/cpr_node/wrench_estimate", self._take),
            (WrenchStamped, "/cpr_node/estimated_wrench", self.wrenches.append),
            (DiagnosticArray, "/diagnostics", self.diagnostics.append),
        ):
            node.create_subscription(kind, topic, take, EVERY_MESSAGE)
        client.spin_until(
            lambda: (
                self.joints.get_subscription_count()
                and self.pose.get_subscription_count()
                and node.count_publishers("/cpr_node/wrench_estimate")
                and node.count_publishers("/cpr_node/estimated_wrench")
                and self.diagnostics
            )
        )

    def _take(self, message):
        self.estimates.append((len(self.published), time.time_ns(), message))

    def push(self, wrench):
        loads = self.robot.default_loads.with_(wrench_world=wrench)
        self.true = solve_forward(self.robot, self.true.motors, start=self.true, loads=loads)

    def publish(self, wrench, efforts=None):
        """Measurements of now, stamped."""
        message = JointState(name=list(self.robot.motor_names))
        message.header.stamp = self.client.node.get_clock().now().to_msg()
        message.position = self.true.motors.tolist()
        message.effort = self.true.efforts.tolist() if efforts is None else efforts
        self.published[stamp_of(message)] = len(self.published), np.array(wrench)
        self.joints.publish(message)

    def wait(self, until):
        while (left := until - time.monotonic()) > 0.0:
            self.client.executor.spin_once(timeout_sec=left)

    def told(self):
        """What /diagnostics said last of the wrench; None: nothing."""
        statuses = self.diagnostics[-1].status if self.diagnostics else []
        return next((status for status in statuses if status.name.endswith(": wrench")), None)


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def vector(wrench):
    parts = (wrench.torque, wrench.force)
    return np.array([value for part in parts for value in (part.x, part.y, part.z)])


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    with running_node(tmp_path_factory.mktemp("felt"), "robot:=six_rfs") as running:
        yield running.process, MeasuredRobot(running.client)


def test_a_changing_wrench_is_told_of_the_time_of_its_stamp(measured):
    """The wrench of a stamp is the true one of then, not that of a sample before or after."""
    _, robot = measured
    samples = []
    for number in range(600):
        angle = 2.0 * np.pi * number * PERIOD
        wrench = 0.05 * np.array(
            [0.1 * np.sin(angle), 0.1, 0.05 * np.cos(angle), np.cos(angle), 0.5, np.sin(2 * angle)]
        )
        robot.push(wrench)
        samples.append((wrench, robot.true.efforts.tolist()))
    for wrench, efforts in samples:  # at 200 Hz or, on a busy machine, slower
        after = time.monotonic() + PERIOD
        robot.publish(wrench, efforts)
        robot.wait(after)
    robot.wait(time.monotonic() + 0.5)
    assert len(robot.estimates) > 300
    true = [wrench for _, wrench in robot.published.values()]
    numbers, behind, delays, told = [], [], [], []
    for published, received, message in robot.estimates:
        number, _ = robot.published[stamp_of(message)]
        numbers.append(number)
        behind.append(published - 1 - number)
        delays.append(1e-6 * (received - stamp_of(message)))
        told.append(vector(message.wrench))
        assert (message.felt, message.coordinates, message.with_pose) == (6, 6, False)
        assert message.header.frame_id == "base" and message.words == "all of the wrench is felt"
    numbers, told = np.array(numbers), np.array(told)
    shifts = {}
    for shift in (-2, -1, 0, 1, 2):
        inside = (numbers + shift >= 0) & (numbers + shift < len(true))
        off = told[inside] - np.array(true)[numbers[inside] + shift]
        shifts[shift] = np.abs(off).max()
    solve = 1e3 * np.median([message.solve_time for _, _, message in robot.estimates])
    print(
        f"\nlag: {np.median(behind):g} samples, 95 % below {np.percentile(behind, 95):g}; "
        f"{np.median(delays):.2f} ms from measurement to receipt, solved in {solve:.2f} ms; "
        f"{len(told)} of {len(true)} told, errors up to {shifts[0]:.1e} N"
    )
    assert shifts[0] < 1e-8
    assert min(shifts[-1], shifts[1]) > 1e-3
    # Whoever reads the other topic reads the same.
    same = {stamp_of(message): vector(message.wrench) for message in robot.wrenches}
    both = [n for n, (_, _, message) in enumerate(robot.estimates) if stamp_of(message) in same]
    assert len(both) > 300
    for n in both:
        np.testing.assert_array_equal(told[n], same[stamp_of(robot.estimates[n][2])])


def test_a_measured_pose_is_taken_with_the_efforts(measured):
    _, robot = measured
    robot.push(np.zeros(6))
    robot.estimates.clear()
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        pose = PoseStamped()
        pose.header.stamp = robot.client.node.get_clock().now().to_msg()
        point, turn = pose.pose.position, pose.pose.orientation
        point.x, point.y, point.z = robot.true.platform_position.tolist()
        turn.w, turn.x, turn.y, turn.z = robot.true.platform_quaternion.tolist()
        robot.pose.publish(pose)
        robot.publish(np.zeros(6))
        robot.wait(time.monotonic() + PERIOD)
        if any(message.with_pose for _, _, message in robot.estimates):
            break
    message = next(message for _, _, message in robot.estimates if message.with_pose)
    assert message.degrees_of_freedom == 6 and message.chi_square < 1e-6
    assert np.abs(vector(message.wrench)).max() < 1e-8


@pytest.mark.parametrize(
    ("efforts", "reason"),
    [
        ([], "measured_joint_states has no efforts"),
        ([np.nan] * 6, "all finite, got [nan"),
        ([1.0, 2.0], "expected 6 numbers, got 2"),
        ("thousandfold", "N mm?"),
        ("negated", "efforts look like those with the other sign"),
        (None, "s old, more than measured_timeout"),
    ],
)
def test_it_is_silent_where_it_cannot_be_trusted_and_says_why(measured, efforts, reason):
    process, robot = measured
    robot.push(np.zeros(6))
    # Efforts are old where that is the reason, not where this process, which measures, is held up.
    timeout = 0.5 if efforts is None else 600.0
    assert set_parameters(robot.client, "/cpr_node", measured_timeout=timeout).successful

    def measure(given, done):
        end = time.monotonic() + 30.0
        while time.monotonic() < end and not done():
            if given is not False:
                robot.publish(np.zeros(6), given)
            robot.wait(time.monotonic() + PERIOD)
        assert done(), (robot.told(), process.output()[-2000:])

    def said():
        lines = process.output().splitlines()
        return sum("no wrench is estimated" in line and reason in line for line in lines)

    robot.estimates.clear()
    measure(
        None,
        lambda: robot.estimates and robot.told() and robot.told().level == DiagnosticStatus.OK,
    )
    said_before = said()
    if isinstance(efforts, str):
        factor = {"thousandfold": 1000.0, "negated": -1.0}[efforts]
        efforts = (factor * robot.true.efforts).tolist()
    given = False if efforts is None else efforts
    measure(given, lambda: reason in robot.told().message)
    assert robot.told().level == DiagnosticStatus.WARN
    # From here on nothing is told; what was on its way has come.
    robot.wait(time.monotonic() + 0.2)
    robot.estimates.clear(), robot.wrenches.clear()
    seen = len(robot.diagnostics)
    measure(given, lambda: len(robot.diagnostics) > seen)
    assert robot.estimates == [] and robot.wrenches == []
    assert said() - said_before == 1, process.output()
