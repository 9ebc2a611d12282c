# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot is when the node begins to move it, and how that is remembered."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node

from cpr_core import CprError, Equilibrium

from .interface.first_measured import MEASURED, first_measured
from .middleware.publishers import other_publishers
from .operation.kept_state import KeptState, KnownPlace, state_folder
from .operation.locked_file import link_to_nowhere
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
#: A file that is removed is mended by the node that has it before it was looked for so often.
_MENDED = 4
#: How long after the start of the node others may take to be discovered [s].
_DISCOVERY = 1.5


class _Since(NamedTuple):
    """A moment, told by what was in a file then: clocks are set, and disks have their own.

    Attributes:
        time: System time [s].
        seen: Whether it could be looked when the file was written last.
        written: When (system time of its disk); None: it was not there.
    """

    time: float
    seen: bool
    written: float | None

    def before(self, written: float) -> bool:
        """Whether it was before the file was written last, by the time of its disk [s]."""
        return written != self.written if self.seen else written > self.time


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
        """Open the file of the last state; where there can be none the node goes on, and says so.

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
        #: Why the robot can only be where it is measured; empty if it can be elsewhere.
        self._lost = ""
        self._kept: KeptState | None = None
        self._newest: KnownPlace | None = None
        #: How often in a row the file was not there.
        self._missing = 0
        #: Since when a place is known that is in no file; None: there is none.
        self._unkept_since: _Since | None = None
        folder = state_folder(parameters.state_directory)
        name = node.get_fully_qualified_name().strip("/").replace("/", ".")
        self._file = folder / f"{name}.{node.context.get_domain_id()}.state"
        #: Whether it was said that nothing can be kept, which is so since.
        self._failing = False
        try:
            self._kept = KeptState(self._file, session.robot)
        except OSError as error:
            self._warn(
                f"where the robot is will not be kept in {self._file}: {error}; that is tried again "
                "every second"
            )
            if self._from != "home" and _may_be_there(self._file):
                self._lost = f"the last state cannot be read ({error})"
            return
        if self._kept.damage and self._from != "home":
            self._lost = f"the last state is not used: {self._kept.damage}"
        if said := self._kept.damage or self._kept.problem:
            self._warn(f"the last state is not used: {said}")

    def _warn(self, text: str) -> None:
        self._node.get_logger().warning(text)

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
                last = None if self._kept is None or self._lost else self._kept.last()
                if last is not None:
                    return begin_at_last(self._session, last)
                before = None if self._kept is None else self._kept.commands_before
                if before is not None:
                    return self._begin_where_commanded(before)
            except CprError as error:
                if self._from == "last":
                    raise
                self._lost = f"the last state is not used: {error}"
                self._warn(self._lost)
        if self._from == "last":
            why = self._lost or "where the robot was last is not known"
            raise CprError(f"start_from: expected another place, {why}")
        last_commands = None if self._kept is None else self._kept.last_commands()
        if self._from == "home":
            stood = self._last_equilibrium()
            said = begin_on_way_home(self._session, last_commands, last=stood)
            return f"start_from is home, as for a simulation: {said}"
        said = begin_at_home(self._session, last_commands)
        return "where the robot is has to be measured" if self._lost else said

    def _last_equilibrium(self) -> Equilibrium | None:
        """Where the robot was last, if that is known and an equilibrium."""
        try:
            last = None if self._kept is None else self._kept.last()
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
        said = self._stop.wait_for(lambda: begin_at_commands(self._session, commands))
        self._newest = self._session.known_place
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
            return
        self._wait_for_others()  # one that is not found yet may say otherwise
        motors, instead = first_measured(
            self._node,
            self._session.robot,
            _MEASURED_WAIT,
            lambda: self._stop.requested,
            self._session.others.tolerance,
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
        session.unplaced = False
        if at_home:
            said = self._stop.wait_for(lambda: begin_on_way_home(session, motors, measured=True))
        else:
            said = self._stop.wait_for(lambda: begin_at_measured(session, motors))
        self._lost = ""
        self.keep()  # before anybody hears of it: the last state was elsewhere
        return said

    def _publishers(self) -> int:
        """How many others publish measured motors."""
        # Without them a robot that is lost would not start at all: they may take longer.
        longer = _MEASURED_WAIT if self._lost else 0.0
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
        """Remember where the robot is now, if that is not what was remembered last.

        Also what no motion led to: an applied solution may have the motors of the last commands. Where
        it cannot be kept the robot goes on, and that is said once.
        """
        place = self._session.known_place
        if place is None:
            return
        if not place.same_as(self._newest):
            self._newest = place
            if self._kept is None:
                self._unkept_since = _now(self._file)
                return
            try:
                self._kept.keep(*place)
            except OSError as error:
                self._fail(error)

    def look_after_file(self) -> None:
        """Mend what others did to the file and what could not be written; about once a second."""
        if self._kept is None:
            if self._unkept_since is not None and self._session.known_place is not None:
                self._open_later(self._unkept_since)
            return
        try:
            mended = self._kept.mend()
        except OSError as error:
            self._fail(error)
            return
        if mended:
            self._warn(
                f"{self._file} was not as this node left it (removed or changed?); it is made anew"
            )
        self._failing = False

    def _open_later(self, since: _Since) -> None:
        """Try what failed at the start, for a place that is known since then.

        A file of another robot or description is left alone, and so is one that was written later. One
        that is not there may have been removed under a node that is about to mend it.
        """
        try:
            before = _last_written(self._file)
            self._missing = self._missing + 1 if before is None else 0
            if 0 < self._missing < _MENDED:
                return
            kept = KeptState(self._file, self._session.robot)
        except OSError:
            return
        later = before is not None and since.before(before) and not kept.empty
        if kept.problem or kept.damage or later:
            kept.close()
            if later:
                self._unkept_since = None  # whoever wrote it knows better
            return
        self._kept, self._newest, self._unkept_since = kept, None, None
        self.keep()
        if not self._failing:
            self._node.get_logger().info(f"where the robot is is kept in {self._file} from now on")

    def _fail(self, error: OSError) -> None:
        if not self._failing:
            self._warn(
                f"where the robot is cannot be kept in {self._file}: {error}; unless that ends, the "
                "robot has to be measured when the node starts again"
            )
        self._failing = True

    def close(self) -> None:
        """Let the file go."""
        if self._kept is not None:
            self._kept.close()


def _now(file: Path) -> _Since:
    """Now, as far as what is written to a file is concerned."""
    try:
        return _Since(time.time(), True, _last_written(file))
    except OSError:
        return _Since(time.time(), False, None)


def _last_written(file: Path) -> float | None:
    """When a file was written last (system time); None: it is not there.

    Raises:
        OSError: That cannot be known.
    """
    try:
        return file.stat().st_mtime
    except FileNotFoundError:
        return None


def _may_be_there(file: Path) -> bool:
    """Whether there is a file, as far as this process may know."""
    try:
        file.stat()
    except FileNotFoundError:
        return link_to_nowhere(file) is not None
    except NotADirectoryError:
        return False
    except OSError:
        pass
    return True
