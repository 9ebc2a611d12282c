# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot is when the node begins to move it: at home, where it was last, or measured."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node

from cpr_core import CprError, Equilibrium

from .interface.first_measured import MEASURED, first_measured
from .middleware.publishers import other_publishers
from .operation.kept_state import state_folder
from .operation.place_memory import PlaceMemory
from .operation.session import Session
from .operation.starting_place import (
    begin_at_commands,
    begin_at_home,
    begin_at_last,
    begin_at_measured,
    begin_on_way_home,
)
from .process.stop_signal import Stopped, StopSignal
from .settings.node_settings import Parameters

__all__ = ["Whereabouts"]

#: How long a message with measured motors is waited for when the node becomes active [s].
_MEASURED_WAIT = 5.0
#: How long after the start of the node others may take to be discovered [s].
_DISCOVERY = 1.5


class Whereabouts:
    """Puts the robot at home, where it was last, or where it is measured."""

    def __init__(
        self,
        node: Node,
        parameters: Parameters,
        session: Session,
        stop: StopSignal,
        started: float,
    ) -> None:
        """Open the file of the last state.

        One that is there and cannot be read knows where the robot is: then it has to be measured.

        Args:
            node: The node.
            parameters: Say where from.
            session: Robot of the node, which moves it or tracks its motors.
            stop: Tells when the process is to end.
            started: Steady time at which the node was made [s].
        """
        self._node, self._session, self._stop = node, session, stop
        self._from = parameters.start_from
        #: Whether the robot is to go home from where it is measured: once, and not from where it was
        #: placed or moved.
        self._home_ahead, self._looked = parameters.start_from == "home", False
        self._discovered = started + _DISCOVERY
        name = node.get_fully_qualified_name().strip("/").replace("/", ".")
        file = f"{name}.{node.context.get_domain_id()}.state"
        folder = state_folder(parameters.state_directory)
        self._memory = PlaceMemory(folder / file, session.robot, node.get_logger())
        #: Why the robot can only be where it is measured; empty if it can be elsewhere.
        self._lost = "" if self._from == "home" else self._memory.lost
        #: Whether the motors were measured where the robot was last: who does it may be found later.
        self._measured_before = False

    def begin(self) -> str:
        """Put the robot at home or where it was last; says what was done.

        Where it was last may be no place to be: then it has to be measured before it moves. One that is
        tracked begins at home, and is where its motors are measured from then on.

        Raises:
            CprError: It is to be where it was last, which is not known or no place to be.
        """
        if self._session.tracking is not None:
            return "tracking begins at home"
        if self._from != "home":
            try:
                last = None if self._lost else self._memory.last()
                if last is not None:
                    self._measured_before = last.measured
                    return begin_at_last(self._session, last)
                before = self._memory.commands_before
                if before is not None:
                    return self._begin_where_commanded(before)
            except CprError as error:
                if self._from == "last":
                    raise
                self._lost = f"the last state is not used: {error}"
                self._node.get_logger().warning(self._lost)
        if self._from == "last":
            why = self._lost or "where the robot was last is not known"
            raise CprError(f"start_from: expected another place, {why}")
        last_commands = self._memory.last_commands()
        if self._from == "home":
            stood = self._last_equilibrium()
            said = begin_on_way_home(self._session, last_commands, last=stood)
            return f"start_from is home, as for a simulation: {said}"
        said = begin_at_home(self._session, last_commands)
        return "where the robot is has to be measured" if self._lost else said

    def _last_equilibrium(self) -> Equilibrium | None:
        """Where the robot was last, if that is known and an equilibrium."""
        try:
            last = self._memory.last()
        except CprError:
            return None
        return None if last is None else last.equilibrium

    def _begin_where_commanded(self, commands: NDArray[np.float64]) -> str:
        """Begin where the same motors were sent last, (n,), under another description.

        What was kept stays until the robot is placed or moved: the description may be the wrong one.

        Raises:
            CprError: No equilibrium explains them, or they are not there any more.
        """
        if np.isnan(commands).any():
            raise CprError("under another description the motors had left their last equilibrium")
        said = begin_at_commands(self._session, commands)
        self._memory.pass_over(self._session.known_place)
        return said

    def look(self) -> None:
        """Put the robot where its motors are measured, if they are.

        Where nobody measures them yet, and nobody has to, the first message does it later.

        Raises:
            CprError: They are to be measured and are not, or no equilibrium explains them.
        """
        if self._session.tracking is not None:
            return
        if not self._session.commands.aligned_with(self._session.solver.current.equilibrium.motors):
            self._wait_for_others()  # commands will move at once: controllers have to hear the first
        if self._from == "last":
            return
        publishers = self._publishers()
        if self._looked and not self._session.unplaced:
            self._home_ahead = False
        self._looked = self._session.unplaced = True
        if not publishers and self._from != "measured":
            if self._lost:
                raise CprError(
                    f"{self._lost}, and nothing publishes {MEASURED}: the robot has to be measured, or "
                    "to start with start_from:=home, where its motors have to be then"
                )
            if self._measured_before:
                self._node.get_logger().warning(
                    f"the motors were measured when the robot was last moved, and nothing publishes "
                    f"{MEASURED} now: it is taken to be where it was last"
                )
            return
        self._wait_for_others()  # one that is not found yet may say otherwise
        motors, instead = first_measured(
            self._node,
            self._session.robot,
            _MEASURED_WAIT,
            lambda: self._stop.requested,
            self._session.moved_by_others.tolerance,
        )
        if motors is not None:
            self._node.get_logger().info(self.place(motors))
        elif self._from != "home":
            expected = ", ".join(self._session.robot.motor_names)
            without = "" if self._lost else "start_from:=last or "
            raise CprError(
                f"the robot is to start where it is measured, but no {MEASURED} with its motors "
                f"({expected}) that tells it came in {_MEASURED_WAIT:g} s: {instead}. If nothing "
                "measures them, "
                f"{without}start_from:=home begins without"
            )

    def place(self, motors: NDArray[np.float64]) -> str:
        """Put the robot where its motors are measured, (n,), and remember it; says what was done.

        One that is to begin at home does, when it is measured first and has not moved before: its
        commands go there from where the motors are.

        Raises:
            CprError: No equilibrium explains them.
        """
        session, at_home = self._session, self._session.unplaced and self._home_ahead
        session.unplaced, session.measured.heard = False, True
        if at_home:
            said = self._stop.wait_for(lambda: begin_on_way_home(session, motors, measured=True))
        else:
            said = self._stop.wait_for(lambda: begin_at_measured(session, motors))
        self._lost = ""
        self.keep()  # before anybody hears of it: the last state was elsewhere
        return said

    def _publishers(self) -> int:
        """How many others publish measured motors."""
        # Without them a robot that is lost would not start at all, and one that was moved meanwhile
        # would be sent back: they may take longer.
        longer = _MEASURED_WAIT if self._lost or self._measured_before else 0.0
        self._wait_for_others(lambda: other_publishers(self._node, MEASURED) > 0, longer)
        return other_publishers(self._node, MEASURED)

    def _wait_for_others(
        self, found: Callable[[], bool] = lambda: False, longer: float = 0.0
    ) -> None:
        """Nodes that have just started do not see each other yet.

        In this thread: one that is left alone may hold the node, whose part of DDS would stay behind.
        """
        while time.monotonic() < self._discovered + longer and not found():
            if self._stop.requested:
                raise Stopped
            time.sleep(0.02)

    def keep(self) -> None:
        """Remember where the robot is now, also what no motion led to: a solution may be applied."""
        self._memory.keep(self._session.known_place)
        self._hold_if_outdated()

    def look_after_file(self) -> None:
        """See that what is remembered is in the file; about once a second."""
        self._memory.look_after_file(self._session.known_place)
        self._hold_if_outdated()

    def _hold_if_outdated(self) -> None:
        """Send the motors nowhere if the next start would take the robot to be where it was before.

        It would not where the motors are measured, or are to be, nor in a simulation.
        """
        session, outdated = self._session, self._memory.outdated
        if outdated:  # hardly ever: nothing else is looked at in a tick
            remembered = self._from in ("auto", "last") and session.tracking is None
            if not remembered or session.measured.newest(time.monotonic()) is not None:
                outdated = ""
        session.outgoing.unkept = outdated

    def close(self) -> None:
        """Let the file go."""
        self._memory.close()
