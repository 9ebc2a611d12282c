# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria as messages: whole ones, their motors, their platform."""

from __future__ import annotations

import math
from array import array

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import Loads as LoadsMessage
from geometry_msgs.msg import Pose, PoseStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState

from cpr_core import Equilibrium, InvalidRequest, Robot
from cpr_core.lie import rotation_from_quaternion
from cpr_core.solving.refining import restore_equilibrium

from .frames import Frames
from .geometry import fill_quaternion, fill_vector, fill_wrench, vector_of, wrench_of
from .motor_messages import motors_from_joint_state
from .pose_messages import pose_numbers

__all__ = [
    "equilibrium_from_message",
    "fill_equilibrium",
    "joint_state",
    "no_equilibrium",
    "platform_pose",
]

Floats = NDArray[np.float64]


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


def no_equilibrium() -> EquilibriumMessage:
    """What is said where none was found: of an index 0 would be stable, of a margin critical."""
    return EquilibriumMessage(
        index_locked=-1,
        index_free=-1,
        smallest_eigenvalue_locked=math.nan,
        smallest_eigenvalue_free=math.nan,
        margin=math.nan,
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


def platform_pose(equilibrium: Equilibrium, frames: Frames, stamp: Time) -> PoseStamped:
    """Pose of the platform in the base frame."""
    message = PoseStamped()
    message.header.stamp, message.header.frame_id = stamp, frames.base
    _fill_pose(message.pose, equilibrium)
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
