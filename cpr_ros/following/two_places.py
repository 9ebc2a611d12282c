# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are measured in two places in turn. No ROS here.

Two robots whose motors are called alike, or a driver and somebody who says where motors are without
knowing it: half of what is measured may agree with the commands, and none of it tells anything.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

from .motor_ways import largest_way

__all__ = ["OFTEN", "TwoPlaces", "apart_in_words"]

Floats = NDArray[np.float64]

#: How many times motors have to be measured elsewhere and back; two wrong numbers look like three
#: times.
OFTEN = 4
#: Time within which they have to [s].
_WITHIN = 3.0
#: Motors have come back if they are nearer to where they were than this part of the way out.
_BACK = 0.5
#: How long after a command motors may still be measured where it sent them [s].
_LATE = 0.5


class TwoPlaces:
    """Looks for measurements that go out and come back, and not where the motors were sent.

    Attributes:
        often: How often they have to come back, at most four times.
    """

    def __init__(self, robot: Robot, often: int = OFTEN) -> None:
        """Know of no measurement."""
        self.often, self._units = often, robot.motor_units.tolist()
        #: The last two places.
        self._before: deque[Floats] = deque(maxlen=2)
        #: Commands of the last while, with their times.
        self._sent: deque[tuple[float, Floats]] = deque()
        #: When one came back, and from how far.
        self._returns: deque[tuple[float, float]] = deque(maxlen=OFTEN)

    def take(
        self, measured: Floats, commands: Floats | None, tolerance: float, now: float
    ) -> float:
        """Take measured motors; how far apart the places are [rad, rod lengths], 0 where there is one.

        Args:
            measured: (n,) [rad or m].
            commands: Where they were sent last, (n,): what is as near to where they were sent of late as
                is tolerated is one place. None: nobody knows.
            tolerance: Ways that are no larger do not matter; twice as large ones, where nobody knows the
                commands: noise may be as large to either side.
            now: Steady time [s].
        """
        if commands is not None:
            self.sent(commands, now)
        if self._before and self._way(self._before[-1], measured) <= tolerance:
            self._before[-1] = measured  # still there, or on its way
        else:
            self._look_back(measured, tolerance, now)
            self._before.append(measured)
        return self._returns[-1][1] if self.returned(now) >= self.often else 0.0

    def returned(self, now: float) -> int:
        """How often they came back of late, up to four times."""
        return sum(now - time <= _WITHIN for time, _ in self._returns)

    def sent(self, commands: Floats, now: float) -> None:
        """Motors were sent somewhere, (n,): they may be measured there later, and back again by then."""
        self._sent.append((now, commands))
        while now - self._sent[0][0] > _LATE and now - self._sent[1][0] > _LATE:
            self._sent.popleft()

    def _look_back(self, measured: Floats, tolerance: float, now: float) -> None:
        """Whether another place is the one before the last again."""
        if len(self._before) < 2:
            return
        start, out = self._before
        way = min(self._way(start, out), self._way(out, measured))
        least = tolerance if self._sent else 2.0 * tolerance
        back = way > least and self._way(start, measured) < _BACK * way
        if back and self._farthest(start, out, measured) > tolerance:
            self._returns.append((now, way))

    def _way(self, first: Floats, last: Floats) -> float:
        return largest_way(first, last, self._units)

    def _farthest(self, *places: Floats) -> float:
        """How far one of the places is from all that the motors were sent through [rad, rod lengths]."""
        if not self._sent:
            return np.inf
        sent = np.array([commands for _, commands in self._sent])
        low, high = sent.min(axis=0), sent.max(axis=0)
        return max(self._way(place, np.clip(place, low, high)) for place in places)


def apart_in_words(way: float) -> str:
    """That motors are measured in two places."""
    return (
        f"the motors are measured in two places in turn, {way:.1g} (rad or rod lengths) apart: is there "
        "another robot, or somebody else who says where its motors are?"
    )
