# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors by name: setpoints, requests and measurements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import JointState

from cpr_core import InvalidRequest, Robot
from cpr_core.validation import checked_vector

__all__ = [
    "check_names",
    "measured_motors",
    "measured_values",
    "motor_setpoint",
    "motors_from_joint_state",
]

Floats = NDArray[np.float64]


def motors_from_joint_state(
    robot: Robot, message: JointState, where: str = "motors"
) -> tuple[bool, Floats]:
    """Motor values in motor order.

    Args:
        robot: The robot.
        message: Motors by name.
        where: Name of the field in error messages.

    Returns:
        Whether they are efforts (no positions given), and the values, (n,).

    Raises:
        InvalidRequest: Names wrong, missing or twice, or not as many values as names.
        NonFiniteInput: A NaN or an infinity.
    """
    names, expected = list(message.name), list(robot.motor_names)
    check_names(names, expected, f"{where}.name", "expected every motor once")
    by_effort = not message.position
    field = "effort" if by_effort else "position"
    values = message.effort if by_effort else message.position
    if by_effort and not values:
        raise InvalidRequest(f"{where}.position", f"expected {len(names)} numbers, got none")
    vector = checked_vector(f"{where}.{field}", values, len(names), " ".join(names))
    return by_effort, vector[[names.index(name) for name in expected]]


def motor_setpoint(robot: Robot, message: JointState, others: Floats, where: str = "") -> Floats:
    """Motor positions of a setpoint that names some motors or all.

    Args:
        robot: The robot.
        message: Motors by name.
        others: Positions of the motors that are not named, (n,).
        where: What comes before the names of its fields in error messages.

    Raises:
        InvalidRequest: Names wrong or twice, or not as many positions as names.
        NonFiniteInput: A NaN or an infinity.
    """
    names, expected = list(message.name), list(robot.motor_names)
    check_names(names, expected, f"{where}name", "expected motors, each once", partial=True)
    values = checked_vector(f"{where}position", message.position, len(names), " ".join(names))
    motors = others.copy()
    motors[[expected.index(name) for name in names]] = values
    return motors


def measured_motors(robot: Robot, message: JointState) -> Floats:
    """Positions of the motors of the robot in the joint states of a machine that may have more.

    Raises:
        InvalidRequest: A motor missing or twice, or not as many positions as names.
        NonFiniteInput: A NaN or an infinity in a motor of the robot.
    """
    return measured_values(robot, message.name, "position", message.position)


def measured_values(
    robot: Robot, names: Sequence[str], field: str, values: Sequence[float]
) -> Floats:
    """Numbers of the motors of the robot, (n,), among those of a machine that may have more joints.

    Args:
        robot: The robot.
        names: Of the joints.
        field: What the numbers are, in error messages.
        values: One for each joint.

    Raises:
        InvalidRequest: A motor missing or twice, or not as many numbers as names.
        NonFiniteInput: A NaN or an infinity in a motor of the robot.
    """
    names = list(names)
    mine = [name for name in names if name in robot.motor_names]
    if names and not mine:
        expected, found = ", ".join(robot.motor_names), ", ".join(names)
        raise InvalidRequest("name", f"expected every motor once ({expected}), got {found:.200}")
    check_names(mine, list(robot.motor_names), "name", "expected every motor once")
    if len(values) != len(names):
        raise InvalidRequest(field, f"expected {len(names)} numbers, got {len(values)}")
    own = [values[names.index(name)] for name in robot.motor_names]
    return checked_vector(field, own, len(own), robot.motor_list)


def check_names(
    names: list[str], expected: list[str], field: str, needed: str, *, partial: bool = False
) -> None:
    """Whether names are names of motors, each once, and all of them unless ``partial``.

    Raises:
        InvalidRequest: They are not.
    """
    needed = f"{needed} ({', '.join(expected)})"
    if not names:
        raise InvalidRequest(field, f"{needed}, got no name")
    counts = Counter(names)
    unknown = [name for name in counts if name not in expected]
    missing = [name for name in expected if name not in counts and not partial]
    twice = [name for name, count in counts.items() if count > 1]
    for kind, which in (("unknown", unknown), ("twice", twice), ("missing", missing)):
        if which:
            raise InvalidRequest(field, f"{needed}; {kind}: {', '.join(which)}")
