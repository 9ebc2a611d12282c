# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A room that processes enter together, or one alone; who waits to be alone is not overtaken."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class Room:
    """Processes that name the same folder share a room."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(exist_ok=True)
        self._gate = (folder / "gate").open("a")
        self._room = (folder / "room").open("a")

    @contextmanager
    def entered(self, alone: bool) -> Iterator[None]:
        """Be in the room, with others or alone."""
        fcntl.flock(self._gate, fcntl.LOCK_EX)
        try:
            fcntl.flock(self._room, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        finally:
            fcntl.flock(self._gate, fcntl.LOCK_UN)
        try:
            yield
        finally:
            fcntl.flock(self._room, fcntl.LOCK_UN)
