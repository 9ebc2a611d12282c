# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What was asked of a robot in vain: why, and its ghost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..drawing.robot_lines import POINTS, RobotLines, platform_outline, robot_lines
from ..model.equilibrium import Equilibrium
from ..model.shape import Pose, state_shapes

__all__ = ["Asked", "Refused", "ghost_lines"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Asked:
    """What was asked for; what is None stays as it is.

    Attributes:
        motors: Motor positions, (n,) [rad or m].
        platform: Where the platform was to be.
        loads: What was to act.
    """

    motors: Floats | None = None
    platform: Pose | None = None
    loads: Loads | None = None


@dataclass(frozen=True, eq=False)
class Refused:
    """A request that was not met.

    Attributes:
        reason: Why, in words.
        kind: What stopped it: kind of the event on the way, or code of the error.
        asked: What was asked for; None: numbers that mean nothing.
    """

    reason: str
    kind: str
    asked: Asked | None = None


def ghost_lines(equilibrium: Equilibrium, asked: Asked) -> RobotLines:
    """What can be drawn of a request without an equilibrium.

    The legs are as bent as they are now, with the motors where they were to be; the platform is where it
    was to be. So legs do not meet the platform: no shape of the robot does.

    Args:
        equilibrium: The last good one.
        asked: The request.
    """
    robot, state = equilibrium.robot, equilibrium.state.copy()
    platform = Pose(equilibrium.platform_rotation, equilibrium.platform_position)
    if asked.motors is not None:
        state[robot.motor_indices] = asked.motors
    if asked.platform is not None:
        platform = asked.platform
    lines = robot_lines(robot, state_shapes(robot, state, POINTS))
    holds = np.array([leg.joint.position for leg in robot.description.legs])
    corners = platform.position + holds @ platform.rotation.T
    moved = () if asked.motors is None else lines.rods
    return RobotLines(
        rods=moved,
        shades=(),
        links=lines.links if moved else np.zeros((0, 2, 3)),
        joints=np.zeros((0, 3)),
        driven=np.zeros(0, np.bool_),
        platform=corners[platform_outline(robot)],
    )
