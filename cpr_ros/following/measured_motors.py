# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where motors that the node moves were measured last. No ROS here."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core.errors import distinct

from .watchdog import Watchdog

__all__ = ["MeasuredMotors", "MotorMeasurement", "SeenMotors"]

#: When none is ever too old, commands that wait for motors give up after this time without one [s].
_SILENT = 1.0


class MotorMeasurement(NamedTuple):
    """Measured motors.

    Attributes:
        motors: (n,) [rad or m].
        age: Time since they came [s].
    """

    motors: NDArray[np.float64]
    age: float


class SeenMotors(NamedTuple):
    """What is known of where motors are.

    Attributes:
        measured: The newest measurement; None: nobody knows.
        missing: Why nobody knows, though they are measured; empty: nobody measures.
    """

    measured: MotorMeasurement | None
    missing: str = ""


class MeasuredMotors:
    """The newest measurement, as long as it is not too old.

    Attributes:
        watchdog: Its age.
        heard: Whether one has ever come, also if it was forgotten since.
    """

    def __init__(self, timeout: float) -> None:
        """Know of none; they are too old after ``timeout`` [s], 0: never."""
        self.watchdog, self.heard = Watchdog(timeout), False
        self._motors: NDArray[np.float64] | None = None
        self._problem = ""

    def take(self, motors: NDArray[np.float64], now: float) -> None:
        """Take measured motors, (n,), at a steady time [s]."""
        self._motors, self._problem, self.heard = motors, "", True
        self.watchdog.feed(now)

    def refuse(self, problem: str) -> None:
        """Take note of a message that tells nothing of the motors."""
        self._problem = problem

    def forget(self) -> None:
        """Be as if none had ever come."""
        self._motors, self._problem = None, ""
        self.watchdog.forget()

    def newest(self, now: float) -> MotorMeasurement | None:
        """The newest; None without, or where it is too old at a steady time [s]."""
        if self._motors is None or self.watchdog.stale(now):
            return None
        return MotorMeasurement(self._motors, self.watchdog.age(now))

    @property
    def last_motors(self) -> NDArray[np.float64] | None:
        """Those that were measured last, (n,), however long ago; None: none ever were.

        Where nothing is measured any more commands are bound to these: motors may have stopped there.
        """
        return self._motors

    def seen(self, now: float) -> SeenMotors:
        """What is known of the motors at a steady time [s]."""
        return SeenMotors(self.newest(now), self.missing(now))

    def silent(self, now: float) -> str:
        """That none came for a while though none is ever too old, in words; empty otherwise."""
        if self._motors is None or self.watchdog.timeout or self.watchdog.age(now) < _SILENT:
            return ""
        return (
            f"none came for {_SILENT:g} s (measured_timeout 0); "
            "of motors that are measured only once, max_lead has to be 0"
        )

    def missing(self, now: float, *, with_age: bool = True) -> str:
        """Why there is no newest though somebody measures, or has measured; empty otherwise.

        Args:
            now: Steady time [s].
            with_age: Whether it is told how old the newest is, in other words every time.
        """
        if self.newest(now) is not None:
            return ""
        if self._motors is None:
            return f"no measured motors are of use: {self._problem}" if self._problem else ""
        why = f" ({self._problem})" if self._problem else ""
        how_old, timeout = "older than", f"{self.watchdog.timeout:g}"
        if with_age:
            age, timeout = distinct(self.watchdog.age(now), self.watchdog.timeout)
            how_old = f"{age} s old, more than"
        return f"the measured motors are {how_old} measured_timeout {timeout} s{why}"
