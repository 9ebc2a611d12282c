# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A camera before a robot with softer rods and an unknown payload."""

import numpy as np
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64MultiArray

from helpers.driver import EVERY_MESSAGE, Driver
from helpers.soft_robot import SoftRobot

RATE, SPEED = 200.0, 4.0


class Camera(Driver):
    """Moves a robot that is not as described by the motor commands, and measures its platform."""

    def __init__(self, client, name, payload=None):
        self.real = SoftRobot(name, payload)
        self.heard, self.waiting = [], None
        node = client.node
        self.topic = node.create_publisher(
            PoseStamped, "/cpr_node/measured_platform_pose", qos_profile_sensor_data
        )
        self.twists = node.create_publisher(TwistStamped, "/cpr_node/platform_twist", 1)
        self._listening = node.create_subscription(
            Float64MultiArray, "/cpr_node/motor_commands", self._on_command, EVERY_MESSAGE
        )
        self._timer = None
        self.changed = lambda message: message
        super().__init__(client)
        client.spin_until(
            lambda: self.topic.get_subscription_count() and self.twists.get_subscription_count()
        )

    def _on_command(self, message):
        self.heard.append(np.array(message.data))
        self.waiting = self.heard[-1]

    def measure(self, rate):
        """Pictures a second; 0: none."""
        if self._timer is not None:
            self.client.node.destroy_timer(self._timer)
        self._timer = self.client.node.create_timer(1.0 / rate, self._picture) if rate else None

    def obey(self):
        """Be where the newest command sends the motors."""
        if self.waiting is not None:
            self.real.move_to(self.waiting)
            self.waiting = None

    def _picture(self):
        self.obey()
        message = PoseStamped()
        message.header.frame_id = "base"
        message.header.stamp = self.client.node.get_clock().now().to_msg()
        point, turn = message.pose.position, message.pose.orientation
        point.x, point.y, point.z = self.real.equilibrium.platform_position.tolist()
        turn.w, turn.x, turn.y, turn.z = self.real.equilibrium.platform_quaternion.tolist()
        message = self.changed(message)
        if message is not None:
            self.topic.publish(message)

    def twist(self, done, frame="", **linear):
        """A twist, twenty times a second until something holds."""
        message = TwistStamped()
        message.header.frame_id = frame
        for axis, value in linear.items():
            setattr(message.twist.linear, axis, value)
        timer = self.client.node.create_timer(0.05, lambda: self.twists.publish(message))
        self.until(done, timeout=60.0)
        self.client.node.destroy_timer(timer)

    def check_commands(self):
        """No command is farther from the one before than a tick's way."""
        assert len(self.heard) > 10
        steps = np.abs(np.diff(self.heard, axis=0))
        assert steps.max() <= SPEED / RATE * (1.0 + 2e-5)

    def until_frozen(self, text):
        self.until(
            lambda: (
                self.metrics.loop == StabilityMetrics.LOOP_FROZEN and text in self.metrics.loop_text
            )
        )

    def until_met(self, error):
        """Until the errors of half a second are below a bound: none only swings through it."""

        def met():
            told = self.all(StabilityMetrics)[-10:]
            return len(told) == 10 and all(
                metrics.loop == StabilityMetrics.LOOP_CLOSED
                and np.nanmax([metrics.position_error, metrics.rotation_error]) < error
                for metrics in told
            )

        self.until(met, timeout=60.0)

    def close(self):
        self.measure(0)
        node = self.client.node
        node.destroy_publisher(self.topic)
        node.destroy_publisher(self.twists)
        node.destroy_subscription(self._listening)
        super().close()
