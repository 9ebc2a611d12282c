# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The end of a process that was started here."""

from __future__ import annotations

import signal
import subprocess

__all__ = ["interrupted"]


def interrupted(process: subprocess.Popen[bytes], patience: float = 20.0) -> int:
    """Interrupt a process, and wait for its end.

    Args:
        process: May have ended already.
        patience: One that has not ended after that is killed: nobody would look after it [s].

    Returns:
        Its exit status, negative where a signal has ended it.
    """
    process.send_signal(signal.SIGINT)  # does nothing where it has ended
    try:
        return process.wait(timeout=patience)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()
