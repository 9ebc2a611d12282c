# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One thread that does what is asked of it: of requests for the same thing only the newest counts."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

__all__ = ["Mailbox"]


class Mailbox:
    """Work in the order it came. A slider that is dragged asks faster than anybody can solve.

    Everything that touches the robot or the page runs in this thread, so nothing has to be locked.
    """

    def __init__(self, failed: Callable[[Exception], None]) -> None:
        """Start the thread.

        Args:
            failed: Called in it with what work raised.
        """
        self._waiting: dict[str, tuple[float, Callable[[], None]]] = {}
        self._changed = threading.Condition()
        self._failed, self._closed, self._busy = failed, False, False
        self._thread = threading.Thread(target=self._work, name="cpr view", daemon=True)
        self._thread.start()

    def ask(self, task: str, work: Callable[[], None], delay: float = 0.0) -> None:
        """Have something done soon; it takes the place of what was asked under the same name before.

        Args:
            task: Its name.
            work: What to do.
            delay: Not before so long [s].
        """
        with self._changed:
            if not self._closed:
                due = time.monotonic() + delay
                before, _ = self._waiting.get(task, (due, work))
                self._waiting[task] = min(before, due), work
                self._changed.notify_all()

    def wait(self, timeout: float) -> bool:
        """Wait until everything is done; whether it was in time [s]. Not from the thread itself."""
        end = time.monotonic() + timeout
        with self._changed:
            while self._waiting or self._busy:
                if not self._changed.wait(max(0.0, end - time.monotonic())):
                    return False
        return True

    def close(self) -> None:
        """Forget what waits, and end after what is under way."""
        with self._changed:
            self._closed = True
            self._waiting.clear()
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _work(self) -> None:
        while (work := self._next()) is not None:
            try:
                work()
            except Exception as error:
                self._failed(error)

    def _next(self) -> Callable[[], None] | None:
        """What is due first, once it is; None: closed."""
        with self._changed:
            self._busy = False
            self._changed.notify_all()
            while not self._closed:
                due, task = min(
                    ((at, task) for task, (at, _) in self._waiting.items()), default=(None, "")
                )
                if due is None:
                    self._changed.wait()
                elif (early := due - time.monotonic()) > 0.0:
                    self._changed.wait(early)
                else:
                    self._busy = True
                    return self._waiting.pop(task)[1]
            return None
