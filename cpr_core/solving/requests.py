# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the numbers of a request to what it imposes on an equilibrium."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.controlled_coordinates import (
    CONTROLLED_COORDINATES,
    meant_by,
    no_inverse_problem,
    numbers_of,
)
from ..description.doubted_requests import angle_doubt
from ..errors import InvalidRequest
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..validation import checked_vector
from .targets import EffortTarget, MotorTarget, PoseTarget, Target, check_rod_lengths

__all__ = ["motor_vector", "pose_meaning", "split_pose", "target_of"]

Floats = NDArray[np.float64]


def target_of(start: Equilibrium, problem: str, values: ArrayLike) -> Target:
    """The target a request means.

    Args:
        start: Equilibrium to start from.
        problem: ``motors``, ``pose`` or ``efforts``.
        values: Numbers of the request.

    Raises:
        InvalidRequest: Wrong number of values, a rod length of zero or less, an angle of a pose beyond a
            whole turn, or a robot without inverse problem.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
    """
    robot = start.robot
    if problem == "motors":
        motors = motor_vector(robot, problem, values)
        check_rod_lengths(robot, motors)
        return MotorTarget(motors)
    if problem == "efforts":
        return EffortTarget(motor_vector(robot, problem, values))
    if not robot.description.controlled:
        raise InvalidRequest("pose", no_inverse_problem(robot.description.name))
    position, rotation = split_pose(start, values)
    return PoseTarget(rotation, position)


def pose_meaning(robot: Robot) -> tuple[str, ...]:
    """Names of the numbers that make up a pose of the inverse problem."""
    return numbers_of(robot.description.controlled)


def split_pose(start: Equilibrium, pose: ArrayLike) -> tuple[Floats, Floats]:
    """Position and rotation meant by controlled coordinates; the others as at the start."""
    names = pose_meaning(start.robot)
    try:
        values = checked_vector("pose", pose, len(names), " ".join(names))
    except InvalidRequest as error:
        if "qw" in names or not _is_whole(pose):
            raise
        raise InvalidRequest(
            "pose",
            f"{error.problem}; a quaternion is taken where the orientation is controlled, x y z qw qx "
            "qy qz where all is",
        ) from None
    doubt = angle_doubt(names, values) if _have_angles(names) else ""
    pitch = values[names.index("pitch")] if "pitch" in names else 0.0
    if abs(pitch) > 0.5 * math.pi:
        raise InvalidRequest(
            "pose",
            f"expected a pitch of at most pi/2 rad, got {pitch} rad"
            + (f"; {doubt}" if doubt else ""),
        )
    if doubt:  # whole turns less it would often be reached
        raise InvalidRequest("pose", doubt)
    place = start.platform_position, start.platform_rotation
    return meant_by(start.robot.description.controlled, values, *place)


@cache
def _have_angles(names: tuple[str, ...]) -> bool:
    """Whether there are angles among the numbers of a pose: looking at each takes a microsecond."""
    return any(
        name in CONTROLLED_COORDINATES and CONTROLLED_COORDINATES[name].is_angle for name in names
    )


def _is_whole(pose: ArrayLike) -> bool:
    """Whether there are as many numbers as in a position and a quaternion."""
    shape = (len(pose),) if isinstance(pose, list | tuple) else np.shape(pose)
    return shape == (7,)


def motor_vector(robot: Robot, name: str, values: ArrayLike) -> Floats:
    """Numbers of the motors in their order, (n,).

    Raises:
        InvalidRequest: Wrong number of them.
        NonFiniteInput: A NaN or an infinity.
    """
    return checked_vector(name, values, robot.motor_count, robot.motor_list)
