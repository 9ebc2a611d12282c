# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How long measured motors rest though their commands are elsewhere. No ROS here.

Motors that are late rest as well while commands go on: they do what these did a while ago. So time
counts only while commands are elsewhere than they were when the motors moved last. A pause before, a
slow beginning, or a way there and back that is too short to be seen of the motors, tells nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

from .motor_ways import largest_way

__all__ = ["GONE_ON", "RESTING", "Standstill"]

Floats = NDArray[np.float64]

#: Motors that move by less are at rest [rad, rod lengths].
RESTING = 0.01
#: Commands have gone on when they are farther away than this: motors that are late may rest anywhere
#: within `RESTING`, and may have been sent to either side of it [rad, rod lengths].
GONE_ON = 2.0 * RESTING


class Standstill:
    """Compares when motors move with when their commands do.

    Attributes:
        since: Steady time since when the motors rest [s].
    """

    def __init__(self, robot: Robot) -> None:
        """Know of no motors yet."""
        self._units = robot.motor_units.tolist()
        self._motors: Floats | None = None
        self.since = math.inf
        self.begin(None)

    def begin(self, command: Floats | None) -> None:
        """The motors are taken to follow as far as this command, (n,); None: the next one."""
        self._followed, self._left_since = command, math.inf
        self._late, self._before = False, 0.0

    def measured(self, motors: Floats, command: Floats | None, now: float) -> None:
        """Take measured motors, and where they were sent last; (n,) each, None: nowhere yet."""
        if self._motors is None or largest_way(self._motors, motors, self._units) > RESTING:
            self._motors, self.since = motors, now
            self.begin(command)

    def commanded(self, command: Floats, now: float, late: bool) -> None:
        """Take note of where the motors are sent.

        Args:
            command: (n,) [rad or m].
            now: Steady time [s].
            late: Whether they are behind by more than is tolerated, or commands wait for them.
        """
        if self._followed is None:
            self._followed = command
        if late or largest_way(self._followed, command, self._units) > GONE_ON:
            self._left_since, self._late = min(self._left_since, now), self._late or late
        elif self._left_since < math.inf:
            # They are back. Motors that follow would have been seen to move, if it was far.
            self._before += self._late * (now - self._left_since)
            self._left_since, self._late = math.inf, False

    def lasted(self, now: float) -> float:
        """How long the commands have been elsewhere since the motors moved last [s]."""
        return self._before + max(0.0, now - self._left_since)
