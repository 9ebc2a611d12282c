# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a node remembers of where its robot is, whatever happens to the file that it is kept in.

The file may be out of reach when the node starts, others may remove or change it, and the disk may be
full. The node goes on, says so once, and tries again. What is in a file that cannot be written any
more is taken away, for the next start would begin there. No rclpy here.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

from .kept_state import KeptState, KnownPlace
from .locked_file import link_to_nowhere

__all__ = ["PlaceMemory"]

#: A node whose file was removed mends it before others have looked for it so many times.
_MENDED = 4


class _Log(Protocol):
    def warning(self, message: str) -> object: ...

    def info(self, message: str) -> object: ...


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


class PlaceMemory:
    """Where the robot of a node was last, and a file that knows where it is.

    Attributes:
        lost: Why nobody knows where the robot was, though the file may have known; empty otherwise.
        outdated: That the file has an older place and nothing can be done about it, in words; empty
            if it has not.
    """

    def __init__(self, file: Path, robot: Robot, log: _Log) -> None:
        """Open the file, or say why it is not used.

        Args:
            file: Where.
            robot: The robot.
            log: Of the node.
        """
        self._file, self._robot, self._log = file, robot, log
        self.lost, self.outdated = "", ""
        self._kept: KeptState | None = None
        self._newest: KnownPlace | None = None
        #: How many times in a row the file was looked for and not there.
        self._missing = 0
        #: Since when a place is known that is in no file; None: there is none.
        self._unkept_since: _Since | None = None
        #: Whether it was said that nothing can be kept, and that has not ended.
        self._failing = False
        try:
            self._kept = KeptState(file, robot)
        except OSError as error:
            log.warning(
                f"where the robot is will not be kept in {file}: {error}; that is tried again "
                "every second"
            )
            self.lost = f"the last state cannot be read ({error})"
            if not _may_be_there(file):
                self.lost = (
                    f"where the robot is cannot be kept ({error}): the next start would not know"
                )
            return
        if self._kept.damage:
            self.lost = f"the last state is not used: {self._kept.damage}"
        if said := self._kept.damage or self._kept.problem:
            log.warning(f"the last state is not used: {said}")

    def last(self) -> KnownPlace | None:
        """Where the robot was last; None: not known.

        Raises:
            CprError: As of :meth:`KeptState.last`.
        """
        return None if self._kept is None else self._kept.last()

    def last_commands(self) -> NDArray[np.float64] | None:
        """The last motor commands, (n,) [rad or m], whatever the equilibrium; None: not known."""
        return None if self._kept is None else self._kept.last_commands()

    @property
    def commands_before(self) -> NDArray[np.float64] | None:
        """Those under another description; as of :class:`KeptState`."""
        return None if self._kept is None else self._kept.commands_before

    def pass_over(self, place: KnownPlace | None) -> None:
        """Leave what is kept as it is until the robot is anywhere else than at this place."""
        self._newest = place

    def keep(self, place: KnownPlace | None) -> None:
        """Remember where the robot is now, if that is known and not what was remembered last."""
        if place is None or place.same_as(self._newest):
            return
        self._newest = place
        if self._kept is None:
            self._unkept_since = _now(self._file)
            return
        try:
            self._kept.keep(*place)
        except OSError as error:
            self._fail(self._kept, error)
        else:
            self.outdated = ""

    def look_after_file(self, place: KnownPlace | None) -> None:
        """Mend what others did to the file and what could not be written; about once a second.

        Args:
            place: Where the robot is now.
        """
        if self._kept is None:
            if self._unkept_since is not None and place is not None:
                self._open_later(self._unkept_since, place)
            return
        try:
            mended = self._kept.mend()
        except OSError as error:
            self._fail(self._kept, error)
            return
        if mended:
            self._log.warning(
                f"{self._file} was not as this node left it (removed or changed?); it is made anew"
            )
        self._failing, self.outdated = False, ""

    def close(self) -> None:
        """Let the file go."""
        if self._kept is not None:
            self._kept.close()

    def _open_later(self, since: _Since, place: KnownPlace) -> None:
        """Try what failed at the start, for a place that is known since then.

        A file of another robot or description is left alone, and so is one that was written later. One
        that is not there may have been removed under a node that is about to mend it.
        """
        try:
            before = _last_written(self._file)
            self._missing = self._missing + 1 if before is None else 0
            if 0 < self._missing < _MENDED:
                return
            kept = KeptState(self._file, self._robot)
        except OSError:
            return
        later = before is not None and since.before(before) and not kept.empty
        if kept.problem or kept.damage or later:
            kept.close()
            if later:
                self._unkept_since = None  # whoever wrote it knows better
            return
        self._kept, self._newest, self._unkept_since = kept, None, None
        self.keep(place)
        if not self._failing:
            self._log.info(f"where the robot is is kept in {self._file} from now on")

    def _fail(self, kept: KeptState, error: OSError) -> None:
        said = f"where the robot is cannot be kept in {self._file}: {error}"
        cleared = kept.clear()
        if not cleared:
            self.outdated = f"{said}; what is in it is old, and the next start would begin there"
        if not self._failing:
            then = "the robot has to be measured when the node starts again"
            if not cleared:
                then = f"what is in it is old: {then}, and nothing moves that is not measured"
            elif not _may_be_there(self._file):
                then = f"{then}, or is taken to be at home"
            self._log.warning(f"{said}; unless that ends, {then}")
        self._failing = True


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
