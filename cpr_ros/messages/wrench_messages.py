# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What pushes on the platform, as messages; what is measured of it, from messages."""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import ErrorCode
from cpr_msgs.msg import WrenchEstimate as WrenchEstimateMessage
from geometry_msgs.msg import PoseStamped, WrenchStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cpr_core import InvalidRequest, Loads, Robot, WrenchEstimate
from cpr_core.lie import quaternion_from_rotation, rotation_from_quaternion, turned
from cpr_core.validation import checked_vector

from ..error_codes import RequestError
from .frames import Frames
from .geometry import (
    LINEAR_FIRST,
    WRENCH_FIELDS,
    fill_wrench,
    quaternion_of,
    vector_of,
    wrench_of,
)
from .motor_messages import measured_values

__all__ = ["estimated_wrench", "measured_efforts", "whole_pose", "with_wrench", "wrench_estimate"]

Floats = NDArray[np.float64]


def with_wrench(loads: Loads, message: WrenchStamped, frames: Frames, where: str = "") -> Loads:
    """Loads with the platform wrench of a message: fixed in space or turning with the platform.

    The wrench acts at the platform origin, whatever its frame; another frame than the two gives only the
    directions of its axes. ``where`` comes before the names of its fields in error messages.

    Raises:
        RequestError: The frame is neither the base frame nor the platform frame.
        NonFiniteInput: A NaN or an infinity.
    """
    frame = message.header.frame_id or frames.base
    given = wrench_of(message.wrench)
    wrench = checked_vector(f"{where}wrench", given, 6, " ".join(WRENCH_FIELDS))
    nothing = np.zeros(6)
    if frame == frames.platform:
        return loads.with_(wrench_world=nothing, wrench_body=wrench)
    if frame != frames.base:
        rotation = frames.rotation_to_base(frame) if frames.rotation_to_base else None
        if rotation is None:
            raise RequestError(
                ErrorCode.FRAME_TRANSFORM_FAILURE,
                f"{where}header.frame_id: expected {frames.base!r} (fixed in space) or "
                f"{frames.platform!r} (turning with the platform), got {frame!r}",
            )
        wrench = turned(wrench, rotation)
    return loads.with_(wrench_world=wrench, wrench_body=nothing)


def measured_efforts(robot: Robot, message: JointState) -> Floats:
    """Efforts of the motors of the robot in the joint states of a machine that may have more.

    The same sign as in the joint states of the node: what the motor does to the rod.

    Raises:
        InvalidRequest: No efforts, a motor missing or twice, or not as many efforts as names.
        NonFiniteInput: A NaN or an infinity in a motor of the robot.
    """
    if not message.effort:
        raise InvalidRequest("effort", "measured_joint_states has no efforts")
    return measured_values(robot, message.name, "effort", message.effort)


def whole_pose(message: PoseStamped) -> Floats:
    """A pose in the base frame as x y z [m], qw qx qy qz, (7,).

    Raises:
        InvalidQuaternion: No rotation.
        NonFiniteInput: A NaN or an infinity.
    """
    position = checked_vector("position", vector_of(message.pose.position), 3, "x y z")
    rotation = rotation_from_quaternion(quaternion_of(message.pose.orientation))
    return np.concatenate([position, quaternion_from_rotation(rotation)])


def estimated_wrench(estimate: WrenchEstimate, frames: Frames, stamp: Time) -> WrenchStamped:
    """The wrench in the base frame, at the platform origin."""
    message = WrenchStamped(header=Header(stamp=stamp, frame_id=frames.base))
    fill_wrench(message.wrench, estimate.wrench_world)
    return message


def wrench_estimate(
    estimate: WrenchEstimate,
    frames: Frames,
    stamp: Time,
    *,
    with_pose: bool,
    latency: float,
    solve_time: float,
) -> WrenchEstimateMessage:
    """The same, with how well it is known.

    Args:
        estimate: What was estimated.
        frames: Names of the frames.
        stamp: Of the measurement.
        with_pose: Whether a measured pose was used.
        latency: Time since the stamp [s].
        solve_time: Time it took [s].
    """
    message = WrenchEstimateMessage(
        header=Header(stamp=stamp, frame_id=frames.base),
        covariance=estimate.covariance[np.ix_(LINEAR_FIRST, LINEAR_FIRST)].ravel(),
        felt=len(estimate.felt),
        coordinates=len(estimate.felt) + len(estimate.unfelt),
        unfelt=estimate.unfelt[:, LINEAR_FIRST].ravel().tolist(),
        words=estimate.words,
        observability=estimate.observability,
        chi_square=estimate.chi_square,
        degrees_of_freedom=estimate.degrees_of_freedom,
        consistency=estimate.consistency,
        with_pose=with_pose,
        latency=latency,
        solve_time=solve_time,
    )
    fill_wrench(message.wrench, estimate.wrench_world)
    return message
