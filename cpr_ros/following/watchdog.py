# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How old the newest input is, by receipt on a steady clock."""

from __future__ import annotations

import math

__all__ = ["Watchdog"]


class Watchdog:
    """Age of the newest of a stream of inputs. Stamps of messages decide nothing.

    Attributes:
        timeout: Age beyond which an input is stale [s]; 0: never.
    """

    def __init__(self, timeout: float) -> None:
        """Start without any input."""
        self.timeout = timeout
        self._received = math.nan

    def feed(self, now: float) -> None:
        """Take note of an input received now [s]."""
        self._received = now

    def forget(self) -> None:
        """Be as if nothing had ever come."""
        self._received = math.nan

    def age(self, now: float) -> float:
        """Time since the newest input [s]; -1 before the first."""
        return -1.0 if math.isnan(self._received) else max(0.0, now - self._received)

    @property
    def expires(self) -> bool:
        """Whether time alone will make the newest input stale, if it has not."""
        return self.timeout > 0.0 and not math.isnan(self._received)

    def stale(self, now: float) -> bool:
        """Whether there was an input and it is too old."""
        return self.timeout > 0.0 and self.age(now) > self.timeout
