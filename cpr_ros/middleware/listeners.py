# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether anybody listens to a publisher. DDS takes as long to say so as to stamp a message."""

from __future__ import annotations

import math
from typing import Any

from ..process.periodic import LOOK

__all__ = ["Listeners"]


class Listeners:
    """Those of one publisher.

    Attributes:
        any: Whether there was any when that was asked last.
    """

    def __init__(self, publisher: Any) -> None:
        """Ask nothing yet.

        Args:
            publisher: Of rclpy.
        """
        self._publisher = publisher
        self.any, self._asked = False, -math.inf

    def now(self, now: float) -> bool:
        """Whether there is any, at a steady time [s]: for what is said once."""
        self.any, self._asked = self._publisher.get_subscription_count() > 0, now
        return self.any

    def lately(self, now: float) -> bool:
        """The same, as it was within the last 0.1 s: for what is said again soon."""
        return self.any if now < self._asked + 0.9 * LOOK else self.now(now)
