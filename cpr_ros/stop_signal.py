# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""SIGINT and SIGTERM as a request to stop that cannot get lost."""

from __future__ import annotations

import signal
import sys
import threading
from types import FrameType
from typing import Any

__all__ = ["StopSignal"]

#: Time until an interrupt that fell into a place where nothing can be raised is repeated [s].
_AGAIN = 0.05


class StopSignal:
    """Takes both signals over.

    While the node starts they interrupt it at once. An interrupt that comes while Python finalises an
    object cannot be raised there and is repeated a moment later; one that some library swallows is
    still remembered. While the node spins signals only are remembered, so no callback is torn in two.

    Attributes:
        requested: Whether a signal has come.
        interrupts: Whether a signal raises KeyboardInterrupt.
    """

    def __init__(self) -> None:
        """Install the handlers; only in the main thread."""
        self.requested, self.interrupts = False, True
        self._hook = sys.unraisablehook
        sys.unraisablehook = self._unraisable
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._handle)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True
        if self.interrupts:
            raise KeyboardInterrupt

    def _unraisable(self, what: Any) -> None:
        if not (self.requested and issubclass(what.exc_type, KeyboardInterrupt)):
            self._hook(what)
        elif self.interrupts:
            main = threading.main_thread().ident
            again = threading.Timer(_AGAIN, signal.pthread_kill, (main, signal.SIGINT))
            again.daemon = True
            again.start()
