# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Work that takes longer than ticks leave time for, a piece at a time. No ROS here.

What is told of one tick would else make the next ones late, and with them motor commands.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator

from .ticking import Ticking

__all__ = ["InPieces", "Work"]

#: What a piece took before counts so much less every time.
_FORGETTING = 0.9

#: Does a piece whenever it is asked for its next value.
Work = Iterator[None]


class InPieces:
    """Works of several kinds, in pieces between ticks.

    A piece begins where it will be done before the next tick, if it takes what it took lately, and
    after a tick before which none began: work comes to an end however short ticks are.
    """

    def __init__(self, ticking: Ticking, clock: Callable[[], float] = time.monotonic) -> None:
        """Have nothing to do yet.

        Args:
            ticking: When the next tick is due.
            clock: Steady time [s].
        """
        self._ticking, self._clock = ticking, clock
        #: By kind, each with the number of its next piece; kinds that came first are done first.
        self._works: dict[str, tuple[Work, int]] = {}
        self._took: dict[tuple[str, int], float] = {}
        self._next_tick, self._waited = math.inf, False

    def begin(self, kind: str, work: Work) -> None:
        """Do this, too; not if one of its kind is still under way, as that comes too often then.

        Args:
            kind: Its pieces take about the same time whenever it is done.
            work: Does its pieces.
        """
        if kind not in self._works:
            self._works[kind] = work, 0

    def stop(self) -> None:
        """Do nothing any more."""
        self._works.clear()

    @property
    def due(self) -> float:
        """When to look [s]: at once if a piece will be done before the next tick, else after that."""
        if not self._works:
            return math.inf
        return -math.inf if self._fits(self._clock(), self._ticking.due) else math.inf

    def _fits(self, now: float, next_tick: float) -> bool:
        kind, (_, piece) = next(iter(self._works.items()))
        return now + self._took.get((kind, piece), 0.0) <= next_tick

    def look(self, now: float) -> None:
        """Do a piece if it is time to; to be asked whenever it may be, and after every tick.

        A piece that raises an error ends its work.

        Args:
            now: Steady time [s].
        """
        next_tick = self._ticking.due
        ticked, self._next_tick = next_tick != self._next_tick, next_tick
        if not self._works:
            return
        if not self._fits(now, next_tick) and not (ticked and self._waited):
            self._waited = self._waited or ticked
            return
        self._waited = False
        kind, (work, piece) = next(iter(self._works.items()))
        self._works[kind] = work, piece + 1
        try:
            next(work)
        except StopIteration:
            self._works.pop(kind, None)
        except Exception:
            self._works.pop(kind, None)
            raise
        took, before = self._clock() - now, self._took.get((kind, piece), 0.0)
        self._took[kind, piece] = max(took, _FORGETTING * before)
