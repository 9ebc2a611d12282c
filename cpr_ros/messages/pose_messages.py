# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Poses of the platform as messages, and the controlled coordinates they mean."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import Pose, PoseStamped
from numpy.typing import NDArray

from cpr_core import InvalidQuaternion, InvalidRequest, Robot
from cpr_core.description.controlled_coordinates import pose_of
from cpr_core.lie import checked_quaternion, rotation_from_quaternion
from cpr_core.validation import checked_vector

from ..error_codes import RequestError
from .frames import Frames
from .geometry import quaternion_of, vector_of

__all__ = [
    "PoseNumbers",
    "check_pose_frame",
    "controlled_pose",
    "pose_from_message",
    "pose_numbers",
]

Floats = NDArray[np.float64]

#: Orientation of a platform of which the positions alone are read.
_UNTURNED = np.eye(3)


class PoseNumbers(NamedTuple):
    """Numbers of a pose.

    Attributes:
        position: x y z [m].
        orientation: Quaternion w x y z.
    """

    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]


def pose_numbers(message: Pose) -> PoseNumbers:
    """Numbers of a message."""
    return PoseNumbers(vector_of(message.position), quaternion_of(message.orientation))


def pose_from_message(
    robot: Robot, message: PoseStamped, controlled: list[str], frames: Frames, where: str = ""
) -> Floats:
    """Controlled coordinates in the order of the description.

    Args:
        robot: The robot.
        message: The pose.
        controlled: Coordinates that the sender takes for the controlled ones; empty: not said.
        frames: Names of the frames.
        where: What comes before the names of its fields in error messages.

    Raises:
        RequestError: The frame is not the base frame.
        InvalidRequest: Other coordinates named than the robot's.
        NonFiniteInput: A NaN or an infinity.
        InvalidQuaternion: No rotation, or in the plane one that leaves it.
    """
    check_pose_frame(message.header.frame_id, frames, where)
    description = robot.description
    if controlled and sorted(controlled) != sorted(description.controlled):
        raise InvalidRequest(
            "controlled",
            f"expected {', '.join(description.controlled)}, got {', '.join(controlled)}",
        )
    return controlled_pose(robot, pose_numbers(message.pose), where=where)


def check_pose_frame(frame: str, frames: Frames, where: str = "") -> None:
    """Whether a pose is given in the base frame, by its name or by none.

    Raises:
        RequestError: It is another frame; ``where`` comes before the name of the field.
    """
    if frame not in ("", frames.base):
        raise RequestError(
            ErrorCode.FRAME_TRANSFORM_FAILURE,
            f"{where}header.frame_id: expected {frames.base!r}, got {frame!r}",
        )


def controlled_pose(
    robot: Robot, pose: PoseNumbers, *, tilt: float = 1e-9, where: str = ""
) -> Floats:
    """Controlled coordinates of a pose in the base frame, in the order of the description.

    Args:
        robot: The robot.
        pose: Its numbers.
        tilt: By how much of 1 - cos(angle) the pose of a planar robot may leave the plane.
        where: What comes before the names of its fields in error messages.

    Raises:
        NonFiniteInput: A NaN or an infinity.
        InvalidQuaternion: No rotation, or in the plane one that leaves it.
    """
    controlled, rotation = robot.description.controlled, _UNTURNED
    values = dict(zip("xyz", pose.position, strict=True))
    read = [name for name in controlled if name in values]
    place = [values[name] for name in read]
    if not all(map(math.isfinite, place)):
        checked_vector(f"{where}pose.position", place, len(read), " ".join(read))
    if len(read) < len(controlled):
        try:
            if "orientation" in controlled:
                checked_quaternion(pose.orientation)
            else:
                rotation = rotation_from_quaternion(pose.orientation)
        except InvalidRequest as error:
            raise type(error)(f"{where}pose.orientation", error.problem) from None
        if robot.planar and 1.0 - rotation[2, 2] > tilt:
            raise InvalidQuaternion(
                f"{where}pose.orientation", "expected a rotation about z for a planar robot"
            )
    position, quaternion = map(np.array, pose)
    return pose_of(controlled, position, rotation, lambda: quaternion)
