# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The action that says when the robot is there, or why not."""

import math

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from geometry_msgs.msg import PoseStamped, WrenchStamped
from helpers.driver import Driver
from helpers.goal_client import GoalClient
from helpers.node_process import TIMEOUT, change, running_node
from lifecycle_msgs.msg import Transition
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

import cpr_core

HOME = [2.59, 0.55]
DEGREES = "looks like degrees, expected radians"
MILLIMETRES = "looks like millimetres, expected metres"
SUCCEEDED, ABORTED, CANCELED = (
    GoalStatus.STATUS_SUCCEEDED,
    GoalStatus.STATUS_ABORTED,
    GoalStatus.STATUS_CANCELED,
)


class MoveClient(GoalClient):
    """A client of ``~/move_to``."""

    def __init__(self, client):
        super().__init__(client, MoveTo, "/cpr_node/move_to")

    def send(self, **fields):
        return super().send(**({"patience": 1.0} | fields))

    def result(self, handle):
        """Status and result."""
        done = super().result(handle)
        return done.status, done.result

    def move(self, **fields):
        return self.result(self.send(**fields))


@pytest.fixture
def moves(drive):
    client = MoveClient(drive.client)
    yield client
    client.close()


def motors(*positions, names=("motor1", "motor2")):
    state = JointState(name=list(names), position=[float(value) for value in positions])
    return {"given": MoveTo.Goal.GIVEN_MOTORS, "motors": state}


def platform(x, y, **parts):
    pose = PoseStamped()
    pose.pose.position.x, pose.pose.position.y = float(x), float(y)
    pose.header.frame_id = parts.get("frame", "")
    return {"given": MoveTo.Goal.GIVEN_POSE, "platform": pose}


def slowly(drive, speed=0.5):
    assert drive.set_parameters(max_speed=speed).successful


@pytest.fixture
def slow(drive):
    """A robot that is on its way long enough to be met there."""
    slowly(drive)
    yield drive
    slowly(drive, 4.0)


@pytest.fixture
def crawling(drive):
    """A robot that is on its way for most of a minute, however late this process is."""
    slowly(drive, 0.02)
    yield drive
    slowly(drive, 4.0)


def test_motors_and_poses_are_reached_and_said_to_be(drive, moves):
    status, result = moves.move(**motors(2.9, 0.2))
    assert (status, result.error_code.val) == (SUCCEEDED, ErrorCode.SUCCESS)
    assert result.error_code.message == ""
    assert result.remaining == 0.0
    np.testing.assert_array_equal(result.reached.motors.position, [2.9, 0.2])
    expected = cpr_core.solve_forward(cpr_core.load_robot("rfrfr"), [2.9, 0.2])
    assert result.reached.margin == pytest.approx(expected.margin, rel=1e-6)
    drive.until(lambda: np.array_equal(drive.motors, [2.9, 0.2]))
    # Motors that are not named stay where they are.
    status, result = moves.move(**motors(0.4, names=["motor2"]))
    assert status == SUCCEEDED
    np.testing.assert_array_equal(result.reached.motors.position, [2.9, 0.4])
    status, result = moves.move(**platform(0.1, 0.7))
    assert status == SUCCEEDED
    point = result.reached.platform_in_base.position
    np.testing.assert_allclose([point.x, point.y], [0.1, 0.7], atol=1e-8)
    # There already.
    status, result = moves.move(**platform(0.1, 0.7))
    assert (status, result.remaining) == (SUCCEEDED, 0.0)


def test_feedback_tells_of_the_way(slow, moves):
    status, _ = moves.move(**motors(3.09, 0.05))
    assert status == SUCCEEDED
    remaining = [feedback.remaining for feedback in moves.feedback]
    assert len(remaining) > 1
    assert remaining == sorted(remaining, reverse=True)
    assert 0.0 < remaining[-1] < remaining[0] <= 0.5
    assert all(feedback.margin > 0.2 for feedback in moves.feedback)
    assert all(feedback.action == StabilityMetrics.ACTION_NONE for feedback in moves.feedback)
    assert all(feedback.speed_scale == 1.0 for feedback in moves.feedback)
    assert {feedback.status_text for feedback in moves.feedback} == {"stable"}


def test_a_goal_is_not_stale_when_setpoints_would_be(slow, moves):
    assert slow.set_parameters(setpoint_timeout=0.05).successful
    try:
        status, result = moves.move(**motors(2.79, 0.35))
    finally:
        assert slow.set_parameters(setpoint_timeout=0.0).successful
    assert status == SUCCEEDED, result.error_code.message


def test_a_goal_behind_an_instability_is_given_up_with_the_reason(drive, moves):
    patient = moves.send(**platform(0.0, -0.2), patience=1e3)
    halt = StabilityMetrics.ACTION_HALT
    moves.client.spin_until(lambda: bool(moves.feedback) and moves.feedback[-1].action == halt)
    told = moves.feedback[-1]
    assert told.speed_scale == 0.0
    assert told.status_text.startswith("the next margin, ")
    status, result = moves.move(**platform(0.0, -0.2), patience=0.2)
    assert (status, result.error_code.val) == (ABORTED, ErrorCode.CONTROL_FAILED)
    assert result.error_code.message.startswith("halted for 0.2 s: the next margin, ")
    assert result.reached.index_locked == 0
    assert 0.05 <= result.reached.margin < 0.06
    assert result.remaining > 0.2
    assert moves.result(patient)[1].error_code.val == ErrorCode.PREEMPTED
    # It holds, and forgets where it was to go.
    drive.until_state(StabilityMetrics.STATE_IDLE)


def test_a_halted_goal_that_new_parameters_end_says_so(drive, moves):
    """It said that there was another motion."""
    handle = moves.send(**platform(0.0, -0.2), patience=1e3)
    drive.until_state(StabilityMetrics.STATE_HALTED)
    assert drive.set_parameters(hysteresis=0.1).successful  # as it was
    status, result = moves.result(handle)
    assert (status, result.error_code.val) == (ABORTED, ErrorCode.PREEMPTED)
    assert result.error_code.message == "parameters changed: the setpoint is forgotten"


def test_a_cancelled_goal_holds_the_robot(crawling, moves):
    slow = crawling
    handle = moves.send(**motors(3.5, -0.4))
    moves.client.spin_until(lambda: len(moves.feedback) > 2)
    assert moves.cancel(handle) == 1
    status, result = moves.result(handle)
    assert (status, result.error_code.val) == (CANCELED, ErrorCode.PREEMPTED)
    held = np.array(result.reached.motors.position)
    assert 0.0 < result.remaining == pytest.approx(np.abs(held - [3.5, -0.4]).max())
    slow.until_state(StabilityMetrics.STATE_IDLE)
    slow.until(lambda: len(slow.all(JointState)) > 20)
    assert all(np.array_equal(state.position, held) for state in slow.all(JointState))
    assert moves.cancel(handle) == 0


@pytest.mark.parametrize(
    ("interruption", "words"),
    [
        ("goal", "another goal"),
        ("setpoint", "newer motion"),
        ("pause", "paused"),
        ("stop", "an empty trajectory came: hold"),
        ("reset", "goes home"),
    ],
)
def test_the_newest_motion_counts(crawling, moves, interruption, words):
    slow = crawling
    handle = moves.send(**motors(3.5, -0.4))
    moves.client.spin_until(lambda: bool(moves.feedback))
    newer = None
    if interruption == "goal":
        newer = moves.send(**motors(2.6, 0.5))
    elif interruption == "setpoint":
        slow.send_motors(2.6, 0.5)
    elif interruption == "pause":
        assert slow.pause(True).success
    elif interruption == "stop":
        node = slow.client.node
        topic = node.create_publisher(JointTrajectory, "/cpr_node/joint_trajectory", 1)
        slow.client.spin_until(lambda: topic.get_subscription_count() > 0)
        topic.publish(JointTrajectory())
    else:
        moves.client.spin_until(lambda: moves.feedback[-1].remaining < 0.94)
        slowly(slow, 0.001)  # it is on its way home for long
        assert slow.reset().success
    status, result = moves.result(handle)
    assert (status, result.error_code.val) == (ABORTED, ErrorCode.PREEMPTED)
    assert words in result.error_code.message
    if newer is not None:
        assert moves.result(newer)[0] == SUCCEEDED
    elif interruption == "stop":
        assert node.destroy_publisher(topic)
        slow.until_state(StabilityMetrics.STATE_IDLE)
    elif interruption == "setpoint":
        slow.until(lambda: np.array_equal(slow.motors, [2.6, 0.5]))
    elif interruption == "pause":
        slow.until_state(StabilityMetrics.STATE_PAUSED)
        status, result = moves.move(**motors(2.6, 0.5))
        assert (status, result.error_code.val) == (ABORTED, ErrorCode.NOT_READY)
        assert "paused" in result.error_code.message
        assert slow.pause(False).success
    else:
        status, result = moves.move(**motors(2.6, 0.5))
        assert (status, result.error_code.val) == (ABORTED, ErrorCode.NOT_READY)
        assert "on its way home" in result.error_code.message
        slowly(slow)


@pytest.mark.parametrize(
    ("fields", "code", "words"),
    [
        (motors(math.nan, 0.5), ErrorCode.NON_FINITE_INPUT, "motors.position"),
        (motors(2.6, 0.5, names=["motor1", "x"]), ErrorCode.INVALID_ROBOT_STATE, "motors.name"),
        (motors(2.6), ErrorCode.INVALID_ROBOT_STATE, "motors.position"),
        (motors(names=[]), ErrorCode.INVALID_ROBOT_STATE, "motors.name"),
        (platform(math.inf, 0.5), ErrorCode.NON_FINITE_INPUT, "platform.pose.position"),
        (platform(0.0, 0.5, frame="x"), ErrorCode.FRAME_TRANSFORM_FAILURE, "platform.header"),
        (motors(148.4, 31.5), ErrorCode.INVALID_ROBOT_STATE, f"motor1 at 148.4 {DEGREES}"),
        (motors(31.5, names=["motor2"]), ErrorCode.INVALID_ROBOT_STATE, f"at 31.5 {DEGREES}"),
        (platform(0.0, 830.0), ErrorCode.INVALID_ROBOT_STATE, f"(0, 830, 0) {MILLIMETRES}"),
        ({"given": 7}, ErrorCode.INVALID_ROBOT_STATE, "GIVEN_MOTORS"),
        (motors(2.6, 0.5) | {"patience": -1.0}, ErrorCode.INVALID_ROBOT_STATE, "patience"),
        (motors(2.6, 0.5) | {"patience": math.nan}, ErrorCode.NON_FINITE_INPUT, "patience"),
    ],
)
def test_goals_that_are_none_get_the_codes_of_services(drive, moves, fields, code, words):
    status, result = moves.move(**fields)
    assert (status, result.error_code.val) == (ABORTED, code), result.error_code.message
    assert words in result.error_code.message
    np.testing.assert_array_equal(result.reached.motors.position, HOME)
    assert math.isnan(result.remaining)


def test_a_refused_goal_leaves_the_one_on_its_way_alone(slow, moves):
    handle = moves.send(**motors(2.79, 0.35))
    assert moves.move(**motors(math.nan, 0.5))[0] == ABORTED
    assert moves.result(handle)[0] == SUCCEEDED


def test_quaternions_and_ranges_are_looked_at(planar_body):
    """This one controls its angle, and its motors have a range."""
    moves = MoveClient(planar_body.client)
    turned = platform(0.0, 0.0)
    turned["platform"].pose.orientation.w = 0.5
    tilted = platform(0.0, 0.0)
    tilted["platform"].pose.orientation.w, tilted["platform"].pose.orientation.x = 0.8, 0.6
    beyond, degrees = (motors(angle, names=["motor2"]) for angle in (1.6, 30.0))
    try:
        for fields, code, words in (
            (turned, ErrorCode.INVALID_QUATERNION, "platform.pose.orientation"),
            (tilted, ErrorCode.INVALID_QUATERNION, "expected a rotation about z"),
            (beyond, ErrorCode.MOTOR_LIMIT, "motors.position: motor2"),
            (degrees, ErrorCode.MOTOR_LIMIT, f"; motor2 at 30 {DEGREES}"),
        ):
            status, result = moves.move(**fields)
            assert (status, result.error_code.val) == (ABORTED, code)
            assert words in result.error_code.message
    finally:
        moves.close()


@pytest.mark.usefixtures("crawling")
def test_a_node_that_is_deactivated_ends_its_goal(rfrfr, moves):
    handle = moves.send(**motors(3.5, -0.4))
    moves.client.spin_until(lambda: bool(moves.feedback))
    assert change(rfrfr.client, Transition.TRANSITION_DEACTIVATE)
    try:
        status, result = moves.result(handle)
        assert (status, result.error_code.val) == (ABORTED, ErrorCode.NOT_READY)
        assert "deactivated" in result.error_code.message
        assert len(result.reached.motors.position) == 2
        status, result = moves.move(**motors(2.6, 0.5))
        assert (status, result.error_code.val) == (ABORTED, ErrorCode.NOT_READY)
        assert result.reached.index_locked == -1
        assert "inactive: holds and is silent" in rfrfr.process.output()
    finally:
        assert change(rfrfr.client, Transition.TRANSITION_ACTIVATE)


def test_what_the_motors_have_not_heard_of_is_not_reached(tmp_path):
    """A wrench held the first command back, and the goal was said to be reached."""
    with running_node(tmp_path, "robot:=rfrfr", "wrench_timeout:=0.0") as running:
        drive = Driver(running.client)
        moves = MoveClient(running.client)
        pushed = WrenchStamped()

        def told(action):
            drive.wrench.publish(pushed)
            return drive.metrics.action == action

        pushed.wrench.force.y = -1000.0
        drive.until(lambda: told(StabilityMetrics.ACTION_HALT))
        status, result = moves.move(**motors(*HOME), patience=0.5)
        assert (status, result.error_code.val) == (ABORTED, ErrorCode.CONTROL_FAILED)
        assert "halted for 0.5 s: the external wrench is not borne" in result.error_code.message
        assert not drive.all(Float64MultiArray)
        pushed.wrench.force.y = 0.0
        drive.until(lambda: told(StabilityMetrics.ACTION_NONE))
        status, result = moves.move(**motors(*HOME))
        assert (status, result.error_code.val) == (SUCCEEDED, ErrorCode.SUCCESS)
        drive.client.spin_until(lambda: drive.all(Float64MultiArray))
        np.testing.assert_array_equal(drive.all(Float64MultiArray)[-1].data, HOME)
        moves.close()
        drive.close()


def test_every_goal_of_a_burst_gets_a_result(drive):
    """As every request of a burst gets an answer: DDS kept ten, and lost the others."""
    node, deep = drive.client.node, QoSProfile(depth=1000)
    client = ActionClient(
        node,
        MoveTo,
        "/cpr_node/move_to",
        goal_service_qos_profile=deep,
        result_service_qos_profile=deep,
    )
    assert client.wait_for_server(TIMEOUT)
    outcomes = []

    def ask_for_the_result(sent):
        answer = sent.result().get_result_async()
        answer.add_done_callback(lambda told: outcomes.append(told.result().result.error_code.val))

    for number in range(100):
        goal = MoveTo.Goal(patience=1.0, **motors(HOME[0] + 1e-4 * number, HOME[1]))
        client.send_goal_async(goal).add_done_callback(ask_for_the_result)
    drive.client.spin_until(lambda: len(outcomes) == 100, 60.0)
    # All but the last were replaced, if they were not reached before.
    assert set(outcomes) <= {ErrorCode.SUCCESS, ErrorCode.PREEMPTED}
    client.destroy()


def test_feedback_says_what_the_stream_does_of_motors_that_do_not_follow(tmp_path):
    """It said "stable" while the stream said why the robot stands; and without tolerance for ever."""
    with running_node(tmp_path, "robot:=rfrfr", "moved_tolerance:=0.0") as running:
        drive = Driver(running.client)
        moves = MoveClient(running.client)
        topic = "/measured_joint_states"
        measured = running.client.node.create_publisher(JointState, topic, 10)
        jammed = JointState(name=["motor1", "motor2"], position=HOME)
        timer = running.client.node.create_timer(0.01, lambda: measured.publish(jammed))
        drive.client.spin_until(measured.get_subscription_count)
        drive.spin(0.2)
        status, result = moves.move(**motors(HOME[0] + 0.5, HOME[1]))
        assert (status, result.error_code.val) == (ABORTED, ErrorCode.CONTROL_FAILED)
        assert "the motors do not follow" in result.error_code.message

        def told():
            waits = "wait for a motor"
            return [feedback for feedback in moves.feedback if waits in feedback.status_text]

        drive.client.spin_until(told)  # the result may be taken first
        for feedback in told():
            assert feedback.action == StabilityMetrics.ACTION_SLOW
            assert feedback.speed_scale == 0.5
        running.client.node.destroy_timer(timer)
        running.client.node.destroy_publisher(measured)
        moves.close()
        drive.close()
