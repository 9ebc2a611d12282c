# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories from another process."""

import os
import re
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration, Time
from cpr_msgs.action import FollowTrajectory
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from helpers.driver import EVERY_MESSAGE
from helpers.goal_client import GoalClient
from helpers.joint_trajectory import DOWN, HOME, NAMES, trajectory
from helpers.node_process import change, running_node
from lifecycle_msgs.msg import Transition
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

pytestmark = pytest.mark.waits(seconds=60)


def with_efforts(message):
    message.points[0].effort = [0.1, 0.1]
    return message


class TrajectoryClient(GoalClient):
    """A client of ``~/follow_trajectory``, and the topic beside it."""

    def __init__(self, drive):
        super().__init__(drive.client, FollowTrajectory, f"{drive.name}/follow_trajectory")
        self.topic = self.client.node.create_publisher(
            JointTrajectory, f"{drive.name}/joint_trajectory", 1
        )
        self.client.spin_until(lambda: self.topic.get_subscription_count() > 0)

    def close(self):
        super().close()
        self.client.node.destroy_publisher(self.topic)

    def send(self, message, **fields):
        return super().send(trajectory=message, **fields)


@pytest.fixture
def following(drive):
    client = TrajectoryClient(drive)
    try:
        yield client
    finally:
        client.close()


def until_command(drive, motors):
    """The last commands may be taken after the result that comes behind them."""
    drive.client.spin_until(
        lambda: (
            len(commands_of(drive)) > 0 and np.allclose(commands_of(drive)[-1], motors, atol=1e-12)
        )
    )


def commands_of(drive):
    return np.array([message.data for message in drive.all(Float64MultiArray)])


def test_ten_seconds_are_followed_to_the_end(drive, following, capsys):
    times = np.linspace(0.0, 10.0, 41)
    swing = np.sin(0.8 * np.pi * times) * np.sin(0.1 * np.pi * times)
    rate = np.gradient(swing, times)
    rate[[0, -1]] = 0.0
    ways = np.outer(swing, [0.3, -0.2])
    came = []
    listener = drive.client.node.create_subscription(
        Float64MultiArray,
        f"{drive.name}/motor_commands",
        lambda message: came.append(time.monotonic()),
        EVERY_MESSAGE,
    )
    message = trajectory(times, HOME + ways, np.outer(rate, [0.3, -0.2]))
    done = following.result(following.send(message))
    drive.client.node.destroy_subscription(listener)
    assert done.status == GoalStatus.STATUS_SUCCEEDED, done.result.error_code
    assert done.result.error_code.val == ErrorCode.SUCCESS
    np.testing.assert_allclose(done.result.reached.motors.position, HOME + ways[-1], atol=1e-6)
    assert done.result.time >= 10.0 - 1e-6
    until_command(drive, HOME + ways[-1])
    commands = commands_of(drive)
    assert np.abs(np.diff(commands, axis=0)).max() <= 4.0 / 200.0 * (1.0 + 1e-6)
    feedback = following.feedback
    seconds = [given.time for given in feedback]
    assert seconds == sorted(seconds)
    assert seconds[0] < seconds[-1] <= done.result.time
    assert all(0.0 < given.margin < 1.1 for given in feedback)
    assert list(feedback[0].desired.positions) != list(feedback[-1].desired.positions)
    between = np.diff(came) * 1e3
    with capsys.disabled():
        print(
            f"\n{len(came)} commands of a trajectory of 10 s, time between them: median "
            f"{np.median(between):.2f} ms, p99 {np.percentile(between, 99):.2f} ms"
        )


@contextmanager
def measuring(drive, motors, timeout=600.0):
    """Somebody measures the motors a hundred times a second; that is this process, if not held up.

    What was measured is believed until it is as old as the timeout [s].
    """
    assert drive.set_parameters(measured_timeout=timeout).successful
    node = drive.client.node
    publisher = node.create_publisher(JointState, "/measured_joint_states", qos_profile_sensor_data)
    timer = node.create_timer(
        0.01, lambda: publisher.publish(JointState(name=NAMES, position=motors()))
    )
    try:
        drive.client.spin_until(lambda: publisher.get_subscription_count() > 0)
        drive.spin(0.2)
        yield
    finally:
        node.destroy_timer(timer)
        node.destroy_publisher(publisher)
        drive.spin(1.0)  # until nobody is found any more who publishes
        for transition in (Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE):
            assert change(drive.client, transition)  # what was measured is forgotten
        assert drive.set_parameters(measured_timeout=0.5).successful


def test_a_motor_that_is_measured_to_stand_still_is_told(drive, following):
    """Commands went to the end, and the action succeeded."""
    stuck = HOME.tolist()
    with measuring(drive, lambda: stuck):
        handle = following.send(
            trajectory([1.0], [HOME + [0.08, 0.0]]), goal_tolerance=[0.02, 0.02]
        )
        done = following.result(handle)
    assert done.status == GoalStatus.STATUS_ABORTED
    assert done.result.error_code.val == ErrorCode.CONTROL_FAILED
    assert done.result.measure == "goal_tolerance"
    assert "motor1 is measured 0.08 from the end" in done.result.error_code.message
    actual = np.array([given.actual.positions for given in following.feedback])
    np.testing.assert_array_equal(actual, np.broadcast_to(stuck, actual.shape))
    for given in following.feedback:
        np.testing.assert_allclose(
            given.error.positions, np.subtract(given.desired.positions, stuck), atol=1e-12
        )


def test_encoders_that_are_dead_are_told_and_hold_no_tolerance(rfrfr, drive, following):
    """They said nothing but NaN, of which nobody had a word, and the action succeeded."""
    positions = HOME.tolist()
    with measuring(drive, lambda: positions, timeout=0.5):
        positions = [float("nan")] * 2
        handle = following.send(
            trajectory([1.0], [HOME + [0.08, 0.0]]), goal_tolerance=[0.02, 0.02]
        )
        done = following.result(handle)
        drive.client.spin_until(
            lambda: "measured_joint_states: dropped: position" in rfrfr.process.output()
        )
    assert done.status == GoalStatus.STATUS_ABORTED
    assert done.result.error_code.val == ErrorCode.CONTROL_FAILED
    assert done.result.measure == "goal_tolerance"
    assert "more than measured_timeout" in done.result.error_code.message
    (array,) = drive.client.messages(DiagnosticArray, "/diagnostics", 1)
    values = {pair.key: pair.value for status in array.status for pair in status.values}
    assert int(values["dropped measured_joint_states"]) > 10


def test_motors_that_are_measured_to_follow_arrive(drive, following):
    """They are measured where they were sent: late, as this process hears of it on a busy machine."""
    newest = [HOME.tolist()]

    def sent():
        newest.extend(command.tolist() for command in commands_of(drive)[-1:])
        return newest[-1]

    with measuring(drive, sent):
        end = HOME + [0.08, -0.05]
        handle = following.send(
            trajectory([1.0], [end]),
            goal_tolerance=[1e-3, 1e-3],
            goal_time_tolerance=Duration(sec=20),
        )
        done = following.result(handle)
    assert done.status == GoalStatus.STATUS_SUCCEEDED, done.result.error_code


def test_names_in_another_order_and_the_topic(drive, following):
    end = HOME + [0.1, -0.2]
    following.topic.publish(trajectory([0.2], [end[::-1]], names=NAMES[::-1]))
    drive.until(lambda: np.array_equal(drive.motors, end))
    drive.until_state(StabilityMetrics.STATE_IDLE)


def test_a_stream_of_them_is_followed_and_not_worth_a_line_each(rfrfr, drive, following):
    """As moveit_servo sends them: every one takes the place of the one before."""
    written = len(rfrfr.process.output())
    for part in np.linspace(0.0, 1.0, 60):
        end = HOME + part * np.array([0.1, -0.2])
        following.topic.publish(trajectory([0.05], [end]))
        drive.spin(0.02)
    drive.until(lambda: np.array_equal(drive.motors, end))
    drive.until_state(StabilityMetrics.STATE_IDLE)
    said = rfrfr.process.output()[written:]
    assert "~/joint_trajectory: done" in said
    assert "[WARN]" not in said and "newer" not in said


def test_into_the_instability_it_is_refused_beforehand(drive, following):
    done = following.result(following.send(trajectory([8.0], [DOWN])))
    assert done.status == GoalStatus.STATUS_ABORTED
    assert done.result.error_code.val == ErrorCode.INVALID_MOTION_PLAN
    assert done.result.measure == "margin"
    assert 0.0 < done.result.time < 8.0
    assert "below margin_stop 0.05" in done.result.error_code.message
    np.testing.assert_array_equal(done.result.reached.motors.position, HOME)
    drive.until(lambda: np.array_equal(drive.motors, HOME))


def test_pushed_into_it_by_a_wrench_it_is_halted(drive, following):
    # With the timeout of wrenches the load would change on a busy machine, not only the motors.
    given = {"margin_warning": 0.41, "margin_stop": 0.4, "wrench_timeout": 60.0}
    assert drive.set_parameters(**given).successful
    try:
        handle = following.send(trajectory([4.0], [HOME + [2.0, -2.0]]))
        drive.until(lambda: np.abs(drive.motors - HOME).max() > 0.05)
        push = WrenchStamped()
        push.wrench.force.y = -3.0
        answer = handle.get_result_async()
        while not answer.done():
            drive.wrench.publish(push)
            drive.spin(0.02)
        result = answer.result().result
        assert answer.result().status == GoalStatus.STATUS_ABORTED
        assert result.error_code.val == ErrorCode.CONTROL_FAILED, result.error_code.message
        assert result.measure == "margin"
        assert 0.0 < result.time < 4.0
        assert result.reached.margin >= 0.4
        assert result.reached.index_locked == 0
    finally:
        drive.set_parameters(margin_warning=0.2, margin_stop=0.05, wrench_timeout=0.5)


def test_a_cancelled_one_holds_within_one_tick(drive, following):
    sent = []  # when, and what
    heard = drive.client.node.create_subscription(
        Float64MultiArray,
        f"{drive.name}/motor_commands",
        lambda message, info: sent.append((info["source_timestamp"], *message.data)),
        EVERY_MESSAGE,
    )
    handle = following.send(trajectory([10.0], [HOME + [2.0, 0.0]]))
    drive.until(lambda: np.abs(drive.motors - HOME).max() > 0.05)
    drive.client.spin_until(lambda: sent)  # of another topic
    cancelled = handle.cancel_goal_async()
    drive.client.spin_until(cancelled.done)
    answered = time.time_ns()
    assert len(cancelled.result().goals_canceling) == 1
    done = following.result(handle)
    assert done.status == GoalStatus.STATUS_CANCELED
    assert done.result.error_code.val == ErrorCode.PREEMPTED
    held = np.array(done.result.reached.motors.position)
    drive.until(lambda: len(drive.all(StabilityMetrics)) >= 5)
    np.testing.assert_array_equal(drive.motors, held)
    # At rest the last command is repeated: it is where the robot was when the cancelling came.
    drive.until_commands_rest()
    drive.forget()
    until_command(drive, held)
    np.testing.assert_array_equal(np.unique(commands_of(drive), axis=0), [held])
    drive.client.node.destroy_subscription(heard)
    late = {(first, second) for when, first, second in sent if when > answered}
    assert (held[0], held[1]) in late  # the clocks are one: it was said again since
    assert len(late) <= 2, "more than one tick after the answer it still moved"
    drive.client.spin_until(lambda: bool(drive.all(StabilityMetrics)))
    assert drive.metrics.state == StabilityMetrics.STATE_IDLE


def test_a_newer_one_replaces_one_under_way(drive, following):
    rest = np.zeros((1, 2))
    first = following.send(trajectory([4.0], [HOME + [1.0, 0.5]], rest))
    drive.until(lambda: drive.motors[0] > HOME[0] + 0.1)
    second = following.send(trajectory([1.0], [HOME + [0.2, 0.1]], rest))
    assert following.result(first).result.error_code.val == ErrorCode.PREEMPTED
    assert following.result(second).result.error_code.val == ErrorCode.SUCCESS
    until_command(drive, HOME + [0.2, 0.1])
    assert np.abs(np.diff(commands_of(drive), axis=0)).max() <= 4.0 / 200.0


def test_an_empty_one_a_setpoint_a_pause_and_a_way_home_end_one(drive, following):
    for end in (
        lambda: following.topic.publish(JointTrajectory()),
        lambda: drive.send_motors(*HOME),
        lambda: drive.pause(True),
        drive.reset,
    ):
        handle = following.send(trajectory([10.0], [HOME + [2.0, 0.0]]))
        drive.until(lambda: np.abs(drive.motors - HOME).max() > 0.05)
        end()
        done = following.result(handle)
        assert done.status == GoalStatus.STATUS_ABORTED
        assert done.result.error_code.val == ErrorCode.PREEMPTED
        drive.go_home()


def test_one_that_falls_behind_its_tolerance_is_given_up(drive, following):
    """Below the warning threshold it is slowed down, by more than its first motor allows."""
    given = {"margin_warning": 0.99, "margin_stop": 0.9, "max_speed": 0.8}
    assert drive.set_parameters(**given).successful
    message = trajectory([1.0], [HOME + [0.5, -0.5]], np.zeros((1, 2)))
    try:
        beyond = following.result(following.send(message, path_tolerance=[0.01, 0.0]))
        drive.go_home()
        late = following.result(
            following.send(
                message, goal_tolerance=[1e-3, 0.0], goal_time_tolerance=Duration(nanosec=10**7)
            )
        )
    finally:
        given = {"margin_warning": 0.2, "margin_stop": 0.05, "max_speed": 4.0}
        assert drive.set_parameters(**given).successful
    for done, measure in ((beyond, "path_tolerance"), (late, "goal_time_tolerance")):
        assert done.status == GoalStatus.STATUS_ABORTED
        assert done.result.error_code.val == ErrorCode.CONTROL_FAILED
        assert done.result.measure == measure
        assert "motor1" in done.result.error_code.message


@pytest.mark.parametrize(
    ("field", "given", "val"),
    [
        ("path_tolerance", [0.1], "INVALID_ROBOT_STATE"),
        ("goal_tolerance", [0.1, -0.1], "INVALID_ROBOT_STATE"),
        ("goal_tolerance", [0.1, np.nan], "NON_FINITE_INPUT"),
        ("goal_time_tolerance", Duration(sec=-1), "INVALID_ROBOT_STATE"),
    ],
)
def test_tolerances_that_are_none_are_refused(drive, following, field, given, val):
    message = trajectory([1.0], [HOME])
    done = following.result(following.send(message, **{field: given}))
    assert done.status == GoalStatus.STATUS_ABORTED
    assert done.result.error_code.val == getattr(ErrorCode, val), done.result.error_code.message
    assert done.result.error_code.message.startswith(field)


@pytest.mark.parametrize("way", ["action", "action, waiting for its start", "topic"])
def test_a_deactivated_node_ends_one_and_moves_no_further(rfrfr, drive, following, way):
    message = trajectory([10.0], [HOME + [2.0, 0.0]])
    if way == "action, waiting for its start":
        now = drive.client.node.get_clock().now().nanoseconds
        message.header.stamp.sec = now // 10**9 + 30
    log = rfrfr.process.output
    before = log().count("-110: the node was deactivated")
    if way == "topic":
        following.topic.publish(message)
    else:
        handle = following.send(message)
    if way != "action, waiting for its start":
        drive.until(lambda: np.abs(drive.motors - HOME).max() > 0.05)
    assert change(drive.client, Transition.TRANSITION_DEACTIVATE)
    try:
        if way != "topic":
            done = following.result(handle)
            assert done.status == GoalStatus.STATUS_ABORTED
            assert done.result.error_code.val == ErrorCode.NOT_READY
            assert done.result.error_code.message == "the node was deactivated"
            held = np.array(done.result.reached.motors.position)
        drive.client.spin_until(lambda: log().count("-110: the node was deactivated") > before)
        drive.forget()
        refused = following.result(following.send(message)).result
        assert refused.error_code.val == ErrorCode.NOT_READY
        assert refused.reached.index_locked == -1  # 0 would be stable
    finally:
        assert change(drive.client, Transition.TRANSITION_ACTIVATE)
    drive.until(lambda: len(drive.all(StabilityMetrics)) >= 10)
    if way == "topic":
        held = drive.motors
        assert 0.05 < held[0] - HOME[0] < 1.9
    for state in drive.all(JointState):
        np.testing.assert_array_equal(state.position, held)
    assert {told.state for told in drive.all(StabilityMetrics)} == {StabilityMetrics.STATE_IDLE}
    drive.forget()
    until_command(drive, held)  # and that is what a controller hears


@pytest.mark.parametrize(
    ("message", "val", "words"),
    [
        (trajectory([1.0], [[2.6]], names=["motor1"]), "INVALID_ROBOT_STATE", "missing: motor2"),
        (trajectory([1.0], [HOME], names=["motor1", "motor1"]), "INVALID_ROBOT_STATE", "twice"),
        (trajectory([1.0], [HOME], names=["motor1", "elbow"]), "INVALID_ROBOT_STATE", "unknown"),
        (trajectory([1.0], [[2.6]]), "INVALID_ROBOT_STATE", "points[0].positions"),
        (trajectory([1.0], [[2.6, np.nan]]), "NON_FINITE_INPUT", "points[0].positions"),
        (trajectory([1.0, 1.0], [HOME, HOME]), "INVALID_MOTION_PLAN", "more than the 1 s"),
        (trajectory([-1.0], [HOME]), "INVALID_MOTION_PLAN", "at least 0"),
        (trajectory([1.0], [HOME], [[0.1, 0.0]]), "INVALID_MOTION_PLAN", "ends at rest"),
        (trajectory([0.1], [HOME + 1.0]), "INVALID_MOTION_PLAN", "no more than 4 rad/s"),
        (trajectory([0.0, 1.0], [HOME + 0.5] * 2), "INVALID_MOTION_PLAN", "commanded to"),
        (with_efforts(trajectory([1.0], [HOME])), "INVALID_ROBOT_STATE", "moved by position"),
        (
            trajectory(np.arange(1, 10_002), [HOME] * 10_001),
            "INVALID_ROBOT_STATE",
            "no more than 10000 points",
        ),
        (trajectory([601.0], [HOME]), "INVALID_MOTION_PLAN", "within 600 s"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_wrong_is_refused_with_the_reason(drive, following, message, val, words):
    done = following.result(following.send(message))
    assert done.status == GoalStatus.STATUS_ABORTED
    assert done.result.error_code.val == getattr(ErrorCode, val), done.result.error_code.message
    assert words in done.result.error_code.message
    drive.until(lambda: np.array_equal(drive.motors, HOME))


def test_a_stamp_before_the_first_clock_is_refused(tmp_path):
    """It was compared with 0, and the robot set off that many seconds later."""
    with running_node(tmp_path, "robot:=rfrfr", "use_sim_time:=true") as running:
        drive = SimpleNamespace(client=running.client, name="/cpr_node")
        following = TrajectoryClient(drive)
        message = trajectory([0.3], [HOME + [0.05, 0.0]])
        message.header.stamp = Time(sec=12)
        done = following.result(following.send(message))
        assert done.status == GoalStatus.STATUS_ABORTED
        words = "header.stamp: expected 0 as long as no /clock has come, got 12 s"
        assert done.result.error_code.message == words
        assert done.result.error_code.val == ErrorCode.INVALID_MOTION_PLAN
        assert done.result.measure == "header.stamp"
        following.topic.publish(message)
        running.process.wait_for_log(f"~/joint_trajectory: dropped: {words}", 20.0)
        message.header.stamp = Time()
        assert following.result(following.send(message)).status == GoalStatus.STATUS_SUCCEEDED
        following.close()


def test_the_program_of_the_docs_does_what_it_says(drive):
    page = Path(__file__).parents[3] / "docs/node.md"
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    (program,) = (block for block in blocks if "FollowTrajectory" in block)
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ
        | {
            "ROS_DOMAIN_ID": str(drive.client.context.get_domain_id()),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        },
        capture_output=True,
        text=True,
        timeout=120.0,
    )
    assert done.returncode == 0, done.stderr
    val, seconds = done.stdout.split()
    assert int(val) == ErrorCode.SUCCESS
    assert float(seconds) >= 2.0 - 1e-3
    drive.until(lambda: np.array_equal(drive.motors, HOME))
