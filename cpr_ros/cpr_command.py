# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The command ``cpr``. It takes interrupts before it imports anything that takes time; no ROS here."""

from __future__ import annotations

import gc
import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType

__all__ = ["main"]

_INTERRUPTED = 130


def main() -> int:
    """Run the command line; returns the exit status, 130 with one line for an interrupt at any time."""
    # Whoever starts it may ignore interrupts, as shells do of what runs in the background.
    interruptible = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if interruptible:
        signal.signal(signal.SIGINT, _end)
    gc.disable()  # all of this stays: to look for garbage in it took a seventh of the time
    from cpr_core.command_line import main as run

    gc.enable()
    if interruptible:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    return run()


def _end(_number: int, _frame: FrameType | None) -> None:
    """End at once: there is nothing to clean up, and imports raise what they like of an exception."""
    os.write(2, b"cpr: interrupted\n")
    os._exit(_INTERRUPTED)


if __name__ == "__main__":
    sys.exit(main())
