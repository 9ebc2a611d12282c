# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Publishers of the node."""

from __future__ import annotations

from typing import Any

import numpy as np
from cpr_msgs.msg import StabilityMetrics
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from visualization_msgs.msg import MarkerArray

from .conversions import joint_state, platform_pose
from .diagnostics import diagnostic_array
from .leg_markers import leg_markers
from .session import Session
from .stability_stream import StabilityStream
from .transforms import Transforms

__all__ = ["LATCHED", "Outputs"]

#: For what changes seldom: who comes late is told as well.
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Outputs:
    """Everything the node says by itself. Only /diagnostics is published while it is not active."""

    def __init__(self, node: LifecycleNode, transforms: Transforms) -> None:
        """Make the publishers; lifecycle ones are silent until the node is active."""
        self._node, self._transforms = node, transforms
        publisher = node.create_lifecycle_publisher
        self._joint_states = publisher(JointState, "joint_states", 10)
        self._platform_pose = publisher(PoseStamped, "~/platform_pose", 10)
        self._stability = publisher(StabilityMetrics, "~/stability", 10)
        self._motor_commands = publisher(Float64MultiArray, "~/motor_commands", 10)
        self._markers = publisher(MarkerArray, "~/leg_markers", 10)
        self._description = publisher(String, "~/robot_description", LATCHED)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._stream = StabilityStream()

    def description(self, session: Session) -> None:
        """The robot as its file describes it."""
        self._description.publish(String(data=session.robot.description.text))

    def state(self, session: Session) -> None:
        """Joint states, platform pose and, with tf2_ros, the platform frame."""
        stamp, frames = self._stamp(), self._transforms.frames
        equilibrium = session.solver.current.equilibrium
        self._joint_states.publish(joint_state(equilibrium, frames, stamp, session.velocity))
        pose = platform_pose(equilibrium, frames, stamp)
        self._platform_pose.publish(pose)
        self._transforms.send(pose)

    def motor_commands(self, commands: NDArray[np.float64]) -> None:
        """Motor positions in motor order, (n,), as forward position controllers take them."""
        self._motor_commands.publish(Float64MultiArray(data=commands.tolist()))

    def stability(self, session: Session, now: float) -> None:
        """The message for the supervisor."""
        message = self._stream.message(
            session.outcome,
            session.follower.settings.thresholds,
            self._transforms.frames,
            self._stamp(),
            now=now,
            setpoint_age=session.input_watchdog.age(now),
            wrench_age=session.wrench.watchdog.age(now),
            loop=session.loop_status(now),
        )
        self._stability.publish(message)

    def markers(self, session: Session, by: str) -> None:
        """Legs for rviz, if anybody looks."""
        if self._markers.get_subscription_count():
            self._markers.publish(
                leg_markers(session.outcome, by, self._transforms.frames, self._stamp())
            )

    def diagnostics(
        self, life: str, session: Session | None, dropped: dict[str, int], late_ticks: int
    ) -> None:
        """Health of the node."""
        name = self._node.get_fully_qualified_name()
        self._diagnostics.publish(
            diagnostic_array(name, life, session, dropped, late_ticks, self._stamp())
        )

    def _stamp(self) -> Any:
        return self._node.get_clock().now().to_msg()
