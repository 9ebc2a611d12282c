# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the process that makes one map does, with the order on stdin.

Its argument FD is one end of a connection. States and at last a summary or a failure go out through it.
Whatever comes in, or its end because the node is gone, ends the map.
"""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
import traceback
from contextlib import suppress
from multiprocessing.connection import Connection

from cpr_core import CprError
from cpr_core.workspace import MapSummary, map_workspace, summary_of
from cpr_core.workspace.flood import Progress
from cpr_core.workspace.map_files import unfinished_file

from .map_order import MapFailure, MapOrder, MapState

__all__ = ["NICENESS", "PATIENCE", "main"]

#: The node comes before the map wherever they share a core.
NICENESS = 10
#: Time for the last checkpoint of a map that is ended, the machine may be busy; then the one before has
#: to do [s].
PATIENCE = 10.0


def main(arguments: list[str]) -> int:
    """Make the map that is ordered on stdin; returns the exit status."""
    os.nice(NICENESS)
    connection: Connection = Connection(int(arguments[0]))
    order: MapOrder = pickle.load(sys.stdin.buffer)
    ended, begun = threading.Event(), threading.Event()
    listening = (connection, order, ended, begun)
    threading.Thread(target=_listen, args=listening, daemon=True).start()
    answer: MapSummary | MapFailure
    try:
        answer = _made(order, connection, ended, begun)
    except Exception as error:
        if not isinstance(error, CprError):
            traceback.print_exc()
        answer = MapFailure(type(error), str(error), getattr(error, "argument", ""))
    with suppress(OSError):
        connection.send(answer)
    return 0


def _listen(
    connection: Connection, order: MapOrder, ended: threading.Event, begun: threading.Event
) -> None:
    """End the map when the node says so or is gone, and the process soon afterwards.

    At once where no cell is made yet, as nothing is lost: kernels may have to be compiled before.
    """
    with suppress(EOFError, OSError):
        connection.recv()
    ended.set()
    if begun.is_set() or order.resume:  # of one that is gone on with only borders may be missing
        time.sleep(PATIENCE)
    unfinished_file(order.file, os.getpid()).unlink(missing_ok=True)
    os._exit(1)


def _made(
    order: MapOrder, connection: Connection, ended: threading.Event, begun: threading.Event
) -> MapSummary:
    begin: tuple[float, int] | None = None  # time, and cells a resumed map has done already

    def tell(state: Progress) -> None:
        nonlocal begin
        begun.set()
        now = time.monotonic()
        begin = begin or (now, state.done)
        duration, done = now - begin[0], state.done - begin[1]
        rate = done / duration if done else 0.0
        with suppress(OSError):  # the node is gone: the map ends at its next look at `ended`
            connection.send(MapState(state.done, state.reached, state.total, rate))

    found = map_workspace(
        order.start.robot,
        order.grid,
        start=order.start,
        loads=order.loads,
        workers=order.workers or None,
        tolerance=order.tolerance,
        file=order.file,
        resume=order.resume,
        objective=order.objective,
        progress=tell,
        cancelled=ended.is_set,
    )
    return summary_of(found, order.threshold)
