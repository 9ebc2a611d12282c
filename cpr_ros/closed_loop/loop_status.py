# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is told of the closed loop: whether the setpoint is corrected, and how far off the robot is."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

__all__ = ["Loop", "LoopStatus"]


class Loop(IntEnum):
    """LOOP constants of cpr_msgs/StabilityMetrics."""

    OPEN = 0
    CLOSED = 1
    FROZEN = 2


class LoopStatus(NamedTuple):
    """What a supervisor is told; made for every message of the stability stream.

    Attributes:
        loop: Whether the setpoint is corrected.
        text: Why the correction is frozen, or what is left aside; empty otherwise.
        age: Time since the newest measured pose came [s]; -1 before the first.
        position_error: Measured from wanted [m]; NaN while the loop is open, or not controlled.
        rotation_error: Measured from wanted [rad]; the same.
        at_setpoint: Whether the newest pose was measured since the model is at this setpoint; of
            several who measure it, the newest of everyone.
        blind: Whether it is frozen for want of a measured pose that can be believed.
    """

    loop: Loop = Loop.OPEN
    text: str = ""
    age: float = -1.0
    position_error: float = math.nan
    rotation_error: float = math.nan
    at_setpoint: bool = False
    blind: bool = False
