# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A planar robot with softer rods and an unknown payload: measured, corrected, jogged."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveForward
from geometry_msgs.msg import PoseStamped
from helpers.camera import SPEED, Camera
from helpers.goal_client import GoalClient
from helpers.node_process import TIMEOUT
from sensor_msgs.msg import JointState

pytestmark = pytest.mark.waits(seconds=50)

SETPOINT = np.array([0.05, 0.75])


@pytest.fixture
def camera(rfrfr):
    """A planar robot with a payload, at home, its loop quick."""
    made = Camera(rfrfr.client, "rfrfr")
    try:
        made.go_home()
        assert made.set_parameters(loop_gain=4.0, loop_max_rate=1.0).successful
        made.spin(0.1)
        made.heard.clear()
        made.forget()
        yield made
    finally:
        made.close()


def test_the_measured_pose_is_met_and_open_it_is_not(camera):
    camera.send_platform(*SETPOINT)
    camera.until(lambda: np.allclose(camera.position[:2], SETPOINT, rtol=0.0, atol=1e-9))
    camera.until_state(StabilityMetrics.STATE_IDLE)
    assert camera.metrics.loop == StabilityMetrics.LOOP_OPEN
    assert np.isnan(camera.metrics.position_error) and camera.metrics.measured_pose_age == -1.0
    camera.spin(0.1)
    camera.obey()
    off = np.linalg.norm(camera.real.equilibrium.platform_position[:2] - SETPOINT)
    camera.measure(50.0)
    camera.until_met(5e-7)
    camera.spin(0.1)
    camera.obey()
    met = np.linalg.norm(camera.real.equilibrium.platform_position[:2] - SETPOINT)
    print(f"rfrfr: open loop off by {off:.3g} m, closed loop by {met:.1e} m")
    assert off > 0.02
    assert met < 1e-6
    assert np.isnan(camera.metrics.rotation_error)  # this robot controls none
    assert 0.0 <= camera.metrics.measured_pose_age < 1.0
    camera.check_commands()


def test_it_halts_as_without(rfrfr):
    camera = Camera(rfrfr.client, "rfrfr", payload=[0.0, 0.0, 0.0, 0.1, 0.5, 0.0])
    try:
        camera.go_home()
        assert camera.set_parameters(loop_gain=4.0, loop_max_rate=1.0).successful
        camera.heard.clear()
        camera.send_platform(0.0, 0.4)
        camera.until(lambda: np.allclose(camera.position[:2], [0.0, 0.4], rtol=0.0, atol=1e-9))
        camera.send_platform(0.0, -0.2)
        camera.until_state(StabilityMetrics.STATE_HALTED)
        camera.spin(0.3)
        without = camera.metrics
        camera.measure(50.0)
        camera.send_platform(0.0, 0.4)
        camera.until_met(1e-4)
        camera.send_platform(0.0, -0.2)
        camera.until_state(StabilityMetrics.STATE_HALTED)
        camera.spin(0.3)
        camera.until_frozen("the robot is halted")
        print(f"halted at margin {camera.metrics.margin:.4f}, without {without.margin:.4f}")
        for halted in (without, camera.metrics):
            assert 0.05 <= halted.margin < 0.06
            assert halted.action == StabilityMetrics.ACTION_HALT
            assert halted.status == StabilityMetrics.STATUS_HALT_FOR_STABILITY
            assert halted.nearest_threshold == "margin"
        camera.send_platform(0.0, 0.4)
        camera.until_met(1e-4)
        camera.check_commands()
    finally:
        camera.close()


def test_what_cannot_be_believed_freezes_the_correction_and_is_told(camera):
    # It holds longer than this test looks, on any machine.
    assert camera.set_parameters(measured_pose_settling=3.0).successful
    camera.send_platform(*SETPOINT)
    camera.measure(50.0)
    camera.until_met(1e-5)
    for change, text in (
        (moved, "the measured pose jumped by 0.1"),
        (not_a_number, "all finite, got"),
        (in_another_frame, "header.frame_id: expected 'base', got 'map'"),
        (old, "s old when it came, by its stamp"),
        (of_tomorrow, "s ahead of the clock here"),
        (lambda message: None, "old, more than measured_pose_timeout 0.5 s"),
    ):
        camera.changed = change
        camera.until_frozen(text)
        camera.until(lambda: True)  # what was on its way before is there
        motors = camera.motors
        camera.spin(0.4)
        camera.until(lambda: True)
        np.testing.assert_allclose(camera.motors, motors, rtol=0.0, atol=1e-6)
        assert camera.metrics.loop == StabilityMetrics.LOOP_FROZEN
        assert camera.metrics.action == StabilityMetrics.ACTION_SLOW
        assert text in camera.metrics.status_text
        camera.changed = lambda message: message
        camera.until_met(1e-4)
    camera.check_commands()
    assert camera.set_parameters(measured_pose_settling=1.0).successful


def moved(message):
    message.pose.position.x += 0.1
    return message


def not_a_number(message):
    message.pose.position.y = float("nan")
    return message


def in_another_frame(message):
    message.header.frame_id = "map"
    return message


def old(message):
    message.header.stamp.sec -= 3600
    return message


def of_tomorrow(message):
    message.header.stamp.sec += 86400
    return message


def test_one_picture_a_second_and_noise_at_200_hz(camera):
    assert camera.set_parameters(loop_gain=1.0, measured_pose_timeout=3.0).successful
    camera.send_platform(*SETPOINT)
    camera.measure(1.0)
    camera.until_met(5e-3)
    camera.check_commands()
    noise = np.random.default_rng(3)

    def noisy(message):
        message.pose.position.x += noise.normal(0.0, 1e-3)
        message.pose.position.y += noise.normal(0.0, 1e-3)
        return message

    camera.changed = noisy
    camera.measure(200.0)
    camera.spin(3.0)
    camera.until(lambda: camera.metrics.loop == StabilityMetrics.LOOP_CLOSED)
    camera.obey()
    off = np.linalg.norm(camera.real.equilibrium.platform_position[:2] - SETPOINT)
    print(f"noise of 1 mm at 200 Hz: off by {off:.1e} m")
    assert off < 1.5e-3
    assert camera.metrics.action == StabilityMetrics.ACTION_NONE
    camera.check_commands()
    assert camera.set_parameters(measured_pose_timeout=0.5).successful


def test_a_goal_that_is_cancelled_tells_of_the_way_it_was_on(camera):
    """Its feedback told of the way to the corrected goal, its result of the way to another place."""
    camera.send_platform(*SETPOINT)
    camera.measure(50.0)
    camera.until_met(1e-5)
    # So slow that feedback and result, which come in any order, tell of the same way, however late.
    assert camera.set_parameters(max_speed=0.0005).successful
    goals = GoalClient(camera.client, MoveTo, "/cpr_node/move_to")
    target = PoseStamped()
    target.pose.position.x, target.pose.position.y = SETPOINT + [0.0, -0.1]
    try:
        handle = goals.send(given=MoveTo.Goal.GIVEN_POSE, platform=target, patience=1.0)
        camera.client.spin_until(lambda: len(goals.feedback) > 3)
        goals.cancel(handle)
        result = goals.result(handle).result
    finally:
        goals.close()
        assert camera.set_parameters(max_speed=SPEED).successful
    assert result.error_code.val == ErrorCode.PREEMPTED
    assert result.remaining == pytest.approx(goals.feedback[-1].remaining, abs=5e-3)


@pytest.fixture
def goals(camera):
    made = GoalClient(camera.client, MoveTo, "/cpr_node/move_to")
    yield made
    made.close()


def at_setpoint(**fields):
    """A goal there."""
    target = PoseStamped()
    target.pose.position.x, target.pose.position.y = SETPOINT
    return {"given": MoveTo.Goal.GIVEN_POSE, "platform": target, "patience": 10.0} | fields


def test_a_goal_with_a_tolerance_is_reached_where_it_is_measured(camera, goals):
    """It was said to be reached where the model was, and the robot was centimetres away."""
    # None is stale while this process, which is the camera, is held up.
    assert camera.set_parameters(measured_pose_timeout=600.0).successful
    camera.measure(50.0)
    camera.until(lambda: camera.metrics.measured_pose_age >= 0.0)
    without = goals.result(goals.send(**at_setpoint())).result
    assert without.error_code.val == ErrorCode.SUCCESS
    assert without.position_error > 0.01
    camera.client.spin_until(lambda: any(told.position_error > 0.01 for told in goals.feedback))
    result = goals.result(goals.send(**at_setpoint(position_tolerance=1e-5))).result
    assert result.error_code.val == ErrorCode.SUCCESS
    assert 0.0 <= result.position_error <= 1e-5
    assert np.isnan(result.rotation_error)  # this robot controls none
    camera.obey()
    off = np.linalg.norm(camera.real.equilibrium.platform_position[:2] - SETPOINT)
    assert off < 1e-4  # the loop goes on
    # How much is left when the first of them comes depends on how busy the machine is: the loop goes on.
    errors = [message.position_error for message in goals.feedback]
    assert not np.isnan(errors).any()
    camera.check_commands()
    assert camera.set_parameters(measured_pose_timeout=0.5).successful


def test_a_goal_that_cannot_be_measured_is_given_up_with_the_reason(camera, goals):
    def given_up(**fields):
        result = goals.result(goals.send(**at_setpoint(**fields))).result
        assert result.error_code.val == ErrorCode.CONTROL_FAILED
        return result.error_code.message

    text = "not measured at its target for 0.1 s: "
    # One that was measured at this place before is none of now, even while it is not stale.
    camera.send_platform(*SETPOINT)
    camera.measure(50.0)
    camera.until_met(1e-5)
    camera.measure(0)
    camera.go_home()
    said = given_up(position_tolerance=1e-4, patience=0.1)
    assert said.startswith(text + "the measured pose is") and "measured_pose_timeout 0.5 s" in said
    camera.measure(50.0)
    camera.send_platform(*SETPOINT)
    camera.until_met(1e-5)
    camera.changed = not_a_number
    camera.until_frozen("all finite")
    assert "all finite" in given_up(position_tolerance=1e-5, patience=0.1)
    # It holds; who asks for nothing measured is there.
    result = goals.result(goals.send(**at_setpoint())).result
    assert result.error_code.val == ErrorCode.SUCCESS
    camera.check_commands()


def test_commands_that_are_aligned_are_no_reason_to_give_a_goal_up(camera, goals):
    """In the tick that aligned them it was said that they were on their way, to who had no patience."""
    slow = {"max_speed": 0.5, "measured_pose_timeout": 10.0}
    assert camera.set_parameters(**slow).successful
    camera.measure(50.0)
    motors = JointState(name=["motor1", "motor2"], position=[2.8, 0.35])
    try:
        request = SolveForward.Request(motors=motors, apply=True)
        answer = camera.client.call(SolveForward, "/cpr_node/solve_forward", request)
        pose = PoseStamped(pose=answer.solution.platform_in_base)
        wanted = {"platform": pose, "position_tolerance": 0.2, "patience": 0.0}
        result = goals.result(goals.send(given=MoveTo.Goal.GIVEN_POSE, **wanted)).result
    finally:
        usual = {"max_speed": SPEED, "measured_pose_timeout": 0.5}
        assert camera.set_parameters(**usual).successful
    assert result.error_code.val == ErrorCode.SUCCESS, result.error_code.message
    camera.client.spin_until(  # the result may be taken before the stream
        lambda: any(told.state == told.STATE_ALIGNING for told in camera.all(StabilityMetrics))
    )
    camera.check_commands()


def test_the_platform_is_jogged_into_a_halt_and_back(rfrfr, camera):
    camera.send_platform(0.0, 0.2)
    camera.until(lambda: np.allclose(camera.position[:2], [0.0, 0.2], rtol=0.0, atol=1e-9))
    camera.twist(lambda: camera.position[1] < 0.18, y=-0.1)
    camera.until_state(StabilityMetrics.STATE_IDLE)  # no twist any more: it holds
    rest = camera.position
    camera.twist(lambda: camera.metrics.state == StabilityMetrics.STATE_HALTED, y=-0.2)
    assert camera.position[1] < rest[1]
    assert 0.05 <= camera.metrics.margin < 0.06
    back = camera.position[1] + 0.02
    # This platform is a point and does not turn.
    camera.twist(lambda: camera.position[1] > back, "platform", y=0.2)
    camera.until_state(StabilityMetrics.STATE_IDLE)
    camera.check_commands()
    refused = "expected linear.x linear.y only, as the robot controls x y; got linear.z as well"
    camera.twist(lambda: refused in rfrfr.process.output(), z=0.1)


PAGE = Path(__file__).parents[3] / "docs/node.md"


@pytest.mark.parametrize(
    ("section", "said"),
    [("Closed loop", "the measured platform is there"), ("Jogging", "jogged for a second")],
)
def test_the_program_of_the_page_does_what_it_says(rfrfr, camera, section, said):
    """As it is on the page, in a process of its own."""
    _, _, text = PAGE.read_text(encoding="utf-8").partition(f"\n## {section}\n")
    [program] = re.findall(r"```python\n(.*?)```", text.partition("\n## ")[0], re.DOTALL)
    camera.measure(50.0)
    camera.until(lambda: True)
    begun = camera.position
    running = subprocess.Popen(
        [sys.executable, "-c", program],
        env=os.environ | {"ROS_DOMAIN_ID": str(rfrfr.client.context.get_domain_id())},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        camera.client.spin_until(lambda: running.poll() is not None, timeout=3.0 * TIMEOUT)
    finally:
        running.kill()
    output, _ = running.communicate()
    assert running.returncode == 0, output
    assert said in output
    camera.until(lambda: camera.position[0] > begun[0] + 1e-4)  # a busy machine moves it less
    camera.check_commands()
