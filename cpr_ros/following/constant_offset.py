# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that are off their commands by the same wherever they are begun with. No ROS here.

A coupling has slipped, or who measures has another zero than who drives. Whoever begins where such
motors are measured sends them farther by the offset with the next command, and so on. Motors that are
late, or jam, are on the way of their commands; those that others move follow again afterwards.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot

__all__ = ["ConstantOffset"]

Floats = NDArray[np.float64]

#: Farther beside the way of its commands than this part of what is tolerated a motor has left it.
_BESIDE = 0.5
#: Motors follow that were where commands have sent them for so long: others may move them later [s].
_FOLLOWING = 1.0


class ConstantOffset:
    """Compares how far motors are off their commands before and after they were begun with."""

    def __init__(self, robot: Robot) -> None:
        """Know of no motors yet."""
        self._robot = robot
        self._before: Floats | None = None
        self.begin(None)

    def begin(self, place: Floats | None) -> None:
        """The way of the commands begins where the motors are, (n,); None: with the first of them."""
        self._low = self._high = place
        #: Since when they are where commands have sent them; infinite before the first command.
        self._since, self._left = math.inf, np.zeros(self._robot.motor_count, bool)

    def begun_with(self, off: Floats) -> None:
        """The motors are begun with where they are off their commands by (n,) [rad or m]."""
        self._before = off

    def sent(self, command: Floats, now: float) -> None:
        """Take note of where the motors are sent, (n,), at a steady time [s]."""
        self._since = min(self._since, now)
        if self._low is None or self._high is None:
            self._low = self._high = command
        else:
            self._low = np.minimum(self._low, command)
            self._high = np.maximum(self._high, command)

    def take(self, measured: Floats, commands: Floats, tolerance: float, now: float) -> str:
        """Take measured motors; that one is off its command as before, in words, empty if none is.

        Args:
            measured: Where they are, (n,) [rad or m].
            commands: Where they were sent last, (n,).
            tolerance: How far from there they may be [rad, rod lengths].
            now: Steady time [s].
        """
        before, allowed = self._before, tolerance * self._robot.motor_units
        if before is None or now < self._since:
            return ""
        off = measured - commands
        far = np.abs(off) > allowed
        if far.any():
            self._since = now
        elif now - self._since >= _FOLLOWING:
            self._before = None
        same = far & (np.abs(before) > allowed) & (np.abs(off - before) <= allowed)
        beside = np.abs(measured - np.clip(measured, self._low, self._high))
        self._left |= same & (beside > _BESIDE * allowed)  # not one that overshoots for a moment
        again = np.flatnonzero(self._left & same)
        return self._words(int(again[0]), off) if again.size else ""

    def _words(self, number: int, off: Floats) -> str:
        """That a motor is off its command as before."""
        motor = self._robot.description.motors[number]
        return (
            f"{motor.name} was measured {off[number]:+.3g} {motor.unit} off its command, as it was "
            "before the node began where it is measured: a constant offset (a coupling that slipped, "
            "another zero of the encoder, a load that holds it off)? The node does not begin there "
            "again before it is activated anew"
        )
