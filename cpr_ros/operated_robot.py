# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The robot that the node operates: it ticks while the node is active, and all is told of it."""

from __future__ import annotations

import time
from functools import partial

import numpy as np
from numpy.typing import NDArray
from rclpy.lifecycle import LifecycleNode
from sensor_msgs.msg import JointState

from cpr_core import CprError

from .following.news import News
from .following.supervision import Action
from .interface.diagnostics import NodeHealth
from .interface.first_measured import MEASURED
from .interface.interfaces import Interfaces
from .interface.outputs import Outputs
from .interface.streams import Stream
from .middleware.publishers import other_publishers
from .operation.announcements import Announcements
from .operation.live_changes import apply_live
from .operation.session import Session
from .operation.starting_place import HELD
from .process.giving_way import GivingWay
from .process.in_pieces import InPieces
from .process.periodic import Periodic
from .process.stop_signal import Stopped
from .process.ticking import Ticking
from .settings.node_settings import LiveParameters
from .whereabouts import Whereabouts

__all__ = ["OperatedRobot"]

#: How long the node gives way after a command [s]. After a pause others take longer, too.
_GIVING_WAY, _GIVING_WAY_AFTER_PAUSE = 2e-4, 5e-4
#: Part of a tick that it gives way at most.
_MOST_OF_TICK = 0.1


class OperatedRobot:
    """The robot of a node, if it has one; nothing is done with it while the node is not active.

    Attributes:
        session: The robot; None while the node is not configured.
        whereabouts: Puts it where it is, and remembers that; None while the node is not configured.
        interfaces: What others reach the node by; None before it listens.
        outputs: What it publishes.
        ticking: When ticks come.
        streams: What is due to be said again and again.
        telling: What is being said, in pieces.
    """

    def __init__(self, node: LifecycleNode, outputs: Outputs, tick_rate: float) -> None:
        """Have none yet.

        Args:
            node: The node.
            outputs: What it publishes.
            tick_rate: How often to tick [Hz].
        """
        self._node, self._logger, self.outputs = node, node.get_logger(), outputs
        self.session: Session | None = None
        self.whereabouts: Whereabouts | None = None
        self.interfaces: Interfaces | None = None
        self._active = False
        self._announcements = Announcements()
        self._last_action = Action.NONE  # that a supervisor was told
        self.ticking = Ticking(1.0 / tick_rate, self._tick, self._at_rest)
        self.streams, self.telling = Periodic(), InPieces(self.ticking)
        self._giving_way = GivingWay(_MOST_OF_TICK / tick_rate)

    def active_session(self) -> Session | None:
        """The robot in operation; None while the node is not active."""
        return self.session if self._active else None

    def activate(self) -> None:
        """Find out where it is, and begin to tick."""
        session = self._required_session()
        session.stand()
        self._announcements = Announcements()
        if self.whereabouts is not None:
            self.whereabouts.look()
        if self.interfaces is not None:
            self.interfaces.forget_messages()  # setpoints that came while it looked
        self._active = True
        now = time.monotonic()
        self._last_action = session.verdict(now).action
        self.ticking.start(now)
        self.streams.begin(now)
        for stream in self.outputs.streams:
            self.streams.add(stream.rate, partial(self._tell, stream, session), stream.wanted)
        self.outputs.description(session)

    def deactivate(self) -> None:
        """Hold and be silent."""
        if self.interfaces is not None and self.session is not None:
            self.interfaces.stop_motions(self.session)
            if self._active and self.session.orders.hold_commands():
                self._logger.warning(f"commands were on their way: {HELD}, once active again")
        self._active = False
        self.ticking.stop()
        self.streams.begin(0.0)
        self.telling.stop()

    def lose_whereabouts(self) -> None:
        """Let the file go that where it is is remembered in."""
        if self.whereabouts is not None:
            self.whereabouts.close()
            self.whereabouts = None

    def apply(self, live: LiveParameters) -> None:
        """Take new live parameters."""
        if self.session is not None and apply_live(self.session, live, time.monotonic()):
            self._logger.info("parameters changed: the setpoint is forgotten")
        if self.interfaces is not None:
            self.interfaces.apply(live)

    def place(self, motors: NDArray[np.float64]) -> None:
        """Be where the motors, (n,), are measured; where that cannot be, be inactive and say why."""
        if self.whereabouts is None:
            return
        try:
            self._logger.info(self.whereabouts.place(motors))
            if other_publishers(self._node, MEASURED) > 1:
                self._required_session().moved_by_others.prove(time.monotonic())
        except Stopped:
            return
        except CprError as error:
            self._logger.error(f"deactivated: {error}")
            self._node.trigger_deactivate()

    def feel(self, session: Session, message: JointState, now: float) -> None:
        """Tell what pushes on the platform, where measured motors say so and somebody asks."""
        if self.outputs.felt_wrench.wanted:
            self.outputs.felt_wrench.take(session, message, now)
            self._announce(session.felt.announcement(now))

    def look_after_file(self) -> None:
        """See that where it is is in the file that remembers it; about once a second."""
        if self.whereabouts is not None:
            self.whereabouts.look_after_file()

    def publish_diagnostics(self, life: str) -> None:
        """Say how node and robot get on, and to the log what is measured no more.

        Args:
            life: State of the node's life cycle.
        """
        session, now = self.active_session(), time.monotonic()
        commanders = ""
        if session is not None:
            commanders = self.outputs.other_commanders.look(now)
            unmeasured, again = session.senses.missing_motors(now), session.senses.motors_again(now)
            self._announce(self._announcements.of_motors(unmeasured, again=again))
            self._announce(self._announcements.of_wrench(session.senses.missing_wrench(now)))
            self._announce(self._announcements.of_setpoint(session.follower.forgotten))
            self._announce(self._announcements.of_commanders(commanders))
        if session is not None and self.outputs.felt_wrench.wanted:
            self._announce(session.felt.announcement(now))
        dropped = self.interfaces.dropped if self.interfaces else None
        health = NodeHealth(
            life=life,
            dropped=dropped.counts if dropped else {},
            newly_dropped=dropped.newest() if dropped else {},
            late_ticks=self.ticking.late,
            commanders=commanders,
        )
        self.outputs.diagnostics(health, session)

    def _at_rest(self) -> bool:
        """Whether a tick would change nothing, until something comes."""
        return self._required_session().at_rest and self._announcements.at_rest

    def _tick(self, now: float) -> None:
        session = self._required_session()
        outcome = session.tick(now, self._command, self._keep)
        self._announce(self._announcements.after_tick(outcome, now))
        if outcome.moved:
            self.outputs.state.step(session, now)
        before, self._last_action = self._last_action, session.verdict(now).action
        if self._last_action != before and self.outputs.stability.wanted(now):
            self._tell(self.outputs.stability, session)  # out of turn: a supervisor does not wait
        if outcome.home_missed:
            self._logger.error("the motors are at home, but this is another equilibrium than home")
        if self.interfaces is not None:
            self.interfaces.after_tick(session, now)

    def _command(self, motors: NDArray[np.float64], ahead: bool) -> None:
        """Send the motors, (n,), on their way, and give way to a controller on this computer."""
        self.outputs.motor_commands(motors)
        self._giving_way.sleep(_GIVING_WAY_AFTER_PAUSE if ahead else _GIVING_WAY)

    def _keep(self) -> None:
        """Remember where the robot is."""
        if self.whereabouts is not None:
            self.whereabouts.keep()

    def _tell(self, stream: Stream, session: Session) -> None:
        """Tell what is due of a stream, or begin to."""
        work = stream.tell(session, time.monotonic())
        if work is not None:
            self.telling.begin(stream.name, work)

    def _required_session(self) -> Session:
        if self.session is None:
            raise CprError("the node is not configured")
        return self.session

    def _announce(self, news: News) -> None:
        if news.warning:
            self._logger.warning(news.warning)
        if news.information:
            self._logger.info(news.information)
