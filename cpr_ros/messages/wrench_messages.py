# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What pushes on the platform, as messages; what is measured of it, from messages."""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import WrenchEstimate as WrenchEstimateMessage
from geometry_msgs.msg import PoseStamped, WrenchStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cpr_core import InvalidRequest, Robot, WrenchEstimate
from cpr_core.lie import quaternion_from_rotation, rotation_from_quaternion
from cpr_core.validation import checked_vector

from .conversions import Frames
from .geometry import LINEAR_FIRST, fill_wrench, quaternion_of, vector_of
from .motor_messages import measured_values

__all__ = ["estimated_wrench", "measured_efforts", "whole_pose", "wrench_estimate"]

Floats = NDArray[np.float64]


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
    """X y z qw qx qy qz of a pose in the base frame, (7,) [m].

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
