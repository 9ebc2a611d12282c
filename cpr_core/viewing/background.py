# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What takes long, beside the page: the newer work of a kind stops the older."""

from __future__ import annotations

import threading
from collections.abc import Callable

__all__ = ["Background"]

Stopped = Callable[[], bool]


class Background:
    """Threads that end when they are asked to."""

    def __init__(self, failed: Callable[[Exception], None]) -> None:
        """No work yet.

        Args:
            failed: Called in the thread of work with what it raised.
        """
        self._failed = failed
        self._stops: dict[str, threading.Event] = {}
        self._threads: list[threading.Thread] = []

    def start(self, kind: str, work: Callable[[Stopped], None]) -> None:
        """Start work in a thread of its own.

        Args:
            kind: Older work of this kind is stopped.
            work: Takes what tells it whether to stop.
        """
        self.stop(kind)
        stop = self._stops[kind] = threading.Event()

        def run() -> None:
            try:
                work(stop.is_set)
            except Exception as error:
                self._failed(error)

        self._threads = [thread for thread in self._threads if thread.is_alive()]
        self._threads.append(threading.Thread(target=run, name=f"cpr view {kind}", daemon=True))
        self._threads[-1].start()

    def stop(self, kind: str) -> None:
        """Ask work of a kind to stop."""
        if kind in self._stops:
            self._stops.pop(kind).set()

    def close(self) -> None:
        """Ask everything to stop, and wait a little: what is being solved cannot be interrupted."""
        for kind in list(self._stops):
            self.stop(kind)
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(2.0)
