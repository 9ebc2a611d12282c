# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories of the RFRFR robot, as messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

HOME = np.array([2.59, 0.55])
NAMES = ["motor1", "motor2"]
#: Straight into the instability of the RFRFR robot.
DOWN = HOME + [4.0, -4.0]


def trajectory(
    times: Sequence[float],
    positions: Sequence[Any],
    velocities: Sequence[Any] | None = None,
    names: Sequence[str] = NAMES,
) -> JointTrajectory:
    """A trajectory through positions at times [s]."""
    message = JointTrajectory(joint_names=names)
    for number, (seconds, row) in enumerate(zip(times, positions, strict=True)):
        nanoseconds = round(seconds * 1e9)
        point = JointTrajectoryPoint(
            positions=np.asarray(row, float).tolist(),
            time_from_start=Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9),
        )
        if velocities is not None:
            point.velocities = np.asarray(velocities[number], float).tolist()
        message.points.append(point)
    return message
