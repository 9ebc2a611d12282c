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

#: Measured there and back so often, within so long [s]: one wrong number is none of it.
_OFTEN, _WITHIN = 3, 3.0
#: What comes back to less than this part of the way out, or goes out with the commands so far, is a part
#: of the way.
_BACK = 0.5


class TwoPlaces:
    """Looks for measurements that go out and come back while the commands do not."""

    def __init__(self, robot: Robot, often: int = _OFTEN) -> None:
        """Know of no measurement.

        Args:
            robot: The robot.
            often: How often they have to come back.
        """
        self._units = robot.motor_units.tolist()
        #: The last two measurements with the commands of then.
        self._before: deque[tuple[Floats, Floats | None]] = deque(maxlen=2)
        #: When one came back, and from how far.
        self._often, self._returns = often, deque[tuple[float, float]](maxlen=often)

    def take(
        self, measured: Floats, commands: Floats | None, tolerance: float, now: float
    ) -> float:
        """Take measured motors; how far apart the places are [rad, rod lengths], 0 where there is one.

        Args:
            measured: (n,) [rad or m].
            commands: Where they were sent, (n,): what is as near to that as is tolerated is one place.
                None: nobody knows.
            tolerance: Ways that are no larger do not matter.
            now: Steady time [s].
        """
        if len(self._before) == 2:
            (start, at_start), (out, at_out) = self._before
            way = min(self._way(start, out), self._way(out, measured))
            others = (
                self._way(start, measured),
                self._way(at_start, at_out),
                self._way(at_out, commands),
            )
            away = max(
                self._way(start, at_start), self._way(out, at_out), self._way(measured, commands)
            )
            elsewhere = commands is None or away > tolerance
            if elsewhere and way > tolerance and max(others) < _BACK * way:
                self._returns.append((now, way))
        self._before.append((measured, commands))
        if len(self._returns) < self._often or now - self._returns[0][0] > _WITHIN:
            return 0.0
        return self._returns[-1][1]

    def _way(self, first: Floats | None, last: Floats | None) -> float:
        """Largest way of a motor; none where one of the places is not known."""
        if first is None or last is None:
            return 0.0
        return largest_way(first, last, self._units)


def apart_in_words(way: float) -> str:
    """That motors are measured in two places."""
    return (
        f"the motors are measured in two places in turn, {way:.1g} (rad or rod lengths) apart: is there "
        "another robot, or somebody else who says where its motors are?"
    )
