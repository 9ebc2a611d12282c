# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Lines of docs/node.md, docs/security.md and docs/workspace.md that no other test shows."""

import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import yaml
from action_msgs.msg import GoalStatus
from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import ErrorCode, MapAxis, StabilityMetrics
from cpr_msgs.srv import SolveForward
from geometry_msgs.msg import PoseStamped
from helpers.driver import Driver
from helpers.goal_client import GoalClient
from helpers.node_process import TIME_LIMIT
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

DOCS = Path(__file__).parents[3] / "docs"
HOME, AWAY = [2.59, 0.55], [2.9, 0.24]
S = StabilityMetrics


def apply(drive, *motors):
    """Make the equilibrium at these motors the current one; commands are elsewhere then."""
    state = JointState(name=["motor1", "motor2"], position=[float(motor) for motor in motors])
    request = SolveForward.Request(motors=state, apply=True)
    answer = drive.client.call(SolveForward, "/cpr_node/solve_forward", request)
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message


@pytest.fixture
def slow(drive):
    assert drive.set_parameters(max_speed=0.3).successful
    yield drive
    drive.pause(False)
    assert drive.set_parameters(max_speed=4.0).successful


def test_setpoints_wait_while_commands_are_aligned_and_a_pause_holds_them(slow):
    slow.send_motors(*HOME)
    slow.until(lambda: bool(slow.all(Float64MultiArray)))
    assert slow.set_parameters(max_speed=0.05).successful  # six seconds, however late a pause comes
    apply(slow, *AWAY)
    slow.until_state(S.STATE_ALIGNING)
    np.testing.assert_array_equal(slow.motors, AWAY)  # the equilibrium is there at once
    assert slow.pause(True).success
    slow.until_state(S.STATE_PAUSED)
    slow.until_commands_rest()
    held = list(slow.all(Float64MultiArray)[-1].data)
    assert held not in (HOME, AWAY)
    slow.until(lambda: len(slow.all(Float64MultiArray)) > 1)  # said again, and the same
    assert {tuple(command.data) for command in slow.all(Float64MultiArray)} == {tuple(held)}
    assert slow.pause(False).success
    slow.until_state(S.STATE_ALIGNING)
    slow.send_motors(*HOME)
    slow.spin(0.1)
    np.testing.assert_array_equal(slow.motors, AWAY)
    assert slow.set_parameters(max_speed=0.3).successful
    slow.client.spin_until(
        lambda: AWAY in [list(command.data) for command in slow.all(Float64MultiArray)]
    )
    slow.until(lambda: np.array_equal(slow.motors, HOME))


@pytest.mark.parametrize("before", [S.STATE_HALTED, S.STATE_RETURNING, S.STATE_STALE])
def test_a_pause_is_taken_in_every_state_and_forgets_the_setpoint(slow, before):
    try:
        if before == S.STATE_HALTED:
            assert slow.set_parameters(max_speed=4.0).successful
            slow.send_platform(0.0, -0.2)
        elif before == S.STATE_STALE:
            assert slow.set_parameters(setpoint_timeout=0.1).successful
            slow.send_motors(*AWAY)
        else:
            apply(slow, *AWAY)
            assert slow.set_parameters(max_speed=4.0).successful  # commands follow at once
            slow.until_state(S.STATE_IDLE)
            assert slow.set_parameters(max_speed=0.1).successful
            assert slow.reset().success
        slow.until_state(before)
        assert slow.pause(True).success
        slow.until_state(S.STATE_PAUSED)
        held = slow.motors
        refused = slow.reset()
        assert not refused.success
        assert refused.message.startswith("-110: ")
    finally:
        assert slow.set_parameters(max_speed=4.0, setpoint_timeout=0.0).successful
        assert slow.pause(False).success
    slow.until_state(S.STATE_IDLE)
    np.testing.assert_array_equal(slow.motors, held)


def test_a_way_home_that_is_halted_can_be_replaced_by_a_setpoint(drive):
    drive.send_motors(2.2, 0.94)  # a margin above that of home
    drive.until(lambda: np.array_equal(drive.motors, [2.2, 0.94]))
    assert drive.set_parameters(margin_warning=0.989, margin_stop=0.985).successful
    try:
        assert drive.reset().success
        drive.until_state(S.STATE_HALTED)
        assert "the next margin" in drive.metrics.status_text
        drive.send_motors(2.2, 0.94)
        drive.until(lambda: np.array_equal(drive.motors, [2.2, 0.94]))
    finally:
        assert drive.set_parameters(margin_warning=0.2, margin_stop=0.05).successful


def test_of_a_pose_only_the_controlled_coordinates_are_read(drive):
    pose = PoseStamped()
    position, orientation = pose.pose.position, pose.pose.orientation
    position.x, position.y, position.z = 0.05, 0.75, math.nan
    orientation.w, orientation.x = 0.0, 7.0
    drive.platform.publish(pose)
    drive.until(lambda: np.allclose(drive.position, [0.05, 0.75, 0.0], atol=1e-8))


@pytest.mark.usefixtures("compiled")
def test_a_request_that_takes_too_long_is_answered_so(six_rfs):
    """This way is walked in many steps."""
    drive = Driver(six_rfs.client)
    try:
        assert drive.set_parameters(time_limit=0.001).successful
        request = SolveForward.Request(start=SolveForward.Request.START_HOME)
        request.motors.name = [f"motor{number}" for number in range(1, 7)]
        request.motors.position = [8.0, 3.0, 8.0, 3.0, 8.0, 3.0]
        answer = six_rfs.client.call(SolveForward, "/cpr_node/solve_forward", request)
        assert answer.error_code.val == ErrorCode.TIMED_OUT, answer.error_code
    finally:
        assert drive.set_parameters(time_limit=TIME_LIMIT).successful
        drive.close()


def test_a_trajectory_waits_for_no_commands_that_are_on_their_way(slow):
    """It is refused on the topic with a line in the log, and counted; so is one that cannot be."""
    topic = slow.client.node.create_publisher(JointTrajectory, "/cpr_node/joint_trajectory", 1)
    slow.client.spin_until(lambda: topic.get_subscription_count() > 0)
    point = JointTrajectoryPoint(positions=HOME)
    point.time_from_start.sec = 5
    message = JointTrajectory(joint_names=["motor1", "motor2"], points=[point])
    try:
        slow.send_motors(*HOME)
        slow.until(lambda: bool(slow.all(Float64MultiArray)))
        assert slow.set_parameters(max_speed=0.01).successful  # half a minute, however late this is
        before = slow.dropped("~/joint_trajectory")
        apply(slow, *AWAY)
        slow.until_state(S.STATE_ALIGNING)
        topic.publish(message)
        slow.client.spin_until(lambda: slow.dropped("~/joint_trajectory") == before + 1)
        assert slow.set_parameters(max_speed=4.0).successful
        message.points[0].time_from_start.sec = 0
        slow.until_state(S.STATE_IDLE)
        topic.publish(message)
        slow.client.spin_until(lambda: slow.dropped("~/joint_trajectory") == before + 2)
    finally:
        assert slow.set_parameters(max_speed=4.0).successful
        slow.client.node.destroy_publisher(topic)


@pytest.mark.usefixtures("compiled")
def test_where_files_are_kept(rfrfr, drive):
    """In ROS_HOME: where the robot was last, and maps; the goal is that of the page."""
    domain = rfrfr.client.context.get_domain_id()
    state = rfrfr.process.home / "cpr_ros" / f"cpr_node.{domain}.state"
    assert state.stat().st_size > 100
    page = (DOCS / "workspace.md").read_text(encoding="utf-8").replace("\\\n", " ")
    (line,) = re.findall(r"^ros2 action send_goal .*$", page, re.MULTILINE)
    *_, name, kind, content = shlex.split(line)
    assert kind == "cpr_msgs/action/MapWorkspace"
    given = yaml.safe_load(content)
    goals = GoalClient(rfrfr.client, MapWorkspace, name)
    try:
        axes = [MapAxis(**axis) for axis in given.pop("axes")]
        handle = goals.send(axes=axes, **given)
        rfrfr.client.spin_until(lambda: bool(goals.feedback), 300.0)
        assert goals.feedback[-1].total == 181 * 201
        assert goals.cancel(handle) == 1
        done = goals.result(handle)
    finally:
        goals.close()
    assert done.status == GoalStatus.STATUS_CANCELED
    assert Path(done.result.file) == rfrfr.process.home / "cpr_ros" / "maps" / "map.nc"
