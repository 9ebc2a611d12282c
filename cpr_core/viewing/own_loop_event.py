# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An event of asyncio that no other thread disturbs."""

from __future__ import annotations

import asyncio

__all__ = ["OwnLoopEvent"]


class OwnLoopEvent(asyncio.Event):
    """Set in its loop only: what another thread does is forgotten, which has to ask the loop as well.

    viser sets the event that its sender waits for from any thread, and then asks the loop to set it.
    Where the first falls between the sender's look at the event and its waiting, the second finds it
    set already and wakes nobody: no browser would be sent anything again.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        """Not set.

        Args:
            loop: In which it is waited for.
        """
        super().__init__()
        self._own = loop

    def set(self) -> None:
        """Wake all who wait; does nothing outside of the loop."""
        try:
            running = asyncio.get_running_loop()  # a notebook has one of its own
        except RuntimeError:
            return
        if running is self._own:
            super().set()
