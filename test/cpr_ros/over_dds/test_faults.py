# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What other processes do wrong: the node stays correct, and says what it dropped."""

import math
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from cpr_msgs.action import FollowTrajectory, MapWorkspace, MoveTo
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from geometry_msgs.msg import WrenchStamped
from helpers.driver import Driver, pose_at
from helpers.goal_client import GoalClient
from helpers.imported_node import imported_node
from helpers.map_client import LONG, map_axes
from helpers.node_process import TIMEOUT, Client, NodeProcess, free_domain, running_node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import cpr_core

pytestmark = pytest.mark.waits(seconds=55)

HOME = [2.59, 0.55]
NAMES = ["motor1", "motor2"]


def bad_messages():
    nan, inf = math.nan, math.inf
    far_frame = pose_at(0.0, 0.5)
    far_frame.header.frame_id = "camera"
    wrench_frame, nan_wrench, lifted = WrenchStamped(), WrenchStamped(), WrenchStamped()
    wrench_frame.header.frame_id = "camera"
    nan_wrench.wrench.force.x = nan
    lifted.wrench.force.z = 1.0
    return {
        "NaN motor": ("motor_setpoint", JointState(name=NAMES, position=[nan, 1.0])),
        "infinite motor": ("motor_setpoint", JointState(name=NAMES, position=[1.0, inf])),
        "NaN in one of two": ("motor_setpoint", JointState(name=NAMES, position=[2.7, nan])),
        "unknown name": ("motor_setpoint", JointState(name=["elbow"], position=[1.0])),
        "duplicate name": (
            "motor_setpoint",
            JointState(name=["motor1", "motor1"], position=[2.6, 2.7]),
        ),
        "no name": ("motor_setpoint", JointState()),
        "too few positions": ("motor_setpoint", JointState(name=NAMES, position=[2.7])),
        "too many positions": ("motor_setpoint", JointState(name=NAMES, position=[2.7, 0.4, 0.1])),
        "efforts only": ("motor_setpoint", JointState(name=NAMES, effort=[1.0, 1.0])),
        "short command": ("commands", Float64MultiArray(data=[2.7])),
        "long command": ("commands", Float64MultiArray(data=[2.7, 0.4, 0.4])),
        "empty command": ("commands", Float64MultiArray()),
        "NaN command": ("commands", Float64MultiArray(data=[2.7, nan])),
        "NaN platform": ("platform", pose_at(nan, 0.5)),
        "infinite platform": ("platform", pose_at(0.0, -inf)),
        "platform in another frame": ("platform", far_frame),
        "wrench in another frame": ("wrench", wrench_frame),
        "NaN wrench": ("wrench", nan_wrench),
        "wrench out of the plane": ("wrench", lifted),
    }


@pytest.mark.parametrize("case", bad_messages())
def test_a_bad_message_is_dropped_whole_and_warned_about(rfrfr, drive, case):
    publisher, message = bad_messages()[case]
    before = rfrfr.process.output().count("dropped:")
    for _ in range(20):  # one line a second at most: one of these is said
        getattr(drive, publisher).publish(message)
        drive.spin(0.1)
        if rfrfr.process.output().count("dropped:") > before:
            break
    else:
        raise AssertionError(f"nothing in the log:\n{rfrfr.process.output()}")
    drive.until(lambda: len(drive.all(JointState)) > 3)
    assert drive.metrics.state == StabilityMetrics.STATE_IDLE
    assert drive.metrics.setpoint_age == -1.0  # no watchdog was fed
    assert drive.metrics.wrench_age == -1.0
    np.testing.assert_array_equal(drive.motors, HOME)


@pytest.mark.parametrize("seconds", [0, 1, 4_000_000_000 // 2])
def test_stamps_of_the_past_and_the_future_decide_nothing(drive, seconds):
    assert drive.set_parameters(setpoint_timeout=0.5).successful
    try:
        message = JointState(name=NAMES, position=[2.62, 0.52])
        message.header.stamp.sec = seconds
        drive.motor_setpoint.publish(message)
        drive.until(lambda: np.array_equal(drive.motors, [2.62, 0.52]))
        drive.until(lambda: drive.metrics.setpoint_age >= 0.0)  # another topic, 20 times a second
        assert drive.metrics.setpoint_age < 5.0
    finally:
        assert drive.set_parameters(setpoint_timeout=0.0).successful


def test_a_timeout_of_zero_makes_nothing_stale(drive):
    assert drive.set_parameters(setpoint_timeout=0.0, max_speed=0.05).successful
    try:
        drive.send_motors(2.64, 0.55)
        drive.until(lambda: np.array_equal(drive.motors, [2.64, 0.55]), forget=False)
        states = {metrics.state for metrics in drive.all(StabilityMetrics)}
        assert StabilityMetrics.STATE_FOLLOWING in states
        assert StabilityMetrics.STATE_STALE not in states
    finally:
        assert drive.set_parameters(max_speed=4.0).successful


def test_wrenches_that_are_not_borne_do_not_make_the_node_deaf(tmp_path):
    """Pauses waited behind wrenches that came faster than they were found not to be borne."""
    with running_node(tmp_path, "robot:=six_rfs", "wrench_timeout:=600.0") as running:
        drive, sent = Driver(running.client), []

        def push():
            wrench = WrenchStamped()
            wrench.wrench.torque.x = 1.0 + 1e-6 * len(sent)
            drive.wrench.publish(wrench)
            sent.append(wrench)

        pushing = drive.client.node.create_timer(0.01, push)
        drive.until(lambda: drive.metrics.action == StabilityMetrics.ACTION_HALT)
        for paused in (True, False, True):
            assert drive.pause(paused).success
        drive.until_state(StabilityMetrics.STATE_PAUSED)
        assert drive.metrics.action == StabilityMetrics.ACTION_HALT
        assert "is not borne" in drive.metrics.status_text
        drive.client.node.destroy_timer(pushing)
        assert drive.set_parameters(wrench_timeout=0.5).successful
        drive.until(lambda: drive.metrics.action == StabilityMetrics.ACTION_SLOW)
        assert "older than wrench_timeout" in drive.metrics.status_text
        drive.close()


DYING = """
import cpr_ros, os, rclpy, signal
from cpr_msgs.srv import SolveInverse
rclpy.init()
node = rclpy.create_node("dying")
client = node.create_client(SolveInverse, "/cpr_node/solve_inverse")
assert client.wait_for_service(20.0)
for _ in range(200):
    client.call_async(SolveInverse.Request())
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_client_that_dies_in_mid_call_harms_nobody(rfrfr, drive):
    for _ in range(3):
        dying = subprocess.run(
            [sys.executable, "-c", DYING],
            env=os.environ | {"ROS_DOMAIN_ID": str(rfrfr.client.context.get_domain_id())},
            timeout=60,
        )
        assert dying.returncode == -signal.SIGKILL
    expected = cpr_core.solve_forward(cpr_core.load_robot("rfrfr"), [2.7, 0.5]).platform_position
    drive.assert_correct(2.7, 0.5, expected=expected)


def test_an_unreachable_pose_halts_at_the_end_of_the_branch(drive):
    drive.send_platform(0.0, 3.0)
    drive.until_state(StabilityMetrics.STATE_HALTED)
    assert drive.metrics.action == StabilityMetrics.ACTION_HALT
    assert drive.metrics.index_locked == 0
    assert 0.9 < drive.position[1] < 0.981  # two rods of 1 m, 0.4 m apart
    drive.send_platform(0.0, 0.8)
    drive.until(lambda: np.allclose(drive.position[:2], [0.0, 0.8], atol=1e-8))


def test_parameter_changes_during_motion_hold_at_once(drive):
    assert drive.set_parameters(max_speed=0.02).successful  # on its way, however late this is
    drive.send_platform(0.0, 0.3)
    drive.until(lambda: not np.array_equal(drive.motors, HOME))
    assert drive.set_parameters(margin_warning=0.99, margin_stop=0.98).successful
    try:
        drive.until_state(StabilityMetrics.STATE_HALTED)
        assert drive.position[1] > 0.3 + 1e-3  # on its way, not at its end
        assert drive.metrics.status == StabilityMetrics.STATUS_HALT_FOR_STABILITY
        refused = drive.set_parameters(margin_warning=0.1, margin_stop=0.3)
        assert not refused.successful
        assert drive.metrics.margin_stop == 0.98
        for wrong in ({"max_speed": 0.0}, {"hysteresis": math.nan}, {"setpoint_timeout": -1.0}):
            assert not drive.set_parameters(**wrong).successful
    finally:
        usual = {"margin_warning": 0.2, "margin_stop": 0.05, "max_speed": 4.0}
        assert drive.set_parameters(**usual).successful
    # Nothing sets off because a threshold lets it: the setpoint was forgotten.
    drive.until_state(StabilityMetrics.STATE_IDLE)
    assert drive.position[1] > 0.3 + 1e-3
    drive.send_platform(0.0, 0.3)
    drive.until(lambda: np.allclose(drive.position[:2], [0.0, 0.3], atol=1e-8))


def test_thresholds_of_every_measure_are_checked(drive):
    for measure in (
        "margin",
        "forward_singularity",
        "inverse_singularity",
        "motor_range",
        "effort_reserve",
        "strain_reserve",
    ):
        refused = drive.set_parameters(**{f"{measure}_warning": 0.1, f"{measure}_stop": 0.2})
        assert not refused.successful
        assert f"{measure}_stop below {measure}_warning" in refused.reason


def test_an_incompatible_quality_of_service_is_logged(rfrfr):
    node = rfrfr.client.node
    careless = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(JointState, "/cpr_node/motor_setpoint", careless)
    try:
        rfrfr.process.wait_for_log("incompatible QoS", timeout=TIMEOUT)
        assert "motor_setpoint'," in rfrfr.process.output()
    finally:
        node.destroy_publisher(publisher)


@pytest.fixture(scope="module")
def failing(tmp_path_factory):
    """A node that fails between calls of /fail and /work."""
    folder, values = tmp_path_factory.mktemp("failing"), ("robot:=rfrfr", "map_anywhere:=true")
    with running_node(folder, *values, module="helpers.failing_node") as running:
        yield running


def test_a_solver_that_fails_halts_the_robot_and_it_goes_on_afterwards(failing):
    client = failing.client
    drive = Driver(client)
    assert client.call(Trigger, "/fail", Trigger.Request()).success
    drive.send_motors(2.7, 0.5)
    drive.until_state(StabilityMetrics.STATE_HALTED)
    assert drive.metrics.status == StabilityMetrics.STATUS_NOT_CONVERGED
    assert "forced by a test" in drive.metrics.status_text
    np.testing.assert_array_equal(drive.motors, HOME)
    answer = drive.forward(2.7, 0.5)
    assert answer.error_code.val == ErrorCode.FAILURE
    assert client.call(Trigger, "/work", Trigger.Request()).success
    drive.until(lambda: np.array_equal(drive.motors, [2.7, 0.5]))
    assert drive.forward(2.7, 0.5).error_code.val == ErrorCode.SUCCESS
    drive.close()


@pytest.mark.parametrize("which", ["move_to", "follow_trajectory", "map_workspace"])
def test_a_callback_of_an_action_that_fails_harms_neither_node_nor_goal(failing, which, tmp_path):
    """What a cancel raised ended the node with a segmentation fault."""
    client, name = failing.client, f"/cpr_node/{which}"
    if which == "move_to":
        goals = GoalClient(client, MoveTo, name)
        fields = {"given": MoveTo.Goal.GIVEN_MOTORS, "patience": 1e3}  # it is halted while it fails
        fields["motors"] = JointState(name=NAMES[:1], position=[12.0])
    elif which == "follow_trajectory":
        goals = GoalClient(client, FollowTrajectory, name)
        now = client.messages(JointState, "/joint_states", 1)[0]
        late = JointTrajectoryPoint(positions=now.position, time_from_start=Duration(sec=60))
        fields = {"trajectory": JointTrajectory(joint_names=now.name, points=[late])}
    else:
        goals = GoalClient(client, MapWorkspace, name)
        fields = {"axes": map_axes(LONG), "file": str(tmp_path / "map.nc"), "workers": 1}

    def failing_now(does):
        assert client.call(Trigger, "/fail", Trigger.Request()).success
        try:
            return does()
        finally:
            assert client.call(Trigger, "/work", Trigger.Request()).success

    refused = failing_now(lambda: goals.result(goals.send(**fields)))
    assert refused.status == GoalStatus.STATUS_ABORTED
    assert refused.result.error_code.val == ErrorCode.FAILURE
    assert "forced by a test" in refused.result.error_code.message
    handle = goals.send(**fields)
    assert failing_now(lambda: goals.cancel(handle)) == 0  # nothing was, and that is said
    assert failing.process.output().count("ArithmeticError: forced by a test") >= 2
    # The goal is still on its way, and can be cancelled.
    assert goals.cancel(handle) == 1
    done = goals.result(handle)
    assert done.status == GoalStatus.STATUS_CANCELED
    assert done.result.error_code.val == ErrorCode.PREEMPTED
    goals.close()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_the_middle_of_motion_ends_the_node_cleanly(tmp_path, how):
    domain = free_domain()
    process = NodeProcess(tmp_path / "node.log", domain, ["-p", "robot:=rfrfr"])
    process.wait_for_log("ready")
    client = Client(domain)
    try:
        drive = Driver(client)
        drive.send_platform(0.0, 0.1)
        drive.until_state(StabilityMetrics.STATE_FOLLOWING)
        assert process.stop(how) == 0
        assert "Traceback" not in process.output()
    finally:
        client.close()
        process.process.kill()


@pytest.fixture(scope="module")
def imported():
    with imported_node() as original:
        yield original


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_at_any_time_ends_the_node_cleanly(tmp_path, imported, how):
    """From the first line of the log on; before that, a signal ends Python in Python's own way."""
    arguments = ["-p", "robot:=rfrfr"]
    for number, delay in enumerate([0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8]):
        log = tmp_path / f"node{number}.log"
        process = NodeProcess(log, free_domain(), arguments, imported=imported)
        process.wait_for_log("motors motor1")
        time.sleep(delay)
        assert process.stop(how) == 0, process.output()
        assert "Traceback" not in process.output()


def test_a_signal_that_a_library_turns_into_an_error_ends_the_node_cleanly(tmp_path):
    process = NodeProcess(
        tmp_path / "node.log", free_domain(), ["-p", "robot:=rfrfr"], module="helpers.deaf_node"
    )
    assert process.process.wait(timeout=60) == 0, process.output()
    assert "Traceback" not in process.output()
    assert "missing" not in process.output()


def test_a_killed_node_is_found_again_by_running_clients(tmp_path):
    domain = free_domain()
    arguments = ["-p", "robot:=rfrfr"]
    first = NodeProcess(tmp_path / "first.log", domain, arguments)
    client = Client(domain)
    try:
        first.wait_for_log("ready")
        drive = Driver(client)
        drive.send_motors(2.65, 0.5)
        drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.5]))
        first.process.kill()
        first.process.wait()
        second = NodeProcess(tmp_path / "second.log", domain, arguments)
        try:
            second.wait_for_log("ready")
            # The same publishers, subscriptions and clients.
            drive.until(lambda: np.array_equal(drive.motors, HOME))
            end = time.monotonic() + TIMEOUT
            while not np.array_equal(drive.motors, [2.65, 0.5]):
                assert time.monotonic() < end
                drive.send_motors(2.65, 0.5)  # until it has been discovered
                drive.spin(0.1)
            assert drive.forward(*HOME).error_code.val == ErrorCode.SUCCESS
        finally:
            assert second.stop() == 0
    finally:
        client.close()
        first.process.kill()
