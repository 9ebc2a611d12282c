# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the markers of a node back to the lines of its robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from cpr_core.drawing.robot_lines import RobotLines

__all__ = ["lines_of"]

Floats = NDArray[np.float64]


def lines_of(markers: MarkerArray) -> RobotLines:
    """What ``leg_markers`` has drawn."""
    by_name: dict[str, list[Marker]] = {}
    for marker in markers.markers:
        by_name.setdefault(marker.ns, []).append(marker)
    rods = by_name.get("legs", [])
    links = [_points(marker.points) for marker in by_name.get("links", [])]
    joints = [_points(marker.points) for marker in by_name.get("joints", [])]
    tones = [color for marker in by_name.get("joints", []) for color in marker.colors]
    platform = [_points(marker.points) for marker in by_name.get("platform", [])]
    nothing = [np.zeros((0, 3))]
    return RobotLines(
        rods=tuple(_points(marker.points) for marker in rods),
        shades=tuple(
            _colors(marker.colors or [marker.color] * len(marker.points)) for marker in rods
        ),
        links=np.concatenate(links or nothing).reshape(-1, 2, 3),
        joints=np.concatenate(joints or nothing),
        driven=np.array([color.r < 0.5 for color in tones], np.bool_),
        platform=np.concatenate(platform or nothing),
    )


def _points(points: Sequence[Point]) -> Floats:
    return np.array([(point.x, point.y, point.z) for point in points]).reshape(-1, 3)


def _colors(colors: Sequence[ColorRGBA]) -> Floats:
    return np.array([(color.r, color.g, color.b) for color in colors]).reshape(-1, 3)
