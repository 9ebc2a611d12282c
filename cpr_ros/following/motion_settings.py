# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What limits a motion: measures and their thresholds, speed, age of the setpoint. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from cpr_core.model.assessment import MEASURES, Thresholds

__all__ = ["ON_WAY_TO_MOTORS", "WATCHED", "Settings"]

#: Measures that count on the way to motors: the inverse problem matters to platform setpoints only.
ON_WAY_TO_MOTORS = tuple(name for name in MEASURES if name != "inverse_singularity")
#: Measures that may count together.
WATCHED = (ON_WAY_TO_MOTORS, MEASURES)


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
