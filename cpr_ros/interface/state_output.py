# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot is, as it is told: joint states, platform pose and its frame."""

from __future__ import annotations

import math

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.lifecycle import LifecycleNode
from sensor_msgs.msg import JointState

from cpr_core import Equilibrium

from ..messages.equilibrium_messages import joint_state, platform_pose
from ..messages.transforms import Transforms
from ..middleware.listeners import Listeners
from ..middleware.repeated_message import RepeatedMessage
from ..middleware.ros_clock import RosClock
from ..operation.session import Session
from .streams import Stream

__all__ = ["StateOutput"]


class StateOutput:
    """Tells of every step, and at rest at a rate.

    Attributes:
        stream: What is told at rest.
    """

    def __init__(self, node: LifecycleNode, transforms: Transforms, rate: float) -> None:
        """Make the publishers.

        Args:
            node: The node.
            transforms: Names of the frames, and who sends them.
            rate: How often to tell at rest [Hz].
        """
        self._transforms, self._clock, self._rate = transforms, RosClock(node), rate
        publisher = node.create_lifecycle_publisher
        self._joint_states = publisher(JointState, "joint_states", 10)
        self._platform_pose = publisher(PoseStamped, "~/platform_pose", 10)
        self._joints_heard = Listeners(self._joint_states)
        self._pose_heard = Listeners(self._platform_pose)
        self._last_step = -math.inf
        self._about: tuple[Equilibrium, NDArray[np.float64]] | None = None
        self._state = (RepeatedMessage(JointState()), RepeatedMessage(PoseStamped()))
        self.stream = Stream("state", rate, self._wanted, self._tell)

    def step(self, session: Session, now: float) -> None:
        """The state after a step, which nobody who listens may miss."""
        self._last_step = now
        self._joints_heard.now(now)
        self._pose_heard.now(now)
        self._say(session)

    def _wanted(self, now: float) -> bool:
        joints = self._joints_heard.lately(now)
        return self._pose_heard.lately(now) or joints or self._transforms.available

    def _tell(self, session: Session, now: float) -> None:
        """The state, if no step was told of lately."""
        if now - self._last_step > 0.5 / self._rate:
            self._say(session)

    def _say(self, session: Session) -> None:
        """Joint states, platform pose and, with tf2_ros, its frame, where somebody listens."""
        joints_heard = self._joints_heard.any
        pose_heard = self._pose_heard.any or self._transforms.available
        if not joints_heard and not pose_heard:
            return
        (joints, pose), stamp = self._messages(session), self._clock.now()
        if joints_heard:
            self._joint_states.publish(joints.at(stamp))
        if pose_heard:
            self._platform_pose.publish(pose.at(stamp))
            if self._transforms.available:
                self._transforms.send(pose.stamped(stamp))

    def _messages(self, session: Session) -> tuple[RepeatedMessage, RepeatedMessage]:
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
