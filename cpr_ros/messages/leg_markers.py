# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs, their links and joints, and the platform as markers for rviz."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from cpr_core import Robot
from cpr_core.drawing.robot_lines import RobotLines

from ..following.supervision import Action
from .frames import Frames

__all__ = ["leg_markers", "leg_width"]

#: Width of a leg in mean rod lengths of the robot, whatever its size.
_WIDTH = 0.008
_DARK, _LIGHT = (ColorRGBA(r=tone, g=tone, b=tone, a=1.0) for tone in (0.2, 0.85))
_ACTION_COLORS = {
    Action.NONE: (0.1, 0.7, 0.2),
    Action.SLOW: (0.95, 0.7, 0.1),
    Action.HALT: (0.85, 0.1, 0.1),
}


def leg_width(robot: Robot) -> float:
    """Width of the legs of a robot as they are drawn [m]; thicker than its rods, so that it is seen."""
    return _WIDTH * robot.mean_length


def leg_markers(
    lines: RobotLines, width: float, action: Action, by: str, frames: Frames, stamp: Time
) -> MarkerArray:
    """A line for every rod and one for the platform; links as thicker lines, joints as spheres.

    Args:
        lines: The robot.
        width: Of a rod [m], :func:`leg_width`; links are twice, joints three times as thick.
        action: What is asked for.
        by: ``strain``: every point by its bending curvature, from blue (straight) to red (the largest
            of the robot now, or half a turn per rod length if that is more); ``stability``: by the
            action asked for, green, amber, red.
        frames: Names of the frames.
        stamp: ROS time of the message.
    """
    color = ColorRGBA(a=1.0, **_rgb(_ACTION_COLORS[action]))
    markers = []
    for number, (rod, shades) in enumerate(zip(lines.rods, lines.shades, strict=True)):
        line = _line("legs", number, width, frames, stamp)
        line.points = [_point(position) for position in rod]
        if by == "strain":
            line.colors = [ColorRGBA(a=1.0, **_rgb(shade)) for shade in shades.tolist()]
        else:
            line.color = color
        markers.append(line)
    markers += _links_and_joints(lines, width, frames, stamp)
    platform = _line("platform", 0, width, frames, stamp)
    platform.points = [_point(position) for position in lines.platform]
    platform.color = _DARK
    if len(platform.points) >= 2:
        markers.append(platform)
    return MarkerArray(markers=markers)


def _links_and_joints(lines: RobotLines, width: float, frames: Frames, stamp: Time) -> list[Marker]:
    """All links in one marker, if there are any; all joints in one, dark where motors move them."""
    links = _line("links", 0, 2.0 * width, frames, stamp)
    links.type, links.color = Marker.LINE_LIST, _DARK
    links.points = [_point(end) for end in lines.links.reshape(-1, 3)]
    joints = _line("joints", 0, 3.0 * width, frames, stamp)
    joints.type = Marker.SPHERE_LIST
    joints.scale.y = joints.scale.z = joints.scale.x
    joints.points = [_point(position) for position in lines.joints]
    joints.colors = [_DARK if driven else _LIGHT for driven in lines.driven]
    return [marker for marker in (links, joints) if marker.points]


def _line(namespace: str, number: int, width: float, frames: Frames, stamp: Time) -> Marker:
    marker = Marker(
        header=Header(stamp=stamp, frame_id=frames.base),
        ns=namespace,
        id=number,
        type=Marker.LINE_STRIP,
        action=Marker.ADD,
    )
    marker.scale.x = width
    marker.pose.orientation.w = 1.0
    return marker


def _point(position: NDArray[np.float64]) -> Point:
    x, y, z = position.tolist()
    return Point(x=x, y=y, z=z)


def _rgb(color: Sequence[float]) -> dict[str, float]:
    return dict(zip("rgb", color, strict=True))
