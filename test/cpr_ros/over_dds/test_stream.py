# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The stability stream, external wrench, description, markers: what a supervisor and rviz see."""

import itertools
import math
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from cpr_msgs.msg import StabilityMetrics
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, WrenchStamped
from helpers.driver import Driver
from helpers.node_process import running_node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

import cpr_core
from cpr_core import solve_home
from cpr_core.description.description_file import shipped_robots

pytestmark = pytest.mark.waits(seconds=50)

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_metrics_are_those_of_the_library(six_rfs):
    metrics = six_rfs.client.messages(StabilityMetrics, "/cpr_node/stability", 2)[-1]
    home = solve_home(cpr_core.load_robot("six_rfs"))
    model = cpr_core.kinemato_statics(home)
    for name in ("forward", "inverse"):
        expected, told = model.singularity(name), getattr(metrics, name)
        assert told.smallest_singular_value == pytest.approx(expected.smallest, rel=1e-6)
        assert told.inverse_condition_number == pytest.approx(expected.inverse_condition_number)
        assert told.sign == expected.sign
    order = [3, 4, 5, 0, 1, 2]
    expected = model.stiffness()[np.ix_(order, order)]
    np.testing.assert_allclose(metrics.stiffness.reshape(6, 6), expected, rtol=1e-6, atol=1e-6)
    assert metrics.characteristic_length == 1.0
    assert (metrics.motor_range, metrics.effort_reserve) == (math.inf, math.inf)
    assert metrics.nearest_threshold == "margin"
    assert metrics.distance_to_threshold == pytest.approx((metrics.margin - 0.05) / 0.15)
    assert metrics.state == StabilityMetrics.STATE_IDLE
    assert (metrics.setpoint_age, metrics.wrench_age) == (-1.0, -1.0)
    assert metrics.margin_trend == 0.0


def test_the_stream_comes_in_every_state(drive):
    def assert_it_comes(state):
        drive.until(lambda: len(drive.all(StabilityMetrics)) >= 10)
        assert {metrics.state for metrics in drive.all(StabilityMetrics)} == {state}

    assert_it_comes(StabilityMetrics.STATE_IDLE)
    drive.pause(True)
    drive.until_state(StabilityMetrics.STATE_PAUSED)
    assert_it_comes(StabilityMetrics.STATE_PAUSED)
    drive.pause(False)
    drive.send_platform(0.0, 3.0)
    drive.until_state(StabilityMetrics.STATE_HALTED)
    assert_it_comes(StabilityMetrics.STATE_HALTED)


def test_a_supervisor_hears_of_another_action_out_of_turn(tmp_path):
    """On the way the action is SLOW for less than the 5 s between two messages."""
    with running_node(tmp_path, "robot:=rfrfr", "stability_rate:=0.2") as node:
        drive = Driver(node.client)
        drive.send_platform(0.0, 3.0)
        drive.until(lambda: drive.metrics.action == StabilityMetrics.ACTION_HALT)
        told = [metrics.action for metrics in drive.all(StabilityMetrics)]
        drive.close()
    slow, halt = StabilityMetrics.ACTION_SLOW, StabilityMetrics.ACTION_HALT
    assert [action for action, _ in itertools.groupby(told) if action] == [slow, halt]


def test_a_supervisor_hears_out_of_turn_that_a_wrench_is_missed(tmp_path):
    """That the robot is to be slow was told with the next message, 10 s later."""
    with running_node(tmp_path, "robot:=rfrfr", "stability_rate:=0.1") as node:
        drive = Driver(node.client)
        pushed = WrenchStamped()
        pushed.wrench.force.y = -0.05
        drive.spin(0.5)
        before, home = drive.metrics, drive.position

        def acts():
            drive.wrench.publish(pushed)
            return not np.array_equal(drive.position, home)

        drive.client.spin_until(acts)
        drive.client.spin_until(lambda: drive.metrics.action == StabilityMetrics.ACTION_SLOW)
        after = drive.metrics
        drive.close()
    assert before.action == StabilityMetrics.ACTION_NONE
    assert "the external wrench is older than wrench_timeout 0.5 s" in after.status_text
    waited = after.header.stamp.sec - before.header.stamp.sec
    assert waited < 9, "the next message came in turn"


def test_the_action_does_not_chatter_while_the_robot_trembles_about_a_threshold(drive):
    """The margin crosses the warning threshold 40 times; the action changes once."""
    drive.send_platform(0.0, 0.114)  # margin just below 0.2
    drive.until(lambda: np.allclose(drive.position[:2], [0.0, 0.114], atol=1e-8))
    drive.until_state(StabilityMetrics.STATE_IDLE)
    crossings, actions, margins = 0, [], []
    for k in range(40):
        y = 0.114 + 0.0008 * (-1) ** k
        drive.send_platform(0.0, y)
        drive.until(lambda y=y: np.allclose(drive.position[1], y, atol=1e-8))
        actions += [metrics.action for metrics in drive.all(StabilityMetrics)]
        margins.append(drive.metrics.margin)
    crossings = np.count_nonzero(np.diff(np.array(margins) > 0.2))
    assert crossings > 10
    assert np.count_nonzero(np.diff(actions)) <= 1


def test_diagnostics_follow_the_action(drive):
    def level():
        array = drive.client.messages(DiagnosticArray, "/diagnostics", 2)[-1]
        return next(e.level for e in array.status if e.name == "/cpr_node: stability")

    assert level() == DiagnosticStatus.OK
    drive.send_platform(0.0, -0.2)
    drive.until_state(StabilityMetrics.STATE_HALTED)
    assert level() == DiagnosticStatus.ERROR
    drive.send_platform(0.0, 0.1)
    drive.until_state(StabilityMetrics.STATE_IDLE)
    assert level() == DiagnosticStatus.WARN


def test_dropped_messages_are_counted_in_diagnostics(drive):
    drive.send_motors(math.nan, 1.0)
    drive.spin(1.2)
    array = drive.client.messages(DiagnosticArray, "/diagnostics", 2)[-1]
    values = {value.key: value.value for value in array.status[0].values}
    assert int(values["dropped ~/motor_setpoint"]) >= 1
    assert int(values["late ticks"]) >= 0


def latched(running, kind, topic):
    """What was published long before anybody asked."""
    client, heard = running.client, []
    subscription = client.node.create_subscription(kind, topic, heard.append, LATCHED)
    client.spin_until(lambda: bool(heard))
    client.node.destroy_subscription(subscription)
    (message,) = heard
    return message


def test_the_description_is_latched(rfrfr):
    text = latched(rfrfr, String, "/cpr_node/description").data
    assert text == shipped_robots()["rfrfr"].read_text()
    assert yaml.safe_load(text)["name"] == "rfrfr"


def test_the_urdf_is_latched_with_the_motors_of_the_joint_states(rfrfr):
    root = ElementTree.fromstring(latched(rfrfr, String, "/cpr_node/robot_description").data)
    joints = {joint.get("name"): joint.get("type") for joint in root.findall("joint")}
    state = rfrfr.client.messages(JointState, "/joint_states", 1)[0]
    assert {name: joints[name] for name in state.name} == dict.fromkeys(state.name, "continuous")
    pose = rfrfr.client.messages(PoseStamped, "/cpr_node/platform_pose", 1)[0]
    assert pose.header.frame_id in {link.get("name") for link in root.findall("link")}


def test_home_is_latched_wherever_the_robot_is(drive, rfrfr):
    drive.send_motors(2.7, 0.4)
    drive.until(lambda: np.array_equal(drive.motors, [2.7, 0.4]))
    home = solve_home(cpr_core.load_robot("rfrfr"))
    state = latched(rfrfr, JointState, "/cpr_node/home")
    assert list(state.name) == ["motor1", "motor2"]
    np.testing.assert_array_equal(state.position, home.motors)
    np.testing.assert_allclose(state.effort, home.efforts, atol=1e-9)
    pose = latched(rfrfr, PoseStamped, "/cpr_node/home_pose")
    point = pose.pose.position
    np.testing.assert_allclose([point.x, point.y, point.z], home.platform_position, atol=1e-9)
    assert pose.header.frame_id == "base"


def test_halts_and_thresholds_are_in_the_log_once(drive, rfrfr):
    before = len(rfrfr.process.output())
    assert drive.set_parameters(margin_stop=0.06).successful
    drive.send_platform(0.0, -0.2)
    drive.until_state(StabilityMetrics.STATE_HALTED)
    drive.until(lambda: len(drive.all(StabilityMetrics)) >= 10)
    assert drive.set_parameters(margin_stop=0.05).successful
    drive.until_state(StabilityMetrics.STATE_IDLE)  # the setpoint is forgotten
    drive.go_home()
    drive.client.spin_until(lambda: "the halt is over" in rfrfr.process.output()[before:])
    said = rfrfr.process.output()[before:]
    assert said.count("set: margin_stop 0.06") == 1
    assert said.count("halt (HALTED, HALT_FOR_STABILITY): the next margin, ") == 1
    assert said.count("set: margin_stop 0.05\n") == 1
    assert said.count("on the way home") == 1
    assert said.count("the halt is over") == 1


def test_dropped_messages_are_a_warning_in_the_next_diagnostics_only(drive, rfrfr):
    arrays = []

    def told():
        """Level, message and how many setpoints were dropped in all."""
        entry = next(status for status in arrays[-1].status if status.name == "/cpr_node: node")
        values = {value.key: value.value for value in entry.values}
        return entry.level, entry.message, int(values.get("dropped ~/motor_setpoint", 0))

    subscription = rfrfr.client.node.create_subscription(
        DiagnosticArray, "/diagnostics", arrays.append, 100
    )
    rfrfr.client.spin_until(lambda: arrays and told()[0] == DiagnosticStatus.OK)
    count = told()[2]
    drive.send_motors(math.nan, 0.5)
    rfrfr.client.spin_until(lambda: told()[0] == DiagnosticStatus.WARN)
    assert told()[1:] == (
        "active; messages dropped since the last diagnostics: 1 of ~/motor_setpoint",
        count + 1,
    )
    rfrfr.client.spin_until(lambda: told()[0] == DiagnosticStatus.OK)
    assert told()[1:] == ("active", count + 1)
    rfrfr.client.node.destroy_subscription(subscription)


def test_leg_markers_follow_the_legs(six_rfs):
    markers = six_rfs.client.messages(MarkerArray, "/cpr_node/leg_markers", 1)[0].markers
    legs = [marker for marker in markers if marker.ns == "legs"]
    assert len(legs) == 6
    robot = cpr_core.load_robot("six_rfs")
    for marker, shape in zip(legs, cpr_core.leg_shapes(solve_home(robot), 24), strict=True):
        assert marker.type == Marker.LINE_STRIP
        assert marker.header.frame_id == "base"
        points = [[point.x, point.y, point.z] for point in marker.points]
        np.testing.assert_allclose(points, shape.position, atol=1e-8)
        assert len(marker.colors) == len(marker.points)
    outline = next(marker for marker in markers if marker.ns == "platform")
    assert len(outline.points) == 7
    sides = np.diff([[p.x, p.y, p.z] for p in outline.points], axis=0)
    lengths = np.sort(np.linalg.norm(sides, axis=1))
    np.testing.assert_allclose(lengths, [0, 0, 0, *[0.1 * np.sqrt(3.0)] * 3], atol=1e-9)


def test_poses_and_joint_states_are_reliable(rfrfr):
    node = rfrfr.client.node
    for topic in ("/joint_states", "/cpr_node/platform_pose", "/cpr_node/stability"):
        # Discovery may go on yet.
        rfrfr.client.spin_until(lambda topic=topic: node.count_publishers(topic) > 0)
        (publisher,) = node.get_publishers_info_by_topic(topic)
        assert publisher.qos_profile.reliability.name == "RELIABLE", topic
    assert rfrfr.client.messages(PoseStamped, "/cpr_node/platform_pose", 1)
