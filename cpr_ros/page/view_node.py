# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The ROS side of the page of a running node: hears what it publishes, sends what is asked for."""

from __future__ import annotations

import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from cpr_core import CprError, Robot, load_robot
from cpr_core.model.assessment import Threshold
from cpr_core.viewing.bars import Bar, bar

from ..process.once_a_second import ONCE_A_SECOND
from ..setpoint_topics import MOTOR_SETPOINT, SETPOINTS
from .marker_lines import lines_of
from .node_page import NodePage
from .watched_node import LastMinute, Presence, topic_beside

__all__ = ["ViewNode"]

#: Pictures a second, plots and names of others a second.
_RATE, _SLOW_RATE = 30.0, 2.0
#: States in which the node has a setpoint ahead, and goes there or waits to.
_UNDER_WAY = (
    StabilityMetrics.STATE_FOLLOWING,
    StabilityMetrics.STATE_HALTED,
    StabilityMetrics.STATE_ALIGNING,
)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class ViewNode(Node):
    """Mirrors one node on a page."""

    def __init__(self, watched: str, host: str, port: int) -> None:
        """Open the page and begin to listen.

        Args:
            watched: Name of the node, relative to the namespace of this one.
            host: Address the page is served at.
            port: Port; 0: any that is free.

        Raises:
            MissingViewer: viser is not installed.
            InvalidRequest: The address cannot be had.
            NameValidationException: No node has such a name.
        """
        super().__init__("cpr_view")
        self._watched = watched
        self._presence, self._minute = Presence(), LastMinute(("margin", "distance"))
        self._newest: dict[str, Any] = {}
        self._robot: Robot | None = None
        self._described, self._shown = "", False
        self._setpoint: Any = None
        states = topic_beside(watched, "joint_states")
        for name, kind, topic, quality in (
            ("platform", PoseStamped, f"{watched}/platform_pose", QoSProfile(depth=1)),
            ("markers", MarkerArray, f"{watched}/leg_markers", QoSProfile(depth=1)),
            ("stability", StabilityMetrics, f"{watched}/stability", QoSProfile(depth=10)),
        ):
            self.create_subscription(kind, topic, self._keeping(name), quality)
        described = self._going_on(self._hear_description)
        self.create_subscription(String, f"{watched}/description", described, _LATCHED)
        self.create_subscription(JointState, states, self._hear_motors, QoSProfile(depth=1))
        # Not ROS time: a robot goes on moving while /clock stands still.
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        for rate, draw in ((_RATE, self._draw), (_SLOW_RATE, self._draw_slowly)):
            self.create_timer(1.0 / rate, self._going_on(draw), clock=clock)
        self.page = NodePage(watched, host, port)

    def _going_on(self, work: Callable[..., None]) -> Callable[..., None]:
        """The same, but that nothing that anybody publishes ends the page."""

        def guarded(*heard: Any) -> None:
            try:
                work(*heard)
            except Exception as error:
                self.log_exception()
                self.page.fail(error)

        return guarded

    def log_exception(self) -> None:
        """Tell what was raised just now, which is not to end the page."""
        self.get_logger().error(traceback.format_exc(), **ONCE_A_SECOND)

    def _keeping(self, name: str) -> Any:
        def keep(message: Any) -> None:
            self._newest[name] = message
            if name == "stability":
                self._presence.hear(time.monotonic())
                self._minute.add(time.monotonic(), message.margin, message.distance_to_threshold)

        return keep

    def _hear_description(self, message: String) -> None:
        """Another robot takes the place of the one before: of that nothing counts any more."""
        if message.data == self._described:
            return
        if self._described:
            self._newest.clear()
            self.page.show_no_robot()
        self._described, self._shown, self._robot = message.data, False, None
        try:
            self._robot = load_robot(message.data)
        except CprError as error:
            self.page.say(f"the description of the node cannot be read: {error}")

    def _hear_motors(self, message: JointState) -> None:
        """Of this robot only: the one before, or others of the namespace, may be heard beside it."""
        if self._robot is None or tuple(message.name) != self._robot.motor_names:
            return
        if len(message.position) == self._robot.motor_count and np.all(
            np.isfinite(message.position)
        ):
            self._newest["motors"] = list(message.position)

    def _draw(self) -> None:
        """Show the newest of everything, and send what was asked for."""
        self.page.show_presence(self._presence.seen(time.monotonic()))
        if (message := self._newest.pop("stability", None)) is not None:
            under_way = message.state in _UNDER_WAY
            self.page.show_stability(message.action, _words(message), _bars(message), under_way)
        self._send()
        motors = self._newest.get("motors")
        if self._robot is None or motors is None:
            return
        if not self._shown:
            self.page.show_robot(self._robot, motors)
            self._shown = True
        if (message := self._newest.pop("markers", None)) is not None:
            self.page.show_lines(lines_of(message))
        if (message := self._newest.pop("platform", None)) is not None:
            at, turn = message.pose.position, message.pose.orientation
            self.page.show_platform(
                np.array([at.x, at.y, at.z]), np.array([turn.w, turn.x, turn.y, turn.z])
            )
        self.page.show_motors(motors)

    def _draw_slowly(self) -> None:
        self.page.show_others(self._others())
        if self._shown:
            self.page.show_last_minute(self._minute.columns(time.monotonic()), self._minute.names)

    def _send(self) -> None:
        """Setpoints of who is in control; a publisher is there only as long."""
        if self._robot is None or not self.page.in_control:
            if self._setpoint is not None:
                self.destroy_publisher(self._setpoint)
                self._setpoint = None
            return
        if self._setpoint is None:
            topic = f"{self._watched}/{MOTOR_SETPOINT}"
            self._setpoint = self.create_publisher(JointState, topic, 10)
        if not self._setpoint.get_subscription_count():
            return  # not connected yet: what is asked for waits
        asked = self.page.take_asked()
        if asked:
            names = [self._robot.motor_names[number] for number in asked]
            self._setpoint.publish(JointState(name=names, position=list(asked.values())))
            moved = ", ".join(
                f"{name} to {at:.5g}" for name, at in zip(names, asked.values(), strict=True)
            )
            self.page.say(f"sent: {moved}")

    def _others(self) -> list[str]:
        """Who else publishes on a topic of setpoints; another page has the name of this one."""
        found = Counter(
            (f"{info.node_namespace.rstrip('/')}/{info.node_name}", topic)
            for topic in SETPOINTS
            for info in self.get_publishers_info_by_topic(f"{self._watched}/{topic}")
        )
        own = self.get_fully_qualified_name()
        found[own, MOTOR_SETPOINT] -= self._setpoint is not None
        return sorted(
            f"{name} ({topic}{', another page' if name == own else ''})" for name, topic in +found
        )


def _words(message: StabilityMetrics) -> str:
    nearest = message.nearest_threshold
    paused = message.state == StabilityMetrics.STATE_PAUSED
    return (
        ("the node is paused, it takes no setpoints; " if paused else "")
        + message.status_text
        + (f"; nearest to its threshold: {nearest}" if nearest else "")
    )


def _bars(message: StabilityMetrics) -> list[Bar]:
    """The margin with the thresholds in force, and how near the nearest measure is to its own."""
    margin = bar("margin", message.margin, Threshold(message.margin_warning, message.margin_stop))
    level, levels = message.distance_to_threshold, Threshold(1.0, 0.0)
    if not message.nearest_threshold:
        return [margin, Bar("nearest threshold", level, levels, 1.0, "fine")]
    nearest = bar("margin", level, levels)  # of whatever measure: the words name it
    return [margin, replace(nearest, name="nearest threshold")]
