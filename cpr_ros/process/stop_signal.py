# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""SIGINT and SIGTERM as a request to stop, from the first line of the process to its last.

Whatever is imported here at the top delays the moment from which signals are taken.
"""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType
    from typing import Any, NoReturn, TypeVar

    Result = TypeVar("Result")

__all__ = ["StopSignal", "Stopped"]

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
#: How often it is looked whether a signal has come [s].
_LOOK = 0.1
#: Compilers recurse deeply, and threads have little memory for that on some systems [B].
_STACK = 64 << 20


class Stopped(Exception):
    """The node was told to stop while it waited for something that takes long."""


class StopSignal:
    """Takes both signals over. No handler raises: Python may be anywhere, in a compiler's callback too.

    While there is nothing to clean up a signal ends the process at once. Afterwards it is only
    remembered, and the main thread looks at safe places; it leaves to another thread what takes long and
    cannot be interrupted.

    Attributes:
        requested: Whether a signal has come.
    """

    def __init__(self) -> None:
        """Install the handlers; only in the main thread.

        A parent may have blocked the signals, so that none comes while Python itself starts.
        """
        self.requested = False
        self._remembers = False
        for number in _SIGNALS:
            signal.signal(number, self._handle)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        if not self._remembers:
            os._exit(0)
        self.requested = True

    def remember(self) -> None:
        """From now on there is something to clean up: signals are remembered."""
        self._remembers = True

    def wait_for(self, work: Callable[[], Result]) -> Result:
        """Let another thread do what cannot be interrupted, and wait for its result or a signal.

        Raises:
            Stopped: A signal has come. The work is abandoned; it ends with the process.
        """
        import threading

        answers: list[Any] = []
        errors: list[BaseException] = []

        def do() -> None:
            try:
                answers.append(work())
            except BaseException as error:
                errors.append(error)

        before = threading.stack_size(_STACK)
        try:
            worker = threading.Thread(target=do, daemon=True)
            worker.start()
        finally:
            threading.stack_size(before)
        while worker.is_alive() and not self.requested:
            worker.join(_LOOK)
        if self.requested:
            raise Stopped
        if errors:
            raise errors[0]
        return answers[0]

    def finish(self, status: int) -> NoReturn:
        """End the process with this status; everything is cleaned up.

        Python's own end would take a second, a signal that comes meanwhile kills, and work that is
        abandoned within a compiler would be torn out of it.
        """
        from contextlib import suppress

        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError):  # whoever read it is gone
                stream.flush()
        os._exit(status)
