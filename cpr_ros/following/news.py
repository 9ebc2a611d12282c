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

    def __init__(self) -> None:
        """Nothing has been wrong yet."""
        self._kind = ""

    def news(self, warning: str, over: str, kind: str = "the only one") -> News:
        """What the log is to be told now.

        Args:
            warning: What is wrong, in any words; empty: nothing.
            over: That nothing is wrong any more, in words.
            kind: Of what is wrong: where it is the same, nothing is told again.
        """
        before, self._kind = self._kind, kind if warning else ""
        if warning:
            return News() if kind == before else News(warning=warning)
        return News(information=over) if before else News()
