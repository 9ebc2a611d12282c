# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is known of a node from its streams: whether it is there, and its last minute. No ROS here."""

from __future__ import annotations

from collections import deque
from typing import Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["LastMinute", "Presence", "Seen", "topic_beside"]

Floats = NDArray[np.float64]
Seen = Literal["waiting", "there", "gone", "back"]

#: A node that is silent for so long is gone: the stability stream comes 40 times as often [s].
_SILENCE = 2.0
#: For so long a node that is there again is called back [s].
_BACK = 10.0
_MINUTE = 60.0


def topic_beside(node: str, topic: str) -> str:
    """A topic in the namespace of a node, which is named relatively or from the root on."""
    space, slash, _ = node.rpartition("/")
    return f"{space}{slash}{topic}"


class Presence:
    """Whether a node is heard."""

    def __init__(self, silence: float = _SILENCE) -> None:
        """Nothing has been heard yet.

        Args:
            silence: How long it may be silent [s].
        """
        self._silence = silence
        self._last: float | None = None
        self._returned: float | None = None
        self._missed, self._gone = False, False

    def hear(self, now: float) -> None:
        """A message came."""
        if self._gone:
            self._returned = now
        self._last, self._missed, self._gone = now, False, False

    def seen(self, now: float) -> Seen:
        """What to say of it: ``back`` for a while after it was gone.

        Gone is what is missed twice in a row: whoever was held up himself hears in between what came
        meanwhile.
        """
        if self._last is None:
            return "waiting"
        self._gone = self._missed
        self._missed = now - self._last > self._silence
        if self._gone:
            return "gone"
        if self._returned is not None and now - self._returned < _BACK:
            return "back"
        return "there"


class LastMinute:
    """Numbers of the last minute."""

    def __init__(self, names: tuple[str, ...]) -> None:
        """Nothing yet.

        Args:
            names: Of the numbers.
        """
        self.names = names
        self._kept: deque[tuple[float, ...]] = deque()

    def add(self, now: float, *values: float) -> None:
        """Keep numbers; what is older than a minute is forgotten."""
        self._kept.append((now, *values))
        while self._kept[0][0] < now - _MINUTE:
            self._kept.popleft()

    def columns(self, now: float) -> tuple[Floats, ...]:
        """Time before now [s], negative, then every number; NaN where there is none."""
        if not self._kept:
            return (np.array([-_MINUTE, 0.0]), *(np.full(2, np.nan) for _ in self.names))
        rows = np.array(self._kept)
        rows[~np.isfinite(rows)] = np.nan
        return (rows[:, 0] - now, *rows[:, 1:].T)
