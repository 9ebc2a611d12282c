# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What looks wrong with the numbers of a request: words for its refusal, empty where nothing does."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from .chain import ChainRod, Link
from .controlled_coordinates import CONTROLLED_COORDINATES
from .leg_description import LegDescription
from .other_units import FAR, MILLIMETRES, ORDER, degrees_doubt, motor_doubt, reach_of
from .robot_description import RobotDescription

__all__ = [
    "angle_doubt",
    "motors_doubt",
    "position_doubt",
    "quaternion_order_doubt",
    "request_doubt",
]

Floats = NDArray[np.float64]


def request_doubt(
    description: RobotDescription, motors: Floats | None, position: Floats | None
) -> str:
    """What looks wrong with requested motors (n,) or a platform position (3,) [m]; empty: nothing."""
    longest, middle = reach_of(description)
    given = () if motors is None else motors
    for value, motor in zip(given, description.motors, strict=motors is not None):
        doubt = motor_doubt(motor, float(value), longest)
        if doubt:
            return f"{motor.name} at {value:g} {doubt}"
    if position is not None and math.dist(position, middle) > FAR * longest:
        place = ", ".join(f"{value:g}" for value in position)
        return f"the platform position ({place}) {MILLIMETRES}"
    return ""


def motors_doubt(description: RobotDescription, motors: Floats, near: Sequence[Floats]) -> str:
    """What looks wrong with motors (n,) that a robot is to go to; empty: nothing.

    More is let pass than of a request that failed: what limits of a motor have room for is meant, and
    so is what is not far from a place that is believed, however many turns led there.

    Args:
        description: The robot.
        motors: (n,) [rad or m].
        near: Motors where the robot is, or is sent, (n,) each.
    """
    longest = description.longest_rod
    for number, motor in enumerate(description.motors):
        position, limits = float(motors[number]), motor.limits
        doubt = motor_doubt(motor, position, longest)
        if not doubt or -math.inf < limits.lower <= position <= limits.upper < math.inf:
            continue
        if all(motor_doubt(motor, position - float(place[number]), longest) for place in near):
            return f"{motor.name} at {position:g} {doubt}"
    return ""


def position_doubt(description: RobotDescription, position: Floats, near: Sequence[Floats]) -> str:
    """What looks wrong with a position (3,) [m] that a platform is to go to; empty: nothing.

    As with motors, what is not far from a place that is believed is meant; nor is anything far that the
    legs could reach, stretched.

    Args:
        description: The robot.
        position: (3,) [m].
        near: Positions where the platform is, or is sent, (3,) each.
    """
    far = FAR * description.longest_rod
    if any(math.dist(position, place) <= far for place in near):
        return ""  # at once, as of nearly all there are
    middle = reach_of(description)[1]
    far = FAR * max(_stretched(leg, middle) for leg in description.legs)
    if any(math.dist(position, place) <= far for place in (middle, *near)):
        return ""
    return request_doubt(description, None, position)


def _stretched(leg: LegDescription, middle: Floats) -> float:
    """How far from the middle of the bases a leg holds the platform at most [m].

    What shifts counts as far as limits of its motor are stated.
    """
    reach = math.dist(leg.base_position, middle) + math.hypot(*leg.joint.position)
    for element in leg.chain:
        sizes = [0.0]
        if isinstance(element, Link):
            sizes.append(math.hypot(*element.offset))
        if isinstance(element, ChainRod):
            sizes.append(element.rod.length)
        if element.unit == "m":
            limits = element.limits
            ends = (element.zero + element.ratio * end for end in (limits.lower, limits.upper))
            sizes += [abs(end) for end in ends if math.isfinite(end)]
        reach += max(sizes)
    return reach


def angle_doubt(names: Iterable[str], pose: Iterable[float]) -> str:
    """What looks wrong with the angles of a requested pose; empty: nothing.

    Args:
        names: Of its numbers, as ``controlled`` has them.
        pose: The numbers [m, rad].
    """
    for name, value in zip(names, pose, strict=True):
        coordinate = CONTROLLED_COORDINATES.get(name)  # none: a number of a quaternion
        if coordinate is not None and coordinate.is_angle and (doubt := degrees_doubt(name, value)):
            return doubt
    return ""


def quaternion_order_doubt(quaternion: Floats, before: Floats) -> str:
    """What looks wrong with a requested orientation w x y z, seen from the one before; empty: nothing.

    Read as x y z w it would be near by, and as it is meant to be read it is far away.
    """
    w, x, y, z = quaternion
    if abs(quaternion @ before) < 0.7 and abs(np.array([z, w, x, y]) @ before) > 0.94:
        return f"the quaternion {ORDER}"
    return ""
