# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Points of timed trajectories as messages, and their times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from builtin_interfaces.msg import Duration, Time
from numpy.typing import NDArray
from trajectory_msgs.msg import JointTrajectoryPoint

__all__ = ["FeedbackPoints", "duration_of", "point_message", "seconds_of"]

Floats = NDArray[np.float64]


class FeedbackPoints(NamedTuple):
    """Where a trajectory has the motors, where they are, and the difference.

    Attributes:
        desired: By the trajectory.
        actual: Measured, or commanded where nobody measures.
        error: Desired minus actual.
    """

    desired: JointTrajectoryPoint
    actual: JointTrajectoryPoint
    error: JointTrajectoryPoint


def seconds_of(span: Duration | Time) -> float:
    """A duration or a time [s]."""
    return float(span.sec) + 1e-9 * float(span.nanosec)


def duration_of(seconds: float) -> Duration:
    """A time since the start of a trajectory, which may be negative [s]."""
    nanoseconds = round(seconds * 1e9)
    return Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def point_message(
    time: float, positions: Floats, velocities: Floats | None, accelerations: Floats | None = None
) -> JointTrajectoryPoint:
    """A point, in motor order; None: unknown."""
    return JointTrajectoryPoint(
        positions=positions.tolist(),
        velocities=[] if velocities is None else velocities.tolist(),
        accelerations=[] if accelerations is None else accelerations.tolist(),
        time_from_start=duration_of(time),
    )
