# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the log is to be told. No ROS here."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Announced", "News"]


class News(NamedTuple):
    """What the log is to be told, once.

    Attributes:
        warning: Empty: none.
        information: Empty: none.
    """

    warning: str = ""
    information: str = ""


class Announced:
    """Tells once that something is wrong, every kind of it, and once that nothing is any more."""

    def __init__(self, settled: float = 0.0) -> None:
        """Nothing has been wrong yet.

        Args:
            settled: What is wrong again within this time has not been over in between [s].
        """
        self._settled, self._wrong_at = settled, 0.0
        self._told: set[str] = set()

    def news(self, warning: str, over: str, kind: str = "the only one", now: float = 0.0) -> News:
        """What the log is to be told now.

        Args:
            warning: What is wrong, in any words; empty: nothing.
            over: That nothing is wrong any more, in words.
            kind: Of what is wrong: one that was told is not told again before all is over.
            now: Steady time [s].
        """
        if warning:
            new, self._wrong_at = kind not in self._told, now
            self._told.add(kind)
            return News(warning=warning) if new else News()
        if not self._told or now - self._wrong_at < self._settled:
            return News()
        self._told.clear()
        return News(information=over)
