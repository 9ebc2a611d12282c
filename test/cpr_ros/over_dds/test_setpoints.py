# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Setpoints from another process."""

import time
from pathlib import Path

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveForward
from geometry_msgs.msg import PoseStamped
from helpers.driver import Driver, pose_at
from helpers.node_process import Client, NodeProcess, free_domain
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

HOME, AWAY = [2.59, 0.55], [2.75, 0.40]


def test_motors_by_name_are_followed_and_commands_go_out(drive):
    drive.send_motors(0.60, 2.65, names=["motor2", "motor1"])
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.60]), forget=False)  # it takes 10 ms
    # The last command may be taken after the state that comes behind it.
    drive.client.spin_until(
        lambda: [list(said.data) for said in drive.all(Float64MultiArray)[-1:]] == [[2.65, 0.60]]
    )
    commands = np.array([command.data for command in drive.all(Float64MultiArray)])
    np.testing.assert_array_equal(commands[-1], [2.65, 0.60])
    assert np.abs(np.diff(commands, axis=0)).max() <= 4.0 / 200.0 * (1.0 + 1e-6)
    velocities = [state.velocity[0] for state in drive.all(JointState)]
    assert max(velocities) == pytest.approx(4.0, rel=1e-6)
    drive.until_state(StabilityMetrics.STATE_IDLE)
    drive.until(lambda: len(drive.all(JointState)) > 2)
    assert drive.all(JointState)[-1].velocity[0] == 0.0


def test_some_motors_may_be_named_the_others_keep_their_setpoint(drive):
    drive.send_motors(2.65, names=["motor1"])
    drive.send_motors(0.50, names=["motor2"])
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.50]))
    drive.send_motors(0.45, names=["motor2"])
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.45]))


def test_commands_are_in_motor_order(drive):
    drive.commands.publish(Float64MultiArray(data=[2.5, 0.7]))
    drive.until(lambda: np.array_equal(drive.motors, [2.5, 0.7]))


def test_the_newest_setpoint_wins_whatever_its_topic(drive):
    drive.send_motors(3.5, -0.4)
    drive.spin(0.05)
    drive.send_platform(0.02, 0.82)
    drive.until(lambda: np.allclose(drive.position[:2], [0.02, 0.82], atol=1e-8))
    drive.send_motors(*HOME)
    drive.until(lambda: np.array_equal(drive.motors, HOME))


def test_driving_straight_through_the_instability(drive):
    """The crossing lies at y = 0.0357 (continuous rods, motors locked)."""
    drive.send_platform(0.0, 0.8)
    drive.until(lambda: np.allclose(drive.position[:2], [0.0, 0.8], atol=1e-8))
    assert drive.set_parameters(max_speed=1.0).successful  # several messages while it slows down
    try:
        drive.send_platform(0.0, -0.2)
        drive.forget()
        drive.client.spin_until(
            lambda: (
                bool(drive.all(StabilityMetrics))
                and drive.metrics.status == StabilityMetrics.STATUS_HALT_FOR_STABILITY
            )
        )
        seen = list(drive.all(StabilityMetrics))
        drive.catch_up(seen[-1])
        poses = list(drive.all(PoseStamped))
        assert seen[-1].action == StabilityMetrics.ACTION_HALT
        assert seen[-1].speed_scale == 0.0
        assert seen[-1].state == StabilityMetrics.STATE_HALTED
        # It slowed before it halted, and was stable all the way.
        actions = [metrics.action for metrics in seen]
        assert actions == sorted(actions)
        assert StabilityMetrics.ACTION_SLOW in actions
        assert all(metrics.index_locked == 0 for metrics in seen)
        assert all(metrics.margin >= 0.05 for metrics in seen)
        assert min(pose.pose.position.y for pose in poses) > 0.0357 + 0.005
        # It publishes while it is halted, and stays.
        halted = drive.position
        drive.until(
            lambda: len(drive.all(StabilityMetrics)) >= 15 and len(drive.all(JointState)) >= 40
        )
        np.testing.assert_array_equal(drive.position, halted)
        assert drive.metrics.state == StabilityMetrics.STATE_HALTED
    finally:  # a robot that is halted forgets its setpoint with that
        assert drive.set_parameters(max_speed=4.0).successful
    # It returns when it is told to.
    drive.send_platform(0.0, 0.8)
    drive.until(lambda: np.allclose(drive.position[:2], [0.0, 0.8], atol=1e-8))
    drive.until_state(StabilityMetrics.STATE_IDLE)
    assert drive.metrics.action == StabilityMetrics.ACTION_NONE


@pytest.fixture
def slow(drive):
    """On its way for long, however late this process is."""
    assert drive.set_parameters(max_speed=0.02).successful
    yield drive
    assert drive.set_parameters(max_speed=4.0).successful


def test_pause_during_motion_holds_and_forgets_the_setpoint(slow):
    drive = slow
    drive.send_platform(0.0, 0.3)
    drive.until(lambda: not np.array_equal(drive.motors, HOME))
    answer = drive.pause(True)
    assert answer.success
    drive.until_state(StabilityMetrics.STATE_PAUSED)
    held = drive.motors
    assert drive.position[1] > 0.3 + 1e-3  # on its way, not at its end
    drive.send_platform(0.0, 0.5)
    drive.spin(0.3)
    np.testing.assert_array_equal(drive.motors, held)
    refused = drive.reset()
    assert not refused.success
    assert "paused" in refused.message
    assert drive.pause(False).success
    drive.until_state(StabilityMetrics.STATE_IDLE)
    np.testing.assert_array_equal(drive.motors, held)


def test_reset_during_motion_goes_home_and_takes_no_setpoints_on_the_way(drive):
    drive.send_platform(0.0, 0.3)
    drive.until(lambda: np.abs(drive.motors - HOME).max() > 0.05)
    assert drive.set_parameters(max_speed=0.002).successful  # half a minute, however late this is
    answer = drive.reset()
    assert answer.success
    before = drive.dropped("~/platform_setpoint")
    drive.send_platform(0.0, 0.3)
    drive.client.spin_until(lambda: drive.dropped("~/platform_setpoint") > before)
    drive.until_state(StabilityMetrics.STATE_RETURNING)
    assert drive.set_parameters(max_speed=4.0).successful
    drive.until_state(StabilityMetrics.STATE_IDLE)
    np.testing.assert_array_equal(drive.motors, HOME)


@pytest.mark.parametrize(
    ("publisher", "topic", "message", "words"),
    [
        (
            "motor_setpoint",
            "motor_setpoint",
            JointState(name=["motor2", "motor1"], position=[31.5, 148.4]),
            "motor1 at 148.4 looks like degrees, expected radians",
        ),
        (
            "commands",
            "commands",
            Float64MultiArray(data=[148.4, 31.5]),
            "motor1 at 148.4 looks like degrees, expected radians",
        ),
        (
            "platform",
            "platform_setpoint",
            pose_at(0.0, 830.0),
            "the platform position (0, 830, 0) looks like millimetres, expected metres",
        ),
    ],
)
def test_numbers_of_another_unit_are_dropped_and_the_setpoint_before_is_gone_to(
    rfrfr, slow, publisher, topic, message, words
):
    """The robot set off for them, and went on until something halted it."""
    drive = slow
    drive.send_motors(2.79, 0.35)
    drive.until(lambda: not np.array_equal(drive.motors, HOME))
    before = drive.dropped(f"~/{topic}")
    getattr(drive, publisher).publish(message)
    drive.client.spin_until(lambda: drive.dropped(f"~/{topic}") > before)
    assert f"~/{topic}: dropped: {words}" in rfrfr.process.output()
    assert drive.set_parameters(max_speed=4.0).successful
    drive.until_state(StabilityMetrics.STATE_IDLE)
    np.testing.assert_array_equal(drive.motors, [2.79, 0.35])


def test_apply_during_motion_is_refused_and_at_rest_forgets_the_setpoint(slow):
    drive = slow

    def apply():
        request = SolveForward.Request(start=SolveForward.Request.START_HOME, apply=True)
        request.motors = JointState(name=["motor1", "motor2"], position=[2.7, 0.5])
        return drive.client.call(SolveForward, "/cpr_node/solve_forward", request).error_code

    drive.send_platform(0.0, 0.3)
    drive.until(lambda: not np.array_equal(drive.motors, HOME))
    code = apply()
    assert code.val == ErrorCode.NOT_READY
    assert "on its way" in code.message
    assert drive.set_parameters(max_speed=4.0).successful
    drive.until_state(StabilityMetrics.STATE_IDLE)
    np.testing.assert_allclose(drive.position[:2], [0.0, 0.3], atol=1e-8)
    assert apply().val == ErrorCode.SUCCESS
    drive.until(lambda: np.array_equal(drive.motors, [2.7, 0.5]))
    drive.spin(0.3)
    np.testing.assert_array_equal(drive.motors, [2.7, 0.5])


def test_the_parameter_file_of_a_robot_starts_a_node_that_halts_in_time(tmp_path):
    """Eight modes: the border of stability is where that of the continuous rods is."""
    domain = free_domain()
    file = Path(__file__).parents[3] / "config/node/rfrfr.yaml"
    arguments = ["--params-file", str(file), "-p", "max_speed:=4.0"]
    process = NodeProcess(tmp_path / "node.log", domain, arguments)
    process.wait_for_log("ready")
    client = Client(domain)
    try:
        drive = Driver(client)
        drive.send_platform(0.0, -0.2)
        drive.until_state(StabilityMetrics.STATE_HALTED)
        assert drive.metrics.status == StabilityMetrics.STATUS_HALT_FOR_STABILITY
        np.testing.assert_allclose(drive.position[1], 0.0538, atol=5e-4)
    finally:
        client.close()
        assert process.stop() == 0, process.output()


def test_no_more_than_a_ticks_way_in_a_period_whatever_comes_when(drive):
    """At rest a step is taken at once, on the way there is one a period, however many setpoints come."""
    way, period, random = 4.0 / 200.0, 0.95 / 200.0, np.random.default_rng(3)
    for start, target in ((HOME, AWAY), (AWAY, HOME)) * 5:
        drive.forget()
        begin = time.time()
        for pause in 0.002 * random.random(20):
            drive.send_motors(*target)
            drive.spin(pause)
        drive.client.spin_until(
            lambda target=target: drive.all(JointState) and np.array_equal(drive.motors, target)
        )
        states = drive.all(JointState)
        stamps = [state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec for state in states]
        moved = np.abs(np.array([state.position for state in states]) - start).max(axis=1)
        assert (moved <= way * (1.0 + (np.array(stamps) - begin) / period)).all()
