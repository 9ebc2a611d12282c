# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What pushes on the platform, as it is told to who asks."""

from __future__ import annotations

import time

from cpr_msgs.msg import WrenchEstimate
from geometry_msgs.msg import WrenchStamped
from rclpy.lifecycle import LifecycleNode
from sensor_msgs.msg import JointState

from cpr_core import CprError

from ..messages.frames import Frames
from ..messages.motor_messages import measured_motors
from ..messages.platform_messages import measurement_delay
from ..messages.wrench_messages import estimated_wrench, measured_efforts, wrench_estimate
from ..middleware.ros_clock import RosClock
from ..operation.session import Session

__all__ = ["FeltWrenchOutput"]


class FeltWrenchOutput:
    """Estimates from measured motors while somebody listens."""

    def __init__(self, node: LifecycleNode, frames: Frames) -> None:
        """Make the publishers.

        Args:
            node: The node.
            frames: Names of the frames.
        """
        self._node, self._frames, self._clock = node, frames, RosClock(node)
        publisher = node.create_lifecycle_publisher
        self._wrench = publisher(WrenchStamped, "~/estimated_wrench", 10)
        self._estimate = publisher(WrenchEstimate, "~/wrench_estimate", 10)

    @property
    def wanted(self) -> bool:
        """Whether anybody asks what pushes on the platform."""
        publishers = self._wrench, self._estimate
        return any(publisher.get_subscription_count() > 0 for publisher in publishers)

    def take(self, session: Session, message: JointState, now: float) -> None:
        """What pushes on the platform, if measured motors tell; for when anybody asks.

        Args:
            session: The robot in operation.
            message: The measured motors.
            now: Steady time [s].
        """
        clock, frames = self._node.get_clock(), self._frames
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
            stamp = self._clock.stamp()
        if self._wrench.get_subscription_count():
            self._wrench.publish(estimated_wrench(found, frames, stamp))
        if self._estimate.get_subscription_count():
            solve_time = time.perf_counter() - begin
            told = wrench_estimate(
                found,
                frames,
                stamp,
                with_pose=session.felt.with_pose,
                latency=delay + solve_time,
                solve_time=solve_time,
            )
            self._estimate.publish(told)
