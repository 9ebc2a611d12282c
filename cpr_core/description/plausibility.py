# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ways and places of a description that look like another unit.

They are errors where no robot can be meant, else warnings; of rods see ``plausible_rods.py``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..description_part import Part
from ..errors import first_and_others
from .chain import ChainJoint, Link
from .chain_element import ChainElement
from .leg_description import DescribedMotor
from .other_units import (
    FAR,
    MILLIMETRES,
    ORDER,
    doubtful_lead,
    motor_doubt,
    reach_of,
    way_doubt,
)
from .robot_description import RobotDescription

__all__ = [
    "check_gravity",
    "check_home_joints",
    "check_home_motors",
    "check_inertia",
    "check_link",
    "check_places",
    "check_quaternion",
    "check_tolerance",
    "check_ways",
]

Floats = NDArray[np.float64]

#: Longest vector that a link, or a tracker, may have [m].
_LONGEST = 100.0
#: Smallest range behind a gear that is believed, of a joint [rad] or a rod [rod lengths].
_SMALLEST_RANGE = 1e-3
#: Smallest speed behind a gear that is believed [rad/s, rod lengths/s]: honest screws make a thousandth.
_SLOWEST = 1e-4
#: Largest gravity that is believed [m/s^2]: a hundred times that of the earth.
_HEAVIEST = 1e3
#: How far apart the tips on a point may be [rod lengths]: parameters may be a little off.
_APART = 0.05
#: Modes are chosen for a smaller error of the platform than this [rod lengths].
_COARSE = 0.01
#: A place this far away is an error [rod lengths]: rounding hides the robot.
_BEYOND = 1e9
#: Distance from the origin of the world from which on rounding is seen [rod lengths].
_FROM_THE_WORLD = 1e5


def check_ways(part: Part, element: ChainElement, length: float) -> None:
    """Whether positions of a joint, or lengths of a rod, are in radians and metres, and those of motors.

    Args:
        part: The joint, motor or rod in the description.
        element: The same.
        length: Of the rods of its leg [m].
    """
    if doubtful_lead(element.motor_unit, element.unit, element.ratio, length):
        part.warn("lead", f"{part.number('lead', 0.0):g}: {MILLIMETRES}?")
        return  # what follows from it is no mistake of its own
    for position in (element.limits.lower, element.limits.upper):
        way = element.ratio * position
        if math.isfinite(way) and (
            doubt := way_doubt(element.motor_unit, element.unit, way, length)
        ):
            if "ratio" in part and not way_doubt(
                element.motor_unit, element.unit, position, length
            ):
                part.warn("ratio", _turned_around(element, position))
            else:
                part.warn("limits.position", f"{position:g}: {doubt}")
            return
    for name, way in (("offset", element.zero), ("rest", element.rest)):
        if doubt := way_doubt(element.unit, element.unit, way, length):
            part.warn(name, f"{way:g}: {doubt}")
            return
    if "lead" in part or "ratio" in part:
        _check_geared(part, element, length)


def _turned_around(element: ChainElement, position: float) -> str:
    """What looks wrong with a ratio by which a joint goes much farther than its motor."""
    way = element.ratio * position
    return (
        f"{position:g} {element.motor_unit} of the motor are {way:g} {element.unit} "
        f"behind it: expected the way of the joint per way of the motor, {1.0 / element.ratio:g}?"
    )


def _check_geared(part: Part, element: ChainElement, length: float) -> None:
    """Whether limits are those of the motor before its gear or screw, and not of the joint behind it."""
    limits, gear = element.limits, "lead" if "lead" in part else "ratio"
    unit = 1.0 if element.unit == "rad" else length
    wide = limits.upper - limits.lower
    for name, size, own, behind in (
        ("position", wide, f"a range of {wide:g} {element.motor_unit}", element.unit),
        ("speed", limits.speed, f"{limits.speed:g} {element.motor_unit}/s", f"{element.unit}/s"),
    ):
        way = abs(element.ratio) * size
        if way < (_SMALLEST_RANGE if name == "position" else _SLOWEST) * unit:
            part.warn(
                f"limits.{name}",
                f"{own} is {way:.2g} {behind} behind the {gear}: limits are of the motor, before it",
            )
            return


def check_link(part: Part, link: Link, length: float) -> None:
    """Whether a link of a leg with rods of a length [m] leads somewhere in metres.

    Raises:
        DescriptionError: It does not.
    """
    vectors = {"link": link.offset, "center_of_mass": link.center_of_mass}
    for name, vector in vectors.items():
        if math.hypot(*vector) > _LONGEST:
            raise part.fail(name, f"got {list(vector)}: {MILLIMETRES}")
    for name, vector in vectors.items():
        size = math.hypot(*vector)
        if size > FAR * length:
            part.warn(name, f"{size:g} m, more than {FAR:g} rod lengths: {MILLIMETRES}?")
            return


def check_gravity(part: Part, description: RobotDescription) -> None:
    """Whether gravity is in m/s^2."""
    size = math.hypot(*description.gravity)
    if size > _HEAVIEST:
        part.warn("gravity", f"{size:g}: looks like mm/s^2, expected m/s^2")


def check_inertia(part: Part, description: RobotDescription) -> None:
    """Whether the inertia of the platform is that of a body as large as the robot at most."""
    moment = float(np.abs(description.platform_inertia).max())
    farthest = FAR * reach_of(description)[0]
    if moment > description.platform_mass * farthest**2:
        mass = f"{description.platform_mass:g} kg"
        part.warn("platform.inertia", f"{moment:g} with {mass}: looks like kg mm^2, not kg m^2")


def check_home_motors(
    part: Part, motors: Sequence[DescribedMotor], positions: Sequence[float], length: float
) -> None:
    """Whether motor positions at home are in radians and metres."""
    for index, (motor, position) in enumerate(zip(motors, positions, strict=True)):
        doubt = motor_doubt(motor, position, length)
        if doubt:
            part.warn(f"motors[{index}]", f"{position:g}: {doubt}")
            return


def check_home_joints(
    part: Part, joints: Iterable[ChainJoint], positions: Mapping[str, float], length: float
) -> None:
    """Whether rough positions of passive joints at home are in radians and metres."""
    for joint in joints:
        position = positions.get(joint.name, 0.0)
        doubt = way_doubt(joint.unit, joint.unit, position, length)
        if doubt:
            part.warn(f"joints.{joint.name}", f"{position:g}: {doubt}")
            return


def check_quaternion(part: Part, name: str, quaternion: Sequence[float]) -> None:
    """Whether the real part of a quaternion is where it is expected."""
    first, *_, last = quaternion
    if abs(first) < 0.2 and abs(last) > 0.9:
        turn = math.degrees(2.0 * math.acos(min(1.0, abs(first))))
        part.warn(name, f"{list(quaternion)} is a turn by {turn:.0f} degrees: {ORDER}?")


def check_places(part: Part, description: RobotDescription) -> None:
    """Whether bases, tips, platform and tracker are where the rods can reach, or near them.

    Raises:
        DescriptionError: One is so far away that rounding hides the robot.
    """
    distances = list(_distances(description))
    for name, distance in distances:
        if distance > _BEYOND:
            raise part.fail(name, f"more than {_BEYOND:g} rod lengths away: {MILLIMETRES}")
    found = [name for name, distance in distances if distance > FAR]
    if found:
        part.warn(first_and_others(found), f"more than {FAR:g} rod lengths away: {MILLIMETRES}")
    longest, middle = reach_of(description)
    if math.hypot(*middle) > _FROM_THE_WORLD * longest:
        part.warn(
            "legs[*].base.position",
            f"more than {_FROM_THE_WORLD:g} rod lengths from the origin of the world, where rounding "
            "is seen: expected an origin near the robot",
        )
    tracker = description.tracker
    if tracker is not None and math.hypot(*tracker.position) > _LONGEST:
        part.warn("tracker.position", f"more than {_LONGEST:g} m away: {MILLIMETRES}")
    _check_point(part, description)


def check_tolerance(part: Part, description: RobotDescription) -> None:
    """Whether the error that modes are chosen for is small beside the rods."""
    longest = description.longest_rod
    if _COARSE * longest <= description.tolerance < math.inf:
        coarse = f"{description.tolerance:g} m of rods of {longest:g} m: {MILLIMETRES}?"
        part.warn("strain.tolerance", coarse)


def _check_point(part: Part, description: RobotDescription) -> None:
    """Whether the tips on a point are at one place: apart they hold a body that nothing turns."""
    first, *others = (leg.joint.position for leg in description.legs)
    apart = max((math.dist(first, other) for other in others), default=0.0)
    if description.point_platform and apart > _APART * reach_of(description)[0]:
        part.warn(
            "platform.shape",
            f"a point never turns, and tips on it are {apart:g} m apart: expected body?",
        )


def _distances(description: RobotDescription) -> Iterator[tuple[str, float]]:
    """Fields with a position, and how far away it is in rod lengths."""
    legs, longest, middle = description.legs, *reach_of(description)
    for index, leg in enumerate(legs):
        yield f"legs[{index}].base.position", math.dist(leg.base_position, middle) / longest
        yield f"legs[{index}].tip.position", math.hypot(*leg.joint.position) / longest
    yield "platform.center_of_mass", math.hypot(*description.center_of_mass) / longest
    if description.tracker is not None:
        marker = description.tracker.marker_position
        yield "tracker.marker.position", math.hypot(*marker) / longest
    if description.home.platform_position is not None:
        position = description.home.platform_position
        yield "home.platform.position", math.dist(position, middle) / longest
