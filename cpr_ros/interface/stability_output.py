# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The stream for supervisors: how stable the robot is, and what is to be done."""

from __future__ import annotations

import time
from collections.abc import Generator

from cpr_msgs.msg import StabilityMetrics
from rclpy.lifecycle import LifecycleNode

from ..messages.frames import Frames
from ..messages.stability_stream import Moment, StabilityStream
from ..middleware.listeners import Listeners
from ..middleware.ros_clock import RosClock
from ..operation.session import Session
from ..process.in_pieces import Work
from .streams import Stream, promised

__all__ = ["StabilityOutput"]


class StabilityOutput:
    """Measures the robot and tells of it, at a rate.

    Attributes:
        stream: What is told.
    """

    def __init__(self, node: LifecycleNode, frames: Frames, rate: float) -> None:
        """Make the publisher.

        Args:
            node: The node.
            frames: Names of the frames.
            rate: How often to tell [Hz].
        """
        self._frames, self._clock, self._measures = frames, RosClock(node), StabilityStream()
        publisher = node.create_lifecycle_publisher
        self._stability = publisher(StabilityMetrics, "~/stability", promised(rate))
        heard = Listeners(self._stability)
        self.stream = Stream("stability", rate, heard.lately, self._tell)

    def _tell(self, session: Session, now: float) -> Work:
        """Measure the robot, and publish the message for the supervisor.

        If the action has changed meanwhile, the next message follows at once.
        """
        moment = yield from self._say(session)
        while session.present.outcome.verdict.action != moment.outcome.verdict.action:
            yield
            moment = yield from self._say(session)

    def _say(self, session: Session) -> Generator[None, None, Moment]:
        moment = yield from self._measures.measure(
            lambda: Moment(session.present.outcome, time.monotonic(), self._clock.now())
        )
        now = time.monotonic()
        message = self._measures.message(
            moment,
            session.follower.settings.thresholds,
            self._frames,
            setpoint_age=session.input_watchdog.age(now),
            wrench_age=session.wrench.watchdog.age(now),
            loop=session.loop_status(now),
            unseen=session.senses.unseen(now),
        )
        self._stability.publish(message)
        return moment
