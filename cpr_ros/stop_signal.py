"""SIGINT and SIGTERM as a request to stop that cannot get lost."""

from __future__ import annotations

import signal
from types import FrameType

__all__ = ["StopSignal"]


class StopSignal:
    """Takes both signals over.

    While the node starts they interrupt it at once; an interrupt that some library swallows is still
    remembered. While it spins they only are remembered, so no callback is torn in two.

    Attributes:
        requested: Whether a signal has come.
        interrupts: Whether a signal raises KeyboardInterrupt.
    """

    def __init__(self) -> None:
        """Install the handlers; only in the main thread."""
        self.requested, self.interrupts = False, True
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._handle)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        first, self.requested = not self.requested, True
        if self.interrupts and first:
            raise KeyboardInterrupt
