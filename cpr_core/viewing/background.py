# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What takes long, beside the page: the newer work of a kind stops the older."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from .controls import Do
from .handled_robot import HandledRobot

__all__ = ["Background", "Task"]


class Task:
    """Work under way, as it sees itself. Once it is stopped nothing of it reaches the page any more."""

    def __init__(self, do: Do, number: int) -> None:
        self._do, self._number = do, number
        self._stop = threading.Event()

    def stopped(self) -> bool:
        """Whether to stop."""
        return self._stop.is_set()

    def stop(self) -> None:
        """Ask it to stop."""
        self._stop.set()

    def post(self, name: str, action: Callable[[HandledRobot], Any]) -> None:
        """Have something done with the robot, unless this is stopped before its turn comes.

        Args:
            name: Takes the place of what this task has posted under the same name, and waits.
            action: What to do.
        """

        def act(handled: HandledRobot) -> None:
            if not self.stopped():
                action(handled)

        self._do(f"{name} of task {self._number}", act)


class Background:
    """Threads that end when they are asked to. Any thread may start and stop them."""

    def __init__(self, do: Do, failed: Callable[[Exception], None]) -> None:
        """No work yet.

        Args:
            do: Where work posts what is to be done.
            failed: Called in the thread of work with what it raised.
        """
        self._do, self._failed = do, failed
        self._lock = threading.Lock()
        self._tasks: dict[str, Task] = {}
        self._threads: list[threading.Thread] = []
        self._started, self._closed = 0, False

    def start(self, kind: str, work: Callable[[Task], None]) -> None:
        """Start work in a thread of its own; not after the end.

        Args:
            kind: Older work of this kind is stopped.
            work: Takes what tells it whether to stop, and what it posts to.
        """
        with self._lock:
            if self._closed:
                return
            self._stop(kind)
            self._started += 1
            task = self._tasks[kind] = Task(self._do, self._started)

            def run() -> None:
                try:
                    work(task)
                except Exception as error:
                    self._failed(error)

            self._threads = [thread for thread in self._threads if thread.is_alive()]
            self._threads.append(threading.Thread(target=run, name=f"cpr view {kind}", daemon=True))
            self._threads[-1].start()

    def stop(self, kind: str) -> None:
        """Ask work of a kind to stop."""
        with self._lock:
            self._stop(kind)

    def close(self) -> None:
        """Ask everything to stop, and wait a little: what is being solved cannot be interrupted."""
        with self._lock:
            self._closed = True
            for kind in list(self._tasks):
                self._stop(kind)
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(2.0)

    def _stop(self, kind: str) -> None:
        if kind in self._tasks:
            self._tasks.pop(kind).stop()
