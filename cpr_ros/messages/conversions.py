# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Between messages and values of the core."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from cpr_msgs.msg import Loads as LoadsMessage
from geometry_msgs.msg import Pose, PoseStamped, WrenchStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState

from cpr_core import Equilibrium, InvalidQuaternion, InvalidRequest, Loads, Robot
from cpr_core.description.controlled_coordinates import pose_of
from cpr_core.lie import rotation_from_quaternion, turned
from cpr_core.solving.refining import restore_equilibrium
from cpr_core.validation import checked_vector

from ..error_codes import RequestError
from .geometry import (
    WRENCH_FIELDS,
    fill_quaternion,
    fill_vector,
    fill_wrench,
    quaternion_of,
    vector_of,
    wrench_of,
)
from .motor_messages import motors_from_joint_state

__all__ = [
    "Frames",
    "PoseNumbers",
    "check_pose_frame",
    "controlled_pose",
    "equilibrium_from_message",
    "fill_equilibrium",
    "joint_state",
    "platform_pose",
    "pose_from_message",
    "pose_numbers",
    "with_wrench",
]

Floats = NDArray[np.float64]

#: Orientation of a platform of which the positions alone are read.
_UNTURNED = np.eye(3)


@dataclass(frozen=True)
class Frames:
    """Names of the frames the node knows.

    Attributes:
        base: Frame fixed in space, in which the description is written.
        platform: Frame of the platform.
        rotation_to_base: Rotation from another frame to the base frame, (3, 3), or None if it is not
            known; None where nobody knows other frames.
        tracker: Frame of the tracker, where the description of the robot has one.
    """

    base: str
    platform: str
    rotation_to_base: Callable[[str], Floats | None] | None = None
    tracker: str = "tracker"


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
    checked_vector(
        f"{where}pose.position", [values[name] for name in read], len(read), " ".join(read)
    )
    if len(read) < len(controlled):
        try:
            rotation = rotation_from_quaternion(pose.orientation)
        except InvalidRequest as error:
            raise type(error)(f"{where}pose.orientation", error.problem) from None
        if robot.planar and 1.0 - rotation[2, 2] > tilt:
            raise InvalidQuaternion(
                f"{where}pose.orientation", "expected a rotation about z for a planar robot"
            )
    position, quaternion = map(np.array, pose)
    return pose_of(controlled, position, rotation, lambda: quaternion)


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


def equilibrium_from_message(robot: Robot, message: EquilibriumMessage) -> Equilibrium:
    """The equilibrium a message holds, checked.

    Raises:
        InvalidRequest: It is no equilibrium of this robot.
        NonFiniteInput: A NaN or an infinity.
        InvalidQuaternion: No rotation.
    """
    by_effort, motors = motors_from_joint_state(robot, message.motors, "equilibrium.motors")
    if by_effort:
        raise InvalidRequest("equilibrium.motors.position", "expected positions, got none")
    loads = robot.default_loads
    for given in message.loads:  # one at most
        # Forces on the rods are the description's; a message does not carry them.
        loads = loads.with_(
            gravity=vector_of(given.gravity),
            wrench_world=wrench_of(given.wrench_in_base),
            wrench_body=wrench_of(given.wrench_in_platform),
        )
    position, orientation = pose_numbers(message.platform_in_base)
    return restore_equilibrium(
        robot,
        loads,
        motors,
        message.leg_coordinates,
        message.multipliers,
        rotation_from_quaternion(orientation),
        position,
    )


def fill_equilibrium(
    message: EquilibriumMessage,
    equilibrium: Equilibrium,
    frames: Frames,
    stamp: Time,
    solve_time: float,
    *,
    eigenvalues: bool,
) -> None:
    """Write everything about an equilibrium; without eigenvalues what needs them is NaN.

    Parts are written into those the message has: rclpy makes them anyway, and making them again takes
    longer than writing.
    """
    message.header.stamp, message.header.frame_id = stamp, frames.base
    _fill_joint_state(message.motors, equilibrium, frames, stamp)
    _fill_pose(message.platform_in_base, equilibrium)
    message.leg_coordinates = _doubles(equilibrium.leg_coordinates)
    message.multipliers = _doubles(equilibrium.multipliers)
    message.loads = _own_loads(equilibrium)
    message.converged = equilibrium.converged
    message.residual = equilibrium.residual
    message.iterations = equilibrium.iterations
    message.index_locked = equilibrium.index_locked
    message.index_free = equilibrium.index_free
    message.smallest_eigenvalue_locked = math.nan
    message.smallest_eigenvalue_free = math.nan
    message.margin = math.nan
    if eigenvalues:
        message.smallest_eigenvalue_locked = equilibrium.spectrum_locked.smallest
        message.smallest_eigenvalue_free = equilibrium.spectrum_free.smallest
        message.margin = equilibrium.spectrum_locked.margin
    message.energy = equilibrium.energy
    message.solve_time = solve_time


def joint_state(
    equilibrium: Equilibrium, frames: Frames, stamp: Time, velocity: Floats | None = None
) -> JointState:
    """Motor positions and efforts; the velocity of an equilibrium alone is zero."""
    message = JointState()
    _fill_joint_state(message, equilibrium, frames, stamp, velocity)
    return message


def _fill_joint_state(
    message: JointState,
    equilibrium: Equilibrium,
    frames: Frames,
    stamp: Time,
    velocity: Floats | None = None,
) -> None:
    """Write motor positions and efforts; the velocity of an equilibrium alone is zero."""
    message.header.stamp, message.header.frame_id = stamp, frames.base
    message.name = list(equilibrium.robot.motor_names)
    message.position = _doubles(equilibrium.motors)
    message.velocity = _doubles(np.zeros(len(message.name)) if velocity is None else velocity)
    message.effort = _doubles(equilibrium.efforts)


def platform_pose(equilibrium: Equilibrium, frames: Frames, stamp: Time) -> PoseStamped:
    """Pose of the platform in the base frame."""
    message = PoseStamped()
    message.header.stamp, message.header.frame_id = stamp, frames.base
    _fill_pose(message.pose, equilibrium)
    return message


def _doubles(vector: Floats) -> array[float]:
    """Numbers in the form that message fields take without looking at every one."""
    return array("d", vector.tobytes())


def _own_loads(equilibrium: Equilibrium) -> list[LoadsMessage]:
    """The loads of an equilibrium, where they are not those of the description."""
    loads, default = equilibrium.loads, equilibrium.robot.default_loads
    if not loads.differences(default):
        return []
    message = LoadsMessage()
    fill_vector(message.gravity, loads.gravity)
    fill_wrench(message.wrench_in_base, loads.wrench_world)
    fill_wrench(message.wrench_in_platform, loads.wrench_body)
    return [message]


def _fill_pose(message: Pose, equilibrium: Equilibrium) -> None:
    fill_vector(message.position, equilibrium.platform_position)
    fill_quaternion(message.orientation, equilibrium.platform_quaternion)
