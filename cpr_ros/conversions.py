"""Between messages and values of the core. ROS puts forces first and the scalar of a quaternion last."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import (
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    Twist,
    Vector3,
    Wrench,
    WrenchStamped,
)
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cpr_core import Equilibrium, InvalidQuaternion, InvalidRequest, Loads, Robot
from cpr_core.geometrico_statics import pose_meaning, restore_equilibrium
from cpr_core.lie import roll_pitch_yaw, rotation_from_quaternion

from .error_codes import RequestError
from .motor_messages import motors_from_joint_state

__all__ = [
    "Frames",
    "equilibrium_from_message",
    "equilibrium_to_message",
    "joint_state",
    "platform_pose",
    "pose_from_message",
    "twist_message",
    "twist_vector",
    "with_wrench",
    "wrench_vector",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frames:
    """Names of the frames the node knows.

    Attributes:
        base: Frame fixed in space, in which the description is written.
        platform: Frame of the platform.
        rotation_to_base: Rotation from another frame to the base frame, (3, 3), or None if it is not
            known; None where nobody knows other frames.
    """

    base: str
    platform: str
    rotation_to_base: Callable[[str], Floats | None] | None = None


def pose_from_message(
    robot: Robot, message: PoseStamped, controlled: list[str], frames: Frames
) -> Floats:
    """Controlled coordinates in the order of the description.

    Raises:
        RequestError: The frame is not the base frame.
        InvalidRequest: Other coordinates named than the robot's.
        InvalidQuaternion: No rotation, or in the plane one that leaves it.
    """
    if message.header.frame_id not in ("", frames.base):
        raise RequestError(
            ErrorCode.FRAME_TRANSFORM_FAILURE,
            f"platform.header.frame_id: expected {frames.base!r}, got {message.header.frame_id!r}",
        )
    description = robot.description
    if controlled and sorted(controlled) != sorted(description.controlled):
        raise InvalidRequest(
            "controlled",
            f"expected {', '.join(description.controlled)}, got {', '.join(controlled)}",
        )
    position, orientation = message.pose.position, message.pose.orientation
    values = {"x": position.x, "y": position.y, "z": position.z}
    if {"orientation", "angle", "roll", "pitch", "yaw"} & set(description.controlled):
        quaternion = [orientation.w, orientation.x, orientation.y, orientation.z]
        rotation = rotation_from_quaternion(quaternion)
        if robot.planar and rotation[2, 2] < 1.0 - 1e-9:
            raise InvalidQuaternion("platform", "expected a rotation about z for a planar robot")
        values |= dict(zip(("qw", "qx", "qy", "qz"), quaternion, strict=True))
        values |= dict(
            zip(("roll", "pitch", "yaw"), roll_pitch_yaw(rotation).tolist(), strict=True)
        )
        values["angle"] = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    return np.array([values[name] for name in pose_meaning(robot)])


def with_wrench(loads: Loads, message: WrenchStamped, frames: Frames) -> Loads:
    """Loads with the platform wrench of a message: fixed in space or turning with the platform.

    The wrench acts at the platform origin, whatever its frame; another frame than the two gives only the
    directions of its axes.

    Raises:
        RequestError: The frame is neither the base frame nor the platform frame.
        NonFiniteInput: A NaN or an infinity.
    """
    frame = message.header.frame_id or frames.base
    wrench, nothing = wrench_vector(message.wrench), np.zeros(6)
    if frame == frames.platform:
        return loads.with_(wrench_world=nothing, wrench_body=wrench)
    if frame != frames.base:
        rotation = frames.rotation_to_base(frame) if frames.rotation_to_base else None
        if rotation is None:
            raise RequestError(
                ErrorCode.FRAME_TRANSFORM_FAILURE,
                f"wrench.header.frame_id: expected {frames.base!r} (fixed in space) or "
                f"{frames.platform!r} (turning with the platform), got {frame!r}",
            )
        wrench = np.concatenate([rotation @ wrench[:3], rotation @ wrench[3:]])
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
    gravity = message.gravity
    # Forces on the rods are the description's; a message does not carry them.
    loads = robot.default_loads.with_(
        gravity=[gravity.x, gravity.y, gravity.z],
        wrench_world=wrench_vector(message.wrench_in_base),
        wrench_body=wrench_vector(message.wrench_in_platform),
    )
    position, orientation = message.platform_in_base.position, message.platform_in_base.orientation
    return restore_equilibrium(
        robot,
        loads,
        motors,
        message.leg_coordinates,
        message.multipliers,
        rotation_from_quaternion([orientation.w, orientation.x, orientation.y, orientation.z]),
        [position.x, position.y, position.z],
    )


def equilibrium_to_message(
    equilibrium: Equilibrium,
    frames: Frames,
    stamp: Time,
    solve_time: float,
    *,
    eigenvalues: bool = True,
) -> EquilibriumMessage:
    """Everything about an equilibrium; without eigenvalues what needs them is NaN."""
    loads = equilibrium.loads
    locked = equilibrium.spectrum_locked if eigenvalues else None
    free = equilibrium.spectrum_free if eigenvalues else None
    return EquilibriumMessage(
        header=Header(stamp=stamp, frame_id=frames.base),
        motors=joint_state(equilibrium, frames, stamp),
        platform_in_base=_pose(equilibrium),
        leg_coordinates=equilibrium.leg_coordinates.tolist(),
        multipliers=equilibrium.multipliers.tolist(),
        gravity=_vector3(loads.gravity),
        wrench_in_base=_wrench(loads.wrench_world),
        wrench_in_platform=_wrench(loads.wrench_body),
        converged=equilibrium.converged,
        residual=equilibrium.residual,
        iterations=equilibrium.iterations,
        index_locked=equilibrium.index_locked,
        index_free=equilibrium.index_free,
        smallest_eigenvalue_locked=locked.smallest if locked else math.nan,
        smallest_eigenvalue_free=free.smallest if free else math.nan,
        margin=locked.margin if locked else math.nan,
        energy=equilibrium.energy,
        solve_time=solve_time,
    )


def joint_state(
    equilibrium: Equilibrium, frames: Frames, stamp: Time, velocity: Floats | None = None
) -> JointState:
    """Motor positions and efforts; the velocity of an equilibrium alone is zero."""
    return JointState(
        header=Header(stamp=stamp, frame_id=frames.base),
        name=list(equilibrium.robot.motor_names),
        position=equilibrium.motors.tolist(),
        velocity=[0.0] * equilibrium.robot.motor_count if velocity is None else velocity.tolist(),
        effort=equilibrium.efforts.tolist(),
    )


def platform_pose(equilibrium: Equilibrium, frames: Frames, stamp: Time) -> PoseStamped:
    """Pose of the platform in the base frame."""
    return PoseStamped(header=Header(stamp=stamp, frame_id=frames.base), pose=_pose(equilibrium))


def twist_message(twist: Floats) -> Twist:
    """A twist [omega; v], (6,), as a message."""
    return Twist(linear=_vector3(twist[3:]), angular=_vector3(twist[:3]))


def twist_vector(twist: Twist) -> Floats:
    """A message as a twist [omega; v], (6,)."""
    parts = (twist.angular, twist.linear)
    return np.array([value for part in parts for value in (part.x, part.y, part.z)])


def _pose(equilibrium: Equilibrium) -> Pose:
    x, y, z = equilibrium.platform_position.tolist()
    qw, qx, qy, qz = equilibrium.platform_quaternion.tolist()
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))


def _vector3(vector: Floats) -> Vector3:
    x, y, z = vector.tolist()
    return Vector3(x=x, y=y, z=z)


def _wrench(wrench: Floats) -> Wrench:
    return Wrench(force=_vector3(wrench[3:]), torque=_vector3(wrench[:3]))


def wrench_vector(wrench: Wrench) -> Floats:
    """A message as a wrench [m; f], (6,)."""
    parts = (wrench.torque, wrench.force)
    return np.array([value for part in parts for value in (part.x, part.y, part.z)])
