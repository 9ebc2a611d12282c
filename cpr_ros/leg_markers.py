# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs, their links and joints, and the platform as markers for rviz."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from cpr_core import LegShape, Robot, leg_shapes

from .conversions import Frames
from .setpoint_following import Outcome
from .supervision import Action

__all__ = ["bending_curvature", "leg_markers", "shade"]

#: Points along a leg.
POINTS = 24
WIDTH = 0.006
_DARK, _LIGHT = (ColorRGBA(r=tone, g=tone, b=tone, a=1.0) for tone in (0.2, 0.85))
_ACTION_COLORS = {
    Action.NONE: (0.1, 0.7, 0.2),
    Action.SLOW: (0.95, 0.7, 0.1),
    Action.HALT: (0.85, 0.1, 0.1),
}


def leg_markers(outcome: Outcome, by: str, frames: Frames, stamp: Time) -> MarkerArray:
    """A line for every leg and one for the platform; links as thicker lines, joints as spheres.

    Args:
        outcome: Of the last tick.
        by: ``strain``: every point by its bending curvature, from blue (straight) to red (the largest
            of the robot now, or half a turn per rod length if that is more); ``stability``: by the
            action asked for, green, amber, red.
        frames: Names of the frames.
        stamp: ROS time of the message.
    """
    equilibrium = outcome.assessment.equilibrium
    robot = equilibrium.robot
    shapes = leg_shapes(equilibrium, POINTS)
    curvatures = [bending_curvature(shape.curvature) for shape in shapes]
    largest = max([np.pi / robot.mean_length, *(curvature.max() for curvature in curvatures)])
    action = ColorRGBA(a=1.0, **_rgb(_ACTION_COLORS[outcome.verdict.action]))
    markers = []
    for number, (shape, curvature) in enumerate(zip(shapes, curvatures, strict=True)):
        line = _line("legs", number, frames, stamp)
        line.points = [_point(position) for position in shape.position]
        if by == "strain":
            line.colors = [shade(float(value / largest)) for value in curvature]
        else:
            line.color = action
        markers.append(line)
    tips = [shape.position[-1] for shape in shapes]
    markers += _links_and_joints(shapes, frames, stamp)
    platform = _line("platform", 0, frames, stamp)
    platform.points = [_point(position) for position in _outline(robot, tips)]
    platform.color = _DARK
    if len(platform.points) >= 2:
        markers.append(platform)
    return MarkerArray(markers=markers)


def _links_and_joints(shapes: tuple[LegShape, ...], frames: Frames, stamp: Time) -> list[Marker]:
    """All links in one marker, if there are any; all joints in one, dark where motors move them."""
    pieces = [piece for shape in shapes for piece in shape.rigid_pieces]
    links = _line("links", 0, frames, stamp)
    links.type, links.scale.x, links.color = Marker.LINE_LIST, 2.0 * WIDTH, _DARK
    links.points = [_point(end) for piece in pieces for pair in pairwise(piece) for end in pair]
    joints = _line("joints", 0, frames, stamp)
    joints.type = Marker.SPHERE_LIST
    joints.scale.x = joints.scale.y = joints.scale.z = 3.0 * WIDTH
    for joint in (joint for shape in shapes for joint in shape.joints if joint.kind != "fixed"):
        joints.points.append(_point(joint.position))
        joints.colors.append(_LIGHT if joint.motor is None else _DARK)
    return [marker for marker in (links, joints) if marker.points]


def bending_curvature(curvature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Size of the bending part of (torsion, bending, bending), (P, 3) to (P,) [1/m]."""
    return np.hypot(curvature[:, 1], curvature[:, 2])


def shade(fraction: float) -> ColorRGBA:
    """From blue at 0 over green to red at 1."""
    value = min(1.0, max(0.0, fraction))
    return ColorRGBA(
        r=min(1.0, max(0.0, 2.0 * value - 1.0)),
        g=1.0 - abs(2.0 * value - 1.0),
        b=min(1.0, max(0.0, 1.0 - 2.0 * value)),
        a=1.0,
    )


def _outline(robot: Robot, tips: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
    """The tips around the platform, closed."""
    if len(tips) < 3:
        return tips
    holds = np.array([leg.joint.position for leg in robot.description.legs])
    center = holds.mean(axis=0)
    order = np.argsort(np.arctan2(*(holds - center)[:, 1::-1].T))
    return [tips[leg] for leg in (*order, order[0])]


def _line(namespace: str, number: int, frames: Frames, stamp: Time) -> Marker:
    marker = Marker(
        header=Header(stamp=stamp, frame_id=frames.base),
        ns=namespace,
        id=number,
        type=Marker.LINE_STRIP,
        action=Marker.ADD,
    )
    marker.scale.x = WIDTH
    marker.pose.orientation.w = 1.0
    return marker


def _point(position: NDArray[np.float64]) -> Point:
    x, y, z = position.tolist()
    return Point(x=x, y=y, z=z)


def _rgb(color: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip("rgb", color, strict=True))
