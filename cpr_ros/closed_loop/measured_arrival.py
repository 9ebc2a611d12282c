# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When a goal is reached where the platform is measured, not only in the model. No rclpy here."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cpr_msgs.action import MoveTo

from cpr_core import InvalidRequest
from cpr_core.validation import checked_number

from ..following.pose_coordinates import PoseCoordinates
from .loop_status import Loop, LoopStatus

__all__ = ["MeasuredArrival", "measured_arrival"]


@dataclass(frozen=True)
class MeasuredArrival:
    """How near the measured platform has to be to its target.

    Attributes:
        position_tolerance: Largest distance [m]; 0: it is not asked for.
        rotation_tolerance: Largest angle [rad]; 0: it is not asked for.
    """

    position_tolerance: float
    rotation_tolerance: float

    @property
    def asked(self) -> bool:
        """Whether anything has to be measured."""
        return self.position_tolerance > 0.0 or self.rotation_tolerance > 0.0

    def met(self, measured: LoopStatus) -> bool:
        """Whether the platform is measured there, at rest; holds where nothing is asked for."""
        if not self.asked:
            return True
        return (
            measured.loop == Loop.CLOSED
            and measured.at_setpoint
            and (not self.position_tolerance or measured.position_error <= self.position_tolerance)
            and (not self.rotation_tolerance or measured.rotation_error <= self.rotation_tolerance)
        )

    def hindrance(self, measured: LoopStatus) -> str:
        """Why the platform cannot come nearer where the model is at its target; empty if it may."""
        if not self.asked or measured.loop == Loop.CLOSED:
            return ""
        return measured.text or "no measured pose has come"


def measured_arrival(goal: MoveTo.Goal, coordinates: PoseCoordinates) -> MeasuredArrival:
    """What a goal of ~/move_to asks for.

    Args:
        goal: The goal.
        coordinates: What the robot controls.

    Raises:
        InvalidRequest: A negative tolerance, or one of what the goal does not control.
    """
    nowhere = coordinates.way(coordinates.nowhere, coordinates.nowhere)
    tolerances, sizes = [], coordinates.sizes(nowhere)
    for name, size in zip(("position_tolerance", "rotation_tolerance"), sizes, strict=True):
        tolerance = checked_number(name, getattr(goal, name))
        if tolerance < 0.0:
            raise InvalidRequest(name, f"expected a positive number or 0, got {tolerance}")
        if tolerance > 0.0 and goal.given != MoveTo.Goal.GIVEN_POSE:
            raise InvalidRequest(name, "expected 0 with motors: measured is the platform")
        if tolerance > 0.0 and math.isnan(size):
            part = name.removesuffix("_tolerance")
            raise InvalidRequest(name, f"expected 0, the robot does not control the {part}")
        tolerances.append(tolerance)
    return MeasuredArrival(*tolerances)
