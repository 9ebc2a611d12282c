# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything the node publishes, and how often."""

from __future__ import annotations

import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from visualization_msgs.msg import MarkerArray

from cpr_core import solve_home
from cpr_core.drawing.robot_lines import equilibrium_lines

from ..messages.command_message import CommandMessage
from ..messages.equilibrium_messages import joint_state, platform_pose
from ..messages.leg_markers import leg_markers, leg_width
from ..messages.transforms import Transforms
from ..messages.urdf import robot_urdf
from ..middleware.listeners import Listeners
from ..middleware.other_commanders import OtherCommanders
from ..middleware.ros_clock import RosClock
from ..operation.session import Session
from ..process.in_pieces import Work
from ..settings.node_settings import Parameters
from .diagnostics import NodeHealth, diagnostic_array, wrench_status
from .felt_wrench_output import FeltWrenchOutput
from .stability_output import StabilityOutput
from .state_output import StateOutput
from .streams import Stream

__all__ = ["LATCHED", "Outputs"]

#: For what changes seldom: who comes late is told as well.
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_COMMANDS = "~/motor_commands"
#: How often the last motor commands are said again at rest [Hz].
_REPEAT_RATE = 1.0


class Outputs:
    """Everything the node says by itself. Only /diagnostics is published while it is not active.

    Messages of the streams are made only while somebody listens to them.

    Attributes:
        state: Where the robot is.
        stability: The stream for supervisors.
        felt_wrench: What pushes on its platform.
        other_commanders: Who else commands the motors.
        streams: All that is said again and again.
    """

    def __init__(self, node: LifecycleNode, transforms: Transforms, parameters: Parameters) -> None:
        """Make the publishers; lifecycle ones are silent until the node is active.

        Args:
            node: The node.
            transforms: Names of the frames, and who sends them.
            parameters: Of the node.
        """
        self._node, self._frames, self._clock = node, transforms.frames, RosClock(node)
        self._urdf_frames, self._marker_color = parameters.frames, parameters.marker_color
        self.state = StateOutput(node, transforms, parameters.state_rate)
        self.stability = StabilityOutput(node, self._frames, parameters.stability_rate).stream
        self.felt_wrench = FeltWrenchOutput(node, self._frames)
        publisher = node.create_lifecycle_publisher
        self._motor_commands = publisher(Float64MultiArray, _COMMANDS, 10)
        self.other_commanders = OtherCommanders(node, _COMMANDS)
        self._markers = publisher(MarkerArray, "~/leg_markers", 10)
        self._description = publisher(String, "~/description", LATCHED)
        self._urdf = publisher(String, "~/robot_description", LATCHED)
        self._home = publisher(JointState, "~/home", LATCHED)
        self._home_pose = publisher(PoseStamped, "~/home_pose", LATCHED)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._command: CommandMessage | None = None
        markers_seen = Listeners(self._markers).lately
        self.streams = (
            self.state.stream,
            self.stability,
            Stream("markers", parameters.marker_rate, markers_seen, self._tell_markers),
            Stream("commands", _REPEAT_RATE, lambda now: True, self._repeat_commands),
        )

    def description(self, session: Session) -> None:
        """The robot as its file describes it and as URDF, and its home."""
        robot, frames, stamp = session.robot, self._frames, self._clock.stamp()
        self._description.publish(String(data=robot.description.text))
        # Without `frame_prefix`: who reads URDF has a prefix of its own.
        self._urdf.publish(String(data=robot_urdf(robot, *self._urdf_frames)))
        home = solve_home(robot)
        self._command = CommandMessage(robot.motor_count)
        self._home.publish(joint_state(home, frames, stamp))
        self._home_pose.publish(platform_pose(home, frames, stamp))

    def motor_commands(self, commands: NDArray[np.float64]) -> None:
        """Motor positions in motor order, (n,), as forward position controllers take them."""
        assert self._command is not None  # made when the node became active
        self._motor_commands.publish(self._command.of(commands))

    def _repeat_commands(self, session: Session, now: float) -> None:
        """For a controller that came later."""
        command = session.outgoing.repeated()
        if command is not None:
            self.motor_commands(command)

    def _tell_markers(self, session: Session, now: float) -> Work:
        """Legs for rviz."""
        outcome, stamp, by = session.present.outcome, self._clock.stamp(), self._marker_color
        lines = equilibrium_lines(outcome.assessment.equilibrium)
        yield
        width, action = leg_width(session.robot), outcome.verdict.action
        message = leg_markers(lines, width, action, by, self._frames, stamp)
        yield
        self._markers.publish(message)

    def diagnostics(self, health: NodeHealth, session: Session | None) -> None:
        """Health of the node, and what its robot is in; arguments as of :func:`diagnostic_array`."""
        name, now = self._node.get_fully_qualified_name(), time.monotonic()
        unseen = session.senses.unseen(now) if session else ""
        array = diagnostic_array(name, health, session, unseen, self._clock.stamp())
        if session is not None and self.felt_wrench.wanted:
            array.status.append(wrench_status(name, session, now))
        self._diagnostics.publish(array)
