# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is logged once a second at most, whatever becomes of the clock of the computer."""

from __future__ import annotations

from typing import Any

from rclpy.clock import Clock, ClockType

__all__ = ["ONCE_A_SECOND"]

#: Arguments of a logger of rclpy. It asks the clock of the computer by itself: where that was set back
#: by an hour nothing was logged for an hour.
ONCE_A_SECOND: dict[str, Any] = {
    "throttle_duration_sec": 1.0,
    "throttle_time_source_type": Clock(clock_type=ClockType.STEADY_TIME),
}
