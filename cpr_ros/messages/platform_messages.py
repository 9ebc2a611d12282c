# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured poses and twists of the platform from messages."""

from __future__ import annotations

import numpy as np
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import PoseStamped, TwistStamped
from numpy.typing import NDArray
from rclpy.time import Time
from std_msgs.msg import Header

from cpr_core import Equilibrium, InvalidQuaternion, InvalidRequest, NonFiniteInput, Robot
from cpr_core.description.controlled_coordinates import CONTROLLED_COORDINATES
from cpr_core.lie import quaternion_from_rotation, rotation_from_quaternion, turned
from cpr_core.solving.requests import pose_meaning
from cpr_core.validation import checked_vector

from ..closed_loop.jogging import PlatformTwist
from ..error_codes import RequestError
from .frames import Frames
from .geometry import (
    TWIST_FIELDS,
    fill_quaternion,
    fill_vector,
    quaternion_of,
    twist_of,
    vector_of,
)
from .pose_messages import controlled_pose, pose_numbers

__all__ = ["measured_pose", "measurement_delay", "platform_in_base", "platform_twist"]

#: Tilt out of the plane, 1 - cos(angle), that a measured pose may have: 0.2 rad.
_TILT = 0.02
#: Part of the largest component of a twist that turning its axes may leave in others.
_ROUNDING = 1e-9


def measured_pose(robot: Robot, message: PoseStamped) -> NDArray[np.float64]:
    """Controlled coordinates of a pose measured in the base frame; in the plane without a small tilt.

    Raises:
        InvalidRequest: The robot controls no coordinates.
        InvalidQuaternion: No rotation, where the robot controls one.
        NonFiniteInput: A NaN or an infinity in a controlled coordinate.
    """
    _check_controlled(robot)
    turning = [name for name in robot.description.controlled if CONTROLLED_COORDINATES[name].turns]
    orientation = np.array(quaternion_of(message.pose.orientation))
    if turning and not _measured(orientation):
        error = InvalidQuaternion if np.isfinite(orientation).all() else NonFiniteInput
        raise error(
            "pose.orientation",
            f"expected a rotation, as the robot controls {' and '.join(turning)}: points alone "
            f"cannot close its loop; got w x y z {orientation.tolist()}",
        )
    pose = controlled_pose(robot, pose_numbers(message.pose), tilt=_TILT)
    return checked_vector("pose", pose, len(pose), " ".join(pose_meaning(robot)))


def platform_in_base(current: Equilibrium, message: PoseStamped, frames: Frames) -> PoseStamped:
    """A measured pose as that of the platform in the base frame, of one in the tracker's frame too.

    A platform that is a point does not turn, whatever its marker does. Where the orientation of another
    one was not measured (all zeros, or NaN) it stays so, and the marker's arm is turned as the model is.

    Args:
        current: Equilibrium of the model.
        message: The pose.
        frames: Names of the frames.

    Raises:
        RequestError: Another frame, or a robot whose description has no tracker.
        InvalidQuaternion: No rotation, in the tracker's frame.
        NonFiniteInput: A NaN or an infinity, in the tracker's frame.
    """
    description = current.robot.description
    frame, tracker = message.header.frame_id or frames.base, description.tracker
    if frame == frames.base:
        return message
    if frame != frames.tracker or tracker is None:
        known = repr(frames.base) + ("" if tracker is None else f" or {frames.tracker!r}")
        raise RequestError(
            ErrorCode.FRAME_TRANSFORM_FAILURE,
            f"header.frame_id: expected {known}, got {frame!r}",
        )
    told = checked_vector("pose.position", vector_of(message.pose.position), 3, "x y z")
    orientation = np.array(quaternion_of(message.pose.orientation))
    if description.point_platform:
        position = tracker.position + tracker.rotation @ told - tracker.marker_position
        orientation = np.array([1.0, 0.0, 0.0, 0.0])
    elif _measured(orientation):
        position, rotation = tracker.platform_in_world(told, rotation_from_quaternion(orientation))
        orientation = quaternion_from_rotation(rotation)
    else:
        arm = current.platform_rotation @ tracker.marker_position
        position = tracker.position + tracker.rotation @ told - arm
    found = PoseStamped(header=Header(stamp=message.header.stamp, frame_id=frames.base))
    fill_vector(found.pose.position, position)
    fill_quaternion(found.pose.orientation, orientation)
    return found


def _measured(orientation: NDArray[np.float64]) -> bool:
    """Whether a quaternion was measured: who measures none sends zeros, or NaN."""
    return bool(orientation.any()) and not bool(np.isnan(orientation).any())


def measurement_delay(header: Header, now: Time) -> float:
    """Time since a message was stamped [s]; 0 without a stamp, negative for one from the future."""
    stamp = header.stamp
    if stamp.sec == 0 and stamp.nanosec == 0:
        return 0.0
    return 1e-9 * (now.nanoseconds - 10**9 * stamp.sec - stamp.nanosec)


def platform_twist(robot: Robot, message: TwistStamped, frames: Frames) -> PlatformTwist:
    """Twist of the platform, its axes those of the base frame, of one fixed to it, or of the platform.

    Raises:
        RequestError: The frame is not known.
        InvalidRequest: A component that moves no controlled coordinate of the robot.
        NonFiniteInput: A NaN or an infinity.
    """
    twist = checked_vector("twist", twist_of(message.twist), 6, " ".join(TWIST_FIELDS))
    _check_controlled(robot)
    frame = message.header.frame_id or frames.base
    if frame not in (frames.base, frames.platform):
        twist = _turned_to_base(twist, frame, frames)
    _check_moves(robot, twist)
    return PlatformTwist(twist, in_platform=frame == frames.platform)


def _turned_to_base(twist: NDArray[np.float64], frame: str, frames: Frames) -> NDArray[np.float64]:
    """A twist of another frame in the base frame, without what is rounding of its largest component."""
    rotation = frames.rotation_to_base(frame) if frames.rotation_to_base else None
    if rotation is None:
        raise RequestError(
            ErrorCode.FRAME_TRANSFORM_FAILURE,
            f"header.frame_id: expected {frames.base!r} or {frames.platform!r}, got {frame!r}",
        )
    found = turned(twist, rotation)
    found[np.abs(found) <= _ROUNDING * np.abs(found).max()] = 0.0
    return found


def _check_moves(robot: Robot, twist: NDArray[np.float64]) -> None:
    """Refuse components that move no controlled coordinate: they would be lost without a word."""
    controlled = robot.description.controlled
    allowed = {TWIST_FIELDS[axis] for axis in robot.controlled_axes}
    wrong = [
        name
        for name, value in zip(TWIST_FIELDS, twist, strict=True)
        if value and name not in allowed
    ]
    if wrong:
        raise InvalidRequest(
            "twist",
            f"expected {' '.join(sorted(allowed))} only, as the robot controls "
            f"{' '.join(controlled)}; got {', '.join(wrong)} as well",
        )


def _check_controlled(robot: Robot) -> None:
    """Whether there is anything to correct or to jog."""
    if not robot.description.controlled:
        raise InvalidRequest(
            "controlled", f"{robot.description.name} controls no platform coordinates"
        )
