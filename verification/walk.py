# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the platform holds the tips on the way from straight legs to its joints."""

from __future__ import annotations

from scipy.spatial.transform import Rotation

from .placed_robot import Frame, PlacedRobot, tip_frame

__all__ = ["between", "bowed", "gathered"]


def bowed(robot: PlacedRobot, number: int, part: float) -> Frame:
    """Where the tip of a leg is held while the leg is bent evenly, in the platform.

    Args:
        robot: The robot.
        number: Of the leg.
        part: Of the bow, from 0 to 1.
    """
    leg = robot.legs[number]
    return robot.platform.inverse @ Frame(leg.clamp.rotation, leg.bowed_tip(part))


def gathered(robot: PlacedRobot, number: int, part: float) -> Frame:
    """Where it is held on the way from there to its joint on the platform.

    Args:
        robot: The robot.
        number: Of the leg.
        part: Of the way, from 0 to 1.
    """
    return between(bowed(robot, number, 1.0), tip_frame(robot.legs[number].tip), part)


def between(begin: Frame, end: Frame, part: float) -> Frame:
    """A frame on the straight way from one to another.

    Args:
        begin: Where the way begins.
        end: Where it ends.
        part: Of the way, from 0 to 1.
    """
    turn = Rotation.from_matrix(begin.rotation.T @ end.rotation).as_rotvec()
    rotation = begin.rotation @ Rotation.from_rotvec(part * turn).as_matrix()
    return Frame(rotation, begin.position + part * (end.position - begin.position))
