# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What limits a motion: measures and their thresholds, speed, age of the setpoint. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from cpr_core.model.assessment import MEASURES, Thresholds

__all__ = ["ON_WAY_TO_MOTORS", "ON_WAY_TO_POSES", "WATCHED", "Settings"]

#: Measures that count on the way to motors.
ON_WAY_TO_MOTORS = tuple(name for name, measure in MEASURES.items() if not measure.of_poses)
ON_WAY_TO_POSES = tuple(MEASURES)
#: Measures that may count together.
WATCHED = (ON_WAY_TO_MOTORS, ON_WAY_TO_POSES)


@dataclass(frozen=True)
class Settings:
    """What may change while the node runs.

    Attributes:
        thresholds: Of every measure.
        hysteresis: Of the action, as a fraction of the way between the thresholds.
        max_speed: Speed no motor exceeds, behind its gear [rad/s, rod lengths/s].
        setpoint_timeout: Age beyond which a setpoint is not followed further [s]; 0: never.
    """

    thresholds: Thresholds
    hysteresis: float
    max_speed: float
    setpoint_timeout: float
