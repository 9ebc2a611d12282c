# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where motors that the node moves were measured last. No ROS here."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .watchdog import Watchdog

__all__ = ["MeasuredMotors", "Measurement"]


class Measurement(NamedTuple):
    """Measured motors.

    Attributes:
        motors: (n,) [rad or m].
        age: Time since they came [s].
    """

    motors: NDArray[np.float64]
    age: float


class MeasuredMotors:
    """The newest measurement, as long as it is not too old.

    Attributes:
        watchdog: Its age.
    """

    def __init__(self, timeout: float) -> None:
        """Know of none; they are too old after ``timeout`` [s], 0: never."""
        self.watchdog = Watchdog(timeout)
        self._motors: NDArray[np.float64] | None = None

    def take(self, motors: NDArray[np.float64], now: float) -> None:
        """Take measured motors, (n,), at a steady time [s]."""
        self._motors = motors
        self.watchdog.feed(now)

    def forget(self) -> None:
        """Be as if none had ever come."""
        self._motors = None
        self.watchdog.forget()

    def newest(self, now: float) -> Measurement | None:
        """The newest; None without, or where it is too old at a steady time [s]."""
        if self._motors is None or self.watchdog.stale(now):
            return None
        return Measurement(self._motors, self.watchdog.age(now))
