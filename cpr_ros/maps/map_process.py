# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map in the making in another process, seen from the node. Nothing here waits."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from cpr_core.workspace import MapSummary
from cpr_core.workspace.map_files import unfinished_file

from .map_order import MapFailure, MapOrder, MapState
from .map_worker import PATIENCE

__all__ = ["MapProcess"]

#: Time a process has to end by itself after it was told to [s].
_GRACE = PATIENCE + 0.1
#: Time that the end of the node waits for it; then it ends alone [s].
_LAST_GRACE = 0.8


class MapProcess:
    """A process of its own session: signals of a terminal reach the node only, which ends the map.

    Attributes:
        order: What is made.
        state: How far it is; None before it begins.
        result: What it came to; None while it goes on, and for one that was ended before it could save.
        ended: Whether the process is no more.
        death: How it ended, if it did so without result and without being told to.
    """

    def __init__(self, order: MapOrder) -> None:
        """Start it."""
        self.order = order
        self.state: MapState | None = None
        self.result: MapSummary | MapFailure | None = None
        self.ended, self.death = False, ""
        self._before = _stamp(order.file)
        self._deadline: float | None = None
        self._connection, worker_end = multiprocessing.Pipe()
        # The same modules as here, and none that lies by chance where the node was started.
        paths = os.pathsep.join(path or str(Path.cwd()) for path in sys.path)
        with tempfile.TemporaryFile() as stdin, worker_end:
            pickle.dump(order, stdin)
            stdin.seek(0)
            program = [sys.executable, "-P", "-m", "cpr_ros.maps.map_worker_start"]
            self._process = subprocess.Popen(
                [*program, str(worker_end.fileno())],
                stdin=stdin,
                pass_fds=[worker_end.fileno()],
                start_new_session=True,
                env=os.environ | {"PYTHONPATH": paths},
            )

    @property
    def written(self) -> bool:
        """Whether the file holds this map, complete or not."""
        now = _stamp(self.order.file)
        return now is not None and (self.order.resume or now != self._before)

    def look(self, now: float) -> bool:
        """Take what the process says; whether there is a new state.

        Args:
            now: Steady time [s].
        """
        before, silent = self.state, False
        while not self.ended and self.result is None and self._connection.poll():
            try:
                message = self._connection.recv()
            except (EOFError, OSError):
                silent = True
                break
            if isinstance(message, MapState):
                self.state = message
            else:
                self.result = message
        if not self.ended:
            if self.result is not None:
                self._end()  # nothing is left to do but to exit
            elif silent:
                self._bury()
            elif self._deadline is not None and now > self._deadline:
                self._end()
        return self.state is not before

    def stop(self, now: float) -> None:
        """Tell it to save what there is and to end; soon it is ended."""
        if self._deadline is None:
            self._deadline = now + _GRACE
            with suppress(OSError):
                self._connection.send("stop")

    def close(self) -> None:
        """End it before the node ends; waits for its last checkpoint, but not long: it is alone then."""
        if not self.ended:
            self._connection.close()
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_LAST_GRACE)
                self._end()
            self.ended = True

    def _bury(self) -> None:
        """The process ended by itself, without a result."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_LAST_GRACE)
        status = self._process.poll()
        self._end()
        if self._deadline is None:
            killed = status is not None and status < 0
            self.death = signal.Signals(-(status or 0)).name if killed else f"status {status}"

    def _end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._connection.close()
        unfinished_file(self.order.file, self._process.pid).unlink(missing_ok=True)
        self.ended = True


def _stamp(file: Path) -> tuple[int, int] | None:
    """Tells a file from one that is put in its place; None if there is none."""
    try:
        found = file.stat()
    except FileNotFoundError:
        return None
    return found.st_ino, found.st_mtime_ns
