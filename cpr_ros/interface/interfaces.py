# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What others reach the node by: topics that it takes, services, actions."""

from __future__ import annotations

import time

from cpr_msgs.msg import ErrorCode
from rclpy.lifecycle import LifecycleNode

from ..maps.map_action import MapAction
from ..maps.map_folder import MapFolder
from ..messages.frames import Frames
from ..middleware.dropped_messages import DroppedMessages
from ..middleware.waiting_requests import WaitingRequests
from ..operation.session import Session
from ..settings.node_settings import LiveParameters
from .inputs import Inputs, MeasuredRobot
from .move_action import MoveAction
from .requests import Requests
from .trajectory_action import trajectory_actions

__all__ = ["Interfaces"]


class Interfaces:
    """Everything a client or a controller sends something to; from the first time on for ever."""

    def __init__(
        self,
        node: LifecycleNode,
        frames: Frames,
        robot: MeasuredRobot,
        folder: MapFolder,
        waiting: WaitingRequests,
    ) -> None:
        """Offer all of it.

        Args:
            node: The node.
            frames: Names of the frames.
            robot: What the node operates.
            folder: Where maps are written.
            waiting: The line that requests to solve something wait in.
        """
        session = robot.active_session
        self._inputs = Inputs(node, frames, robot, time.monotonic)
        self._requests = Requests(node, frames, session, waiting)
        self._maps = MapAction(node, session, folder)
        self._moves = MoveAction(node, frames, session)
        self._trajectories = trajectory_actions(node, session, frames)

    @property
    def dropped(self) -> DroppedMessages:
        """Messages that were dropped."""
        return self._inputs.dropped

    def apply(self, live: LiveParameters) -> None:
        """Take new live parameters."""
        self._moves.arrived_tolerance = live.arrived_tolerance

    def forget_messages(self) -> None:
        """Leave aside what was sent to topics until now, because the node becomes active."""
        self._inputs.forget()

    def after_tick(self, session: Session, now: float) -> None:
        """See how far motions with a result have come.

        Args:
            session: The robot in operation.
            now: Steady time [s].
        """
        self._moves.after_tick(session, now)

    def stop_motions(self, session: Session) -> None:
        """End what is on its way, because the node is deactivated."""
        self._moves.stop("the node was deactivated, the robot holds")
        session.trajectories.stop(ErrorCode.NOT_READY, "the node was deactivated")

    def stop_maps(self) -> None:
        """End the map that is being made, because the robot is forgotten."""
        self._maps.stop("the node was cleaned up or shut down while the map was being made")

    def close(self) -> None:
        """Take actions away before the node ends."""
        self._maps.close()
        self._moves.close()
        for action in self._trajectories:
            action.close()
