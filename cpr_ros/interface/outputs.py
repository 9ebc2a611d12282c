# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Everything the node publishes, and how often."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator
from typing import NamedTuple

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import StabilityMetrics, WrenchEstimate
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from visualization_msgs.msg import MarkerArray

from cpr_core import CprError, Equilibrium, solve_home
from cpr_core.drawing.robot_lines import equilibrium_lines

from ..messages.command_message import CommandMessage
from ..messages.equilibrium_messages import joint_state, platform_pose
from ..messages.leg_markers import leg_markers, leg_width
from ..messages.motor_messages import measured_motors
from ..messages.platform_messages import measurement_delay
from ..messages.stability_stream import Moment, StabilityStream
from ..messages.transforms import Transforms
from ..messages.urdf import robot_urdf
from ..messages.wrench_messages import estimated_wrench, measured_efforts, wrench_estimate
from ..middleware.listeners import Listeners
from ..middleware.other_commanders import OtherCommanders
from ..middleware.repeated_message import RepeatedMessage, Stamp
from ..operation.session import Session
from ..process.in_pieces import Work
from ..settings.node_settings import Parameters
from .diagnostics import NodeHealth, diagnostic_array, wrench_status

__all__ = ["LATCHED", "Outputs", "Stream", "promised"]

#: For what changes seldom: who comes late is told as well.
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_COMMANDS = "~/motor_commands"
#: How often the last motor commands are said again at rest [Hz].
_REPEAT_RATE = 1.0
#: The shortest time between two messages that is promised [s]: the machine may be busy.
_SHORTEST_PROMISE = 0.1


def promised(rate: float) -> QoSProfile:
    """For a stream whose end somebody has to notice.

    The next message comes within two periods, or 0.1 s if that is longer; else the stream is late
    (deadline) and its publisher no longer alive (liveliness), be the process dead or its thread stuck.

    Args:
        rate: Of the stream [Hz].
    """
    longest = Duration(seconds=max(_SHORTEST_PROMISE, 2.0 / rate))
    return QoSProfile(
        depth=10,
        deadline=longest,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,  # only a message is a sign of life
        liveliness_lease_duration=longest,
    )


class Stream(NamedTuple):
    """What is said again and again while the node is active.

    Attributes:
        name: Of the work that telling it is.
        rate: How often [Hz].
        wanted: Whether anybody listens, at a steady time [s].
        tell: Tells of the robot at a steady time [s], or gives the work of doing so, in pieces.
    """

    name: str
    rate: float
    wanted: Callable[[float], bool]
    tell: Callable[[Session, float], Work | None]


class Outputs:
    """Everything the node says by itself. Only /diagnostics is published while it is not active.

    Messages of the streams are made only while somebody listens to them.

    Attributes:
        stability: The stream for supervisors.
        streams: All that is said again and again.
    """

    def __init__(self, node: LifecycleNode, transforms: Transforms, parameters: Parameters) -> None:
        """Make the publishers; lifecycle ones are silent until the node is active.

        Args:
            node: The node.
            transforms: Names of the frames, and who sends them.
            parameters: Of the node.
        """
        self._node, self._transforms, self._parameters = node, transforms, parameters
        publisher = node.create_lifecycle_publisher
        self._joint_states = publisher(JointState, "joint_states", 10)
        self._platform_pose = publisher(PoseStamped, "~/platform_pose", 10)
        self._stability = publisher(
            StabilityMetrics, "~/stability", promised(parameters.stability_rate)
        )
        self._motor_commands = publisher(Float64MultiArray, _COMMANDS, 10)
        self.other_commanders = OtherCommanders(node, _COMMANDS)
        self._markers = publisher(MarkerArray, "~/leg_markers", 10)
        self._description = publisher(String, "~/description", LATCHED)
        self._urdf = publisher(String, "~/robot_description", LATCHED)
        self._felt = publisher(WrenchStamped, "~/estimated_wrench", 10)
        self._felt_well = publisher(WrenchEstimate, "~/wrench_estimate", 10)
        self._home = publisher(JointState, "~/home", LATCHED)
        self._home_pose = publisher(PoseStamped, "~/home_pose", LATCHED)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._command: CommandMessage | None = None
        self._clock = node.get_clock().handle
        self._joints_heard = Listeners(self._joint_states)
        self._pose_heard = Listeners(self._platform_pose)
        self._measures, self._last_state = StabilityStream(), -math.inf
        self._about: tuple[Equilibrium, NDArray[np.float64]] | None = None
        self._state = (RepeatedMessage(JointState()), RepeatedMessage(PoseStamped()))
        heard, seen = Listeners(self._stability), Listeners(self._markers)
        self.stability = Stream(
            "stability", parameters.stability_rate, heard.lately, self._tell_stability
        )
        self.streams = (
            Stream("state", parameters.state_rate, self._state_wanted, self._tell_state),
            self.stability,
            Stream("markers", parameters.marker_rate, seen.lately, self._tell_markers),
            Stream("commands", _REPEAT_RATE, lambda now: True, self._repeat_commands),
        )

    def description(self, session: Session) -> None:
        """The robot as its file describes it and as URDF, and its home."""
        robot, frames, stamp = session.robot, self._transforms.frames, self._stamp()
        self._description.publish(String(data=robot.description.text))
        # Without `frame_prefix`: who reads URDF has a prefix of its own.
        self._urdf.publish(String(data=robot_urdf(robot, *self._parameters.frames)))
        home = solve_home(robot)
        self._command = CommandMessage(robot.motor_count)
        self._home.publish(joint_state(home, frames, stamp))
        self._home_pose.publish(platform_pose(home, frames, stamp))

    def step(self, session: Session, now: float) -> None:
        """The state after a step, which nobody who listens may miss."""
        self._last_state = now
        self._joints_heard.now(now)
        self._pose_heard.now(now)
        self._say_state(session)

    def _state_wanted(self, now: float) -> bool:
        joints = self._joints_heard.lately(now)
        return self._pose_heard.lately(now) or joints or self._transforms.available

    def _tell_state(self, session: Session, now: float) -> None:
        """The state, if no step was told of lately."""
        if now - self._last_state > 0.5 / self._parameters.state_rate:
            self._say_state(session)

    def _say_state(self, session: Session) -> None:
        """Joint states, platform pose and, with tf2_ros, its frame, where somebody listens."""
        joints_heard = self._joints_heard.any
        pose_heard = self._pose_heard.any or self._transforms.available
        if not joints_heard and not pose_heard:
            return
        (joints, pose), stamp = self._state_of(session), self._now()
        if joints_heard:
            self._joint_states.publish(joints.at(stamp))
        if pose_heard:
            self._platform_pose.publish(pose.at(stamp))
            if self._transforms.available:
                self._transforms.send(pose.stamped(stamp))

    def _state_of(self, session: Session) -> tuple[RepeatedMessage, RepeatedMessage]:
        """Messages of the state; at rest those of before."""
        about = session.solver.current.equilibrium, session.present.velocity
        if self._about is None or not (self._about[0] is about[0] and self._about[1] is about[1]):
            frames, stamp = self._transforms.frames, Time()
            self._about = about
            self._state = (
                RepeatedMessage(joint_state(about[0], frames, stamp, about[1])),
                RepeatedMessage(platform_pose(about[0], frames, stamp)),
            )
        return self._state

    def motor_commands(self, commands: NDArray[np.float64]) -> None:
        """Motor positions in motor order, (n,), as forward position controllers take them."""
        assert self._command is not None  # made when the node became active
        self._motor_commands.publish(self._command.of(commands))

    def _repeat_commands(self, session: Session, now: float) -> None:
        """For a controller that came later."""
        command = session.outgoing.repeated(now)
        if command is not None:
            self.motor_commands(command)

    def _tell_stability(self, session: Session, now: float) -> Work:
        """Measure the robot, and publish the message for the supervisor.

        If the action has changed meanwhile, the next message follows at once.
        """
        moment = yield from self._say_stability(session)
        while session.present.outcome.verdict.action != moment.outcome.verdict.action:
            yield
            moment = yield from self._say_stability(session)

    def _say_stability(self, session: Session) -> Generator[None, None, Moment]:
        moment = yield from self._measures.measure(
            lambda: Moment(session.present.outcome, time.monotonic(), self._now())
        )
        now = time.monotonic()
        message = self._measures.message(
            moment,
            session.follower.settings.thresholds,
            self._transforms.frames,
            setpoint_age=session.input_watchdog.age(now),
            wrench_age=session.wrench.watchdog.age(now),
            loop=session.loop_status(now),
            unseen=session.senses.unseen(now),
        )
        self._stability.publish(message)
        return moment

    @property
    def wrench_wanted(self) -> bool:
        """Whether anybody asks what pushes on the platform."""
        publishers = self._felt, self._felt_well
        return any(publisher.get_subscription_count() > 0 for publisher in publishers)

    def felt_wrench(self, session: Session, message: JointState, now: float) -> None:
        """What pushes on the platform, if measured motors tell; for when anybody asks.

        Args:
            session: The robot in operation.
            message: The measured motors.
            now: Steady time [s].
        """
        clock, frames = self._node.get_clock(), self._transforms.frames
        begin, delay = time.perf_counter(), measurement_delay(message.header, clock.now())
        try:
            motors = measured_motors(session.robot, message)
            efforts = measured_efforts(session.robot, message)
        except CprError as error:
            session.felt.refuse("efforts", str(error))
            return
        near = session.solver.current.equilibrium
        found = session.felt.take(motors, efforts, now - delay, now, near)
        if found is None:
            return
        stamp = message.header.stamp
        if not stamp.sec and not stamp.nanosec:
            stamp = self._stamp()
        if self._felt.get_subscription_count():
            self._felt.publish(estimated_wrench(found, frames, stamp))
        if self._felt_well.get_subscription_count():
            solve_time = time.perf_counter() - begin
            told = wrench_estimate(
                found,
                frames,
                stamp,
                with_pose=session.felt.with_pose,
                latency=delay + solve_time,
                solve_time=solve_time,
            )
            self._felt_well.publish(told)

    def _tell_markers(self, session: Session, now: float) -> Work:
        """Legs for rviz."""
        outcome, stamp, by = session.present.outcome, self._stamp(), self._parameters.marker_color
        lines = equilibrium_lines(outcome.assessment.equilibrium)
        yield
        frames = self._transforms.frames
        width = leg_width(session.robot)
        message = leg_markers(lines, width, outcome.verdict.action, by, frames, stamp)
        yield
        self._markers.publish(message)

    def diagnostics(self, health: NodeHealth, session: Session | None) -> None:
        """Health of the node, and what its robot is in; arguments as of :func:`diagnostic_array`."""
        name, now = self._node.get_fully_qualified_name(), time.monotonic()
        unseen = session.senses.unseen(now) if session else ""
        array = diagnostic_array(name, health, session, unseen, self._stamp())
        if session is not None and self.wrench_wanted:
            array.status.append(wrench_status(name, session, now))
        self._diagnostics.publish(array)

    def _stamp(self) -> Time:
        seconds, nanoseconds = self._now()
        return Time(sec=seconds, nanosec=nanoseconds)

    def _now(self) -> Stamp:
        """ROS time. Not by way of rclpy.time.Time, which takes several times as long."""
        return divmod(self._clock.get_now().nanoseconds, 1_000_000_000)
