# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the page of a node makes of the messages it hears, and sends; nobody is there to hear or tell."""

import math
import time
from types import SimpleNamespace

import numpy as np
import pytest
import rclpy
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from helpers.markers import markers_of
from helpers.node_process import free_domain
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import String

import cpr_core
from cpr_ros.page.view_node import ViewNode
from cpr_ros.setpoint_topics import MOTOR_SETPOINT


@pytest.fixture
def shown():
    rclpy.init(domain_id=free_domain(), signal_handler_options=SignalHandlerOptions.NO)
    node = ViewNode("cpr_node", "127.0.0.1", 0)
    yield node
    node.page.close()
    node.destroy_node()
    rclpy.shutdown()


class Publisher:
    """One of setpoints that is, or is not yet, connected."""

    def __init__(self):
        self.connected, self.sent = 0, []

    def get_subscription_count(self):
        return self.connected

    def publish(self, message):
        self.sent.append((list(message.name), list(message.position)))


def test_what_is_asked_waits_until_somebody_hears_it_and_ends_with_the_control(shown, monkeypatch):
    publisher, destroyed = Publisher(), []
    monkeypatch.setattr(shown, "create_publisher", lambda *_: publisher)
    monkeypatch.setattr(shown, "destroy_publisher", destroyed.append)
    robot = shown._robot = cpr_core.load_robot("rfrfr")
    shown.page.show_robot(robot, [2.5, 0.5])
    shown.page._control.take()
    shown.page._slid(1, 0.25)
    shown._send()
    assert publisher.sent == []
    publisher.connected = 1
    shown._send()
    shown._send()
    assert publisher.sent == [(["motor2"], [0.25])]
    assert shown.page._words.content == "sent: motor2 to 0.25"
    shown.page._control.give_back()
    for _ in range(2):
        shown._send()
        assert destroyed == [publisher] and shown._setpoint is None


def test_motors_are_heard_of_the_robot_that_is_described(shown):
    text = cpr_core.load_robot("rfrfr").description.text
    names = ["motor1", "motor2"]
    shown._hear_motors(JointState(name=names, position=[2.5, 0.5]))  # whose, is not known yet
    shown._hear_description(String(data=text))
    for name, position in (
        (["motor1", "motor3"], [2.5, 0.5]),
        (names[::-1], [2.5, 0.5]),
        (names, [2.5]),
        (names, [2.5, math.nan]),
    ):
        shown._hear_motors(JointState(name=name, position=position))
        assert "motors" not in shown._newest
    shown._hear_motors(JointState(name=names, position=[2.5, 0.5]))
    assert shown._newest["motors"] == [2.5, 0.5]
    shown._draw()
    assert shown._shown
    shown._hear_description(String(data=text))  # said again, to whoever comes later
    assert shown._shown and "motors" in shown._newest
    shown._hear_description(String(data="no robot"))
    assert not shown._shown and "motors" not in shown._newest and shown._robot is None
    assert "cannot be read" in shown.page._words.content


def test_platform_and_legs_are_where_the_node_has_them(shown, rfrfr):
    shown._robot = cpr_core.load_robot("rfrfr")
    message = PoseStamped()
    at, turn = message.pose.position, message.pose.orientation
    at.x, at.y, at.z = 0.1, 0.2, 0.3
    turn.w, turn.x, turn.y, turn.z = 0.1, 0.5, 0.5, 0.7
    shown._newest |= {"motors": [2.5, 0.5], "platform": message}
    shown._newest["markers"] = markers_of(rfrfr.tick(), "stability")
    shown._draw()
    assert "/robot/legs" in shown.page._server.scene._handle_from_node_name
    platform = shown.page._platform._frame
    np.testing.assert_array_equal(platform.position, [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(platform.wxyz, [0.1, 0.5, 0.5, 0.7])


def test_others_who_send_setpoints_are_told_in_one_order(shown, monkeypatch):
    """However the middleware finds them: else the words would change all the time."""
    names = ["b", "cpr_view", "a"]
    found = [SimpleNamespace(node_namespace="/", node_name=name) for name in names]
    monkeypatch.setattr(
        shown,
        "get_publishers_info_by_topic",
        lambda topic: found if topic == f"cpr_node/{MOTOR_SETPOINT}" else [],
    )
    told = [f"/a ({MOTOR_SETPOINT})", f"/b ({MOTOR_SETPOINT})"]
    assert shown._others() == [*told, f"/cpr_view ({MOTOR_SETPOINT}, another page)"]
    shown._setpoint = Publisher()  # its own
    assert shown._others() == told
    shown._setpoint = None


def test_what_is_near_its_threshold_is_told_by_words_and_bars(shown):
    near = StabilityMetrics(
        margin=0.15, margin_warning=0.2, margin_stop=0.1, status_text="slow", action=1
    )
    near.nearest_threshold, near.distance_to_threshold = "motor_range", 0.25
    shown._keeping("stability")(near)
    shown._draw()
    assert "slow; nearest to its threshold: motor\\_range" in shown.page._action_text.content
    told = [(label.content, filled.value) for label, filled in shown.page._bars._rows]
    assert told == [
        ("margin 0.15 (slow 0.2, stop 0.1)", pytest.approx(100.0 / 3.0)),
        ("nearest threshold 0.25 (slow 1, stop 0)", pytest.approx(20.0)),
    ]
    _, margin, distance = shown._minute.columns(time.monotonic())
    assert (margin.tolist(), distance.tolist()) == ([0.15], [0.25])
    near.state = StabilityMetrics.STATE_PAUSED
    shown._keeping("stability")(near)
    shown._draw()
    assert "the node is paused, it takes no setpoints; slow" in shown.page._action_text.content
    near.state = StabilityMetrics.STATE_IDLE
    near.nearest_threshold, near.distance_to_threshold = "", math.inf
    shown._keeping("stability")(near)
    shown._draw()
    assert shown.page._action_text.content == "**action SLOW**: slow"
    assert [filled.color for _, filled in shown.page._bars._rows] == ["yellow", "green"]
