# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Vectors, quaternions, twists and wrenches of messages, in the order of the core.

ROS puts forces before moments, and the scalar of a quaternion last.
"""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point, Quaternion, Twist, Vector3, Wrench
from numpy.typing import NDArray

from cpr_core.kernels.twist_layout import ANGULAR, LINEAR

__all__ = [
    "LINEAR_FIRST",
    "TWIST_FIELDS",
    "WRENCH_FIELDS",
    "fill_quaternion",
    "fill_vector",
    "fill_wrench",
    "quaternion_of",
    "twist_message",
    "twist_of",
    "vector_of",
    "wrench_of",
]

Floats = NDArray[np.float64]

#: Where each component of a message is in a twist or wrench of the core, which has angular ones first.
LINEAR_FIRST = np.r_[LINEAR, ANGULAR]
#: Fields of messages in the order of the core.
TWIST_FIELDS = ("angular.x", "angular.y", "angular.z", "linear.x", "linear.y", "linear.z")
WRENCH_FIELDS = ("torque.x", "torque.y", "torque.z", "force.x", "force.y", "force.z")


def vector_of(message: Point | Vector3) -> tuple[float, float, float]:
    """Components x, y, z."""
    return message.x, message.y, message.z


def quaternion_of(message: Quaternion) -> tuple[float, float, float, float]:
    """Components w, x, y, z."""
    return message.w, message.x, message.y, message.z


def twist_of(message: Twist) -> Floats:
    """A twist [omega; v], (6,)."""
    return np.array(vector_of(message.angular) + vector_of(message.linear))


def wrench_of(message: Wrench) -> Floats:
    """A wrench [m; f], (6,)."""
    return np.array(vector_of(message.torque) + vector_of(message.force))


def fill_vector(message: Point | Vector3, vector: Floats) -> None:
    """Write x, y, z, (3,)."""
    message.x, message.y, message.z = vector.tolist()


def fill_quaternion(message: Quaternion, quaternion: Floats) -> None:
    """Write w, x, y, z, (4,)."""
    message.w, message.x, message.y, message.z = quaternion.tolist()


def fill_wrench(message: Wrench, wrench: Floats) -> None:
    """Write a wrench [m; f], (6,)."""
    fill_vector(message.force, wrench[LINEAR])
    fill_vector(message.torque, wrench[ANGULAR])


def twist_message(twist: Floats) -> Twist:
    """A message of a twist [omega; v], (6,)."""
    message = Twist()
    fill_vector(message.linear, twist[LINEAR])
    fill_vector(message.angular, twist[ANGULAR])
    return message
