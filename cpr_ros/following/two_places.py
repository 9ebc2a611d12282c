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

from .goals import largest_way

__all__ = ["TwoPlaces", "apart_in_words"]

Floats = NDArray[np.float64]

#: Measured there and back so often, within so long [s]: two wrong numbers are three times.
_OFTEN, _WITHIN = 4, 3.0
#: What comes back to less than this part of the way out is a part of the way.
_BACK = 0.5
#: Motors may be measured where they were sent so long ago [s].
_LATE = 0.5


class TwoPlaces:
    """Looks for measurements that go out and come back, and not where the motors were sent."""

    def __init__(self, robot: Robot, often: int = _OFTEN) -> None:
        """Know of no measurement.

        Args:
            robot: The robot.
            often: How often they have to come back.
        """
        self._units = robot.motor_units.tolist()
        #: The last two places.
        self._before: deque[Floats] = deque(maxlen=2)
        #: Commands of the last while, with their times.
        self._sent: deque[tuple[float, Floats]] = deque()
        #: When one came back, and from how far.
        self._often, self._returns = often, deque[tuple[float, float]](maxlen=often)

    def take(
        self, measured: Floats, commands: Floats | None, tolerance: float, now: float
    ) -> float:
        """Take measured motors; how far apart the places are [rad, rod lengths], 0 where there is one.

        Args:
            measured: (n,) [rad or m].
            commands: Where they were sent last, (n,): what is as near to where they were sent of late as
                is tolerated is one place. None: nobody knows.
            tolerance: Ways that are no larger do not matter.
            now: Steady time [s].
        """
        if commands is not None:
            self._sent.append((now, commands))
            while now - self._sent[0][0] > _LATE and now - self._sent[1][0] > _LATE:
                self._sent.popleft()
        if self._before and self._way(self._before[-1], measured) <= tolerance:
            self._before[-1] = measured  # still there, or on its way
        else:
            self._look_back(measured, tolerance, now)
            self._before.append(measured)
        if len(self._returns) < self._often or now - self._returns[0][0] > _WITHIN:
            return 0.0
        return self._returns[-1][1]

    def _look_back(self, measured: Floats, tolerance: float, now: float) -> None:
        """Whether another place is the one before the last again."""
        if len(self._before) < 2:
            return
        start, out = self._before
        way = min(self._way(start, out), self._way(out, measured))
        back = way > tolerance and self._way(start, measured) < _BACK * way
        if back and max(map(self._off, (start, out, measured))) > tolerance:
            self._returns.append((now, way))

    def _way(self, first: Floats, last: Floats) -> float:
        return largest_way(first, last, self._units)

    def _off(self, place: Floats) -> float:
        """How far a place is from all that the motors were sent through [rad, rod lengths]."""
        if not self._sent:
            return np.inf
        sent = np.array([commands for _, commands in self._sent])
        return self._way(place, np.clip(place, sent.min(axis=0), sent.max(axis=0)))


def apart_in_words(way: float) -> str:
    """That motors are measured in two places."""
    return (
        f"the motors are measured in two places in turn, {way:.1g} (rad or rod lengths) apart: is there "
        "another robot, or somebody else who says where its motors are?"
    )
