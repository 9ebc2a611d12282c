# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where motors were measured in the last while: how fast they are, and how far they have come."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

__all__ = ["MotorHistory"]

Floats = NDArray[np.float64]

#: Shortest time over which the speed of the motors is measured [s].
_SPEED_OVER = 0.008


class MotorHistory:
    """Places of motors by when they were measured, as far as clocks agree.

    Attributes:
        speed: Of the fastest motor [rad/s, rod lengths/s].
    """

    def __init__(self, units: Floats, horizon: float) -> None:
        """Remember nothing yet.

        Args:
            units: Natural units of the motors, (n,).
            horizon: How far back to remember [s].
        """
        self._units, self._horizon, self.speed = units, horizon, 0.0
        self._places: deque[tuple[float, Floats]] = deque()
        self._speed_from: tuple[float, Floats] | None = None

    def forget(self) -> None:
        """Be as if none had ever been measured."""
        self._places.clear()
        self._speed_from, self.speed = None, 0.0

    def take(self, motors: Floats, time: float) -> None:
        """Take measured motors; what is later already was so by a clock that was set.

        Args:
            motors: Where they are, (n,) [rad or m].
            time: When they were measured, or came if their stamp is ahead of that [s].
        """
        places = self._places
        while places and places[-1][0] >= time:
            places.pop()
        places.append((time, motors))
        while len(places) > 1 and places[1][0] <= time - self._horizon:
            places.popleft()
        self._look_at_speed()

    def way_in_last(self, span: float) -> Floats:
        """How far the motors have come in the last while of this length, (n,) [rad or m]."""
        times, places = zip(*self._places, strict=True)
        then = [np.interp(times[-1] - span, times, place) for place in np.transpose(places)]
        return places[-1] - np.array(then)

    def _look_at_speed(self) -> None:
        """How fast the fastest motor is; measurements without stamps may come all at once."""
        newest = time, motors = self._places[-1]
        before, place = self._speed_from = self._speed_from or newest
        if time - before > _SPEED_OVER:
            way = np.abs(motors - place) / self._units
            self.speed = float(way.max(initial=0.0)) / (time - before)
            self._speed_from = newest
