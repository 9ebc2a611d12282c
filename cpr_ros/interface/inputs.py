# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Subscriptions of the node. What cannot be used is dropped whole, counted and warned about."""

from __future__ import annotations

import contextlib
import math
import traceback
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

from cpr_core import CprError

from ..following.goals import MotorSetpoint, PoseGoal
from ..following.trajectory_motion import Ending
from ..messages.command_message import CommandMessage
from ..messages.frames import Frames
from ..messages.motor_messages import measured_motors, motor_setpoint
from ..messages.platform_messages import (
    measured_pose,
    measurement_delay,
    platform_in_base,
    platform_twist,
)
from ..messages.pose_bytes import read_pose
from ..messages.pose_messages import check_pose_frame, controlled_pose
from ..messages.trajectory_messages import trajectory_order
from ..messages.wrench_messages import whole_pose, with_wrench
from ..middleware.dropped_messages import DroppedMessages
from ..middleware.publishers import other_publishers, own_topic
from ..operation.session import Session
from ..setpoint_topics import (
    COMMANDS,
    JOINT_TRAJECTORY,
    MOTOR_SETPOINT,
    PLATFORM_SETPOINT,
    PLATFORM_TWIST,
)
from .first_measured import MEASURED

__all__ = ["Inputs", "MeasuredRobot"]

#: The newest setpoint is the one that counts; some by name may belong together.
NEWEST, SOME = QoSProfile(depth=1), QoSProfile(depth=10)
#: Topic of the platform as it is measured.
_POSE = "~/measured_platform_pose"
#: How long it is taken for true whether several measure the motors, or the platform [s].
_COUNTED_FOR = 1.0
#: Setpoints that rclpy is too slow to read: see CommandMessage and read_pose.
_READ_FROM_BYTES = (f"~/{COMMANDS}", f"~/{PLATFORM_SETPOINT}")


class MeasuredRobot(Protocol):
    """What measured motors tell of: where a robot is, and what pushes on its platform."""

    def active_session(self) -> Session | None:
        """The robot in operation; None while the node is not active."""

    def place(self, motors: NDArray[np.float64]) -> None:
        """Take the first measured motors, (n,), of a robot that waits for them to be placed."""

    def feel(self, session: Session, message: JointState, now: float) -> None:
        """Take measured motors that may tell what pushes on the platform, at a steady time [s]."""


class Inputs:
    """Everything the node listens to.

    Attributes:
        dropped: Messages that were dropped.
    """

    def __init__(
        self,
        node: Node,
        frames: Frames,
        robot: MeasuredRobot,
        clock: Callable[[], float],
    ) -> None:
        """Subscribe.

        Args:
            node: The node.
            frames: Names of the frames.
            robot: What the node operates.
            clock: Steady time [s].
        """
        self.dropped = DroppedMessages()
        self._node, self._frames, self._robot, self._clock = node, frames, robot, clock
        #: The message of ~/commands by its number of motors.
        self._command_messages: dict[int, CommandMessage] = {}
        #: By topic: when it was counted, and whether several publish there.
        self._several: dict[str, tuple[float, bool]] = {}
        self._subscriptions: list[Subscription] = []
        for kind, topic, take, qos in (
            (JointState, f"~/{MOTOR_SETPOINT}", self._motor_setpoint, SOME),
            (Float64MultiArray, f"~/{COMMANDS}", self._commands, NEWEST),
            (PoseStamped, f"~/{PLATFORM_SETPOINT}", self._platform_setpoint, NEWEST),
            (JointTrajectory, f"~/{JOINT_TRAJECTORY}", self._joint_trajectory, NEWEST),
            (WrenchStamped, "~/external_wrench", self._external_wrench, qos_profile_sensor_data),
            (JointState, MEASURED, self._measured, qos_profile_sensor_data),
            (PoseStamped, _POSE, self._measured_pose, qos_profile_sensor_data),
            (TwistStamped, f"~/{PLATFORM_TWIST}", self._platform_twist, NEWEST),
        ):
            if own := own_topic(node, topic):
                node.get_logger().warning(
                    f"{topic} is {own}, where the node itself publishes: nothing is taken from there"
                )
                continue
            as_bytes = topic in _READ_FROM_BYTES
            self._subscriptions.append(
                node.create_subscription(kind, topic, self._guarded(topic, take), qos, raw=as_bytes)
            )

    def forget(self) -> None:
        """Leave aside what has come and was not delivered yet, however old it is."""
        for subscription in self._subscriptions:
            handle, kind = subscription.handle, subscription.msg_type
            as_bytes = True  # not read, so nothing can be wrong
            with handle:
                while handle.take_message(kind, as_bytes) is not None:
                    pass

    def _guarded(
        self, topic: str, take: Callable[[Session, Any, float], None]
    ) -> Callable[[Any], None]:
        """A callback that no message can make raise."""

        def callback(message: Any) -> None:
            session, now = self._robot.active_session(), self._clock()
            if session is None:
                return
            try:
                take(session, message, now)
            except CprError as error:
                line = self.dropped.add(topic, str(error), now)
                if line:
                    self._node.get_logger().warning(line)
            except Exception:
                self.dropped.add(topic, "internal error", now)
                self._node.get_logger().error(traceback.format_exc())

        return callback

    def _motor_setpoint(self, session: Session, message: JointState, now: float) -> None:
        robot, current = session.robot, session.solver.current.equilibrium.motors
        if len(message.name) == robot.motor_count:  # all of them, or names that are refused
            motors = motor_setpoint(robot, message, current)
            session.orders.follow(MotorSetpoint(robot, motors, np.full(len(motors), now)), now)
            return
        others = session.follower.other_motors(current, now)
        motors = motor_setpoint(robot, message, others.positions)
        since = others.since.copy()
        since[[robot.motor_names.index(name) for name in message.name]] = now
        session.orders.follow(MotorSetpoint(robot, motors, since), now)
        if left := [name for name in others.left if name not in message.name]:
            self._node.get_logger().warning(
                f"~/motor_setpoint: {', '.join(left)} stays where it is: its own setpoint is older "
                f"than setpoint_timeout {session.follower.watchdog.timeout:g} s"
            )

    def _commands(self, session: Session, message: bytes, now: float) -> None:
        count = session.robot.motor_count
        if count not in self._command_messages:
            self._command_messages[count] = CommandMessage(count)
        motors = self._command_messages[count].numbers(message)
        session.orders.follow(
            MotorSetpoint(session.robot, motors, np.full(count, now), "data"), now
        )

    def _platform_setpoint(self, session: Session, message: bytes, now: float) -> None:
        frame, numbers = read_pose(message)
        check_pose_frame(frame, self._frames)
        pose = controlled_pose(session.robot, numbers)
        session.orders.follow(PoseGoal(session.robot, pose), now)

    def _joint_trajectory(self, session: Session, message: JointTrajectory, now: float) -> None:
        order = trajectory_order(session.robot, message, self._node.get_clock().now().to_msg())
        session.orders.follow_trajectory(order, now, self._trajectory_ended)

    def _trajectory_ended(self, ending: Ending) -> None:
        logger = self._node.get_logger()
        if ending.val == ErrorCode.SUCCESS:
            logger.info(f"~/{JOINT_TRAJECTORY}: done after {ending.time:.3f} s")
        elif ending.val == ErrorCode.INVALID_MOTION_PLAN:
            line = self.dropped.add(f"~/{JOINT_TRAJECTORY}", ending.message, self._clock())
            if line:
                logger.warning(line)
        elif ending.replaced:  # of a stream every one is
            logger.debug(f"~/{JOINT_TRAJECTORY}: {ending.message}")
        else:
            logger.warning(f"~/{JOINT_TRAJECTORY}: {ending.val}: {ending.message}")

    def _external_wrench(self, session: Session, message: WrenchStamped, now: float) -> None:
        loads = session.solver.current.equilibrium.loads
        session.wrench.take(with_wrench(loads, message, self._frames), now)

    def _measured(self, session: Session, message: JointState, now: float) -> None:
        if message.name and set(message.name).isdisjoint(session.robot.motor_names):
            return  # grippers and others may say on the same topic where they are
        try:
            motors = measured_motors(session.robot, message)
        except CprError as error:
            session.measured.refuse(str(error))
            raise
        else:
            several = self._several_measure(MEASURED, now)
            if session.tracking is not None:
                tolerance = session.moved_by_others.tolerance if several else 0.0
                session.tracking.take(motors, now, tolerance)
            elif session.take_measured(motors, now, several):
                self._robot.place(motors)
        finally:
            self._robot.feel(session, message, now)

    def _several_measure(self, topic: str, now: float) -> bool:
        """Whether several publish what is measured; asked once a second, as it takes a while."""
        counted_at, several = self._several.get(topic, (-math.inf, False))
        if now - counted_at >= _COUNTED_FOR:
            several = other_publishers(self._node, topic) > 1
            self._several[topic] = now, several
        return several

    def _measured_pose(self, session: Session, message: PoseStamped, now: float) -> None:
        """Correct the setpoint, if the robot controls a pose; what is felt may use it too."""
        delay = measurement_delay(message.header, self._node.get_clock().now())
        current = session.solver.current.equilibrium
        if not session.robot.description.controlled:
            in_base = platform_in_base(current, message, self._frames)
            session.felt.take_pose(whole_pose(in_base), now - delay)
            return
        try:
            in_base = platform_in_base(current, message, self._frames)
            pose = measured_pose(session.robot, in_base)
            several = self._several_measure(_POSE, now)
            session.loop.take(pose, now, delay, several=several)
        except CprError as error:
            session.loop.refuse(str(error), now)
            raise
        with contextlib.suppress(CprError):  # it needs what is not controlled, too
            session.felt.take_pose(whole_pose(in_base), now - delay)

    def _platform_twist(self, session: Session, message: TwistStamped, now: float) -> None:
        session.orders.jog(platform_twist(session.robot, message, self._frames), now)
