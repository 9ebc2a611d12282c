# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the content of a description file to values; checks what a schema cannot.

Motors, tip joints, sections and strain bases read their own parts; here is what all robots share.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description_part import EXACTLY_ACROSS, Part
from ..lie import directions_across
from ..rods.rod import Rod
from .controlled_coordinates import CONTROLLED_COORDINATES
from .described_chain import chain_leg, check_joints, check_motors
from .described_rods import (
    check_fed,
    described_modes,
    described_rod,
    described_tolerance,
)
from .home_guess import home_guess
from .joints import JOINTS, Joint
from .leg_description import LegDescription, described_motors
from .loads import DistributedForce, Loads, PointForce
from .motors import MOTORS, UNDRIVEN, Drive, Motor, Welded
from .plausibility import check_gravity, check_inertia, check_places, check_tolerance, check_ways
from .plausible_rods import check_slender
from .robot_description import RobotDescription
from .tracker import Tracker
from .twisting_rods import check_twist
from .written_fields import WrittenFields

__all__ = ["described_robot"]

Floats = NDArray[np.float64]

#: How columns of measurements begin that are about a motor; its name follows.
_COLUMNS_OF_MOTORS = ("motor:", "effort:")
#: Characters that would end a name in a message of ROS, or that XML, and so URDF, does not know.
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
#: Cosine beyond which an axis along the tangent no longer tells a direction across it.
_ALONG = 0.9
#: Relative error of an inertia that rounding in a file may make.
_ROUNDED = 1e-3


def described_robot(
    source: str,
    content: dict[str, Any],
    text: str | None,
    slack: float = EXACTLY_ACROSS,
    known: RobotDescription | None = None,
) -> RobotDescription:
    """The robot a description stands for.

    Args:
        source: Where it came from.
        content: Its fields, checked against the schema.
        text: The description as it was read; None: a change of one, empty: no file.
        slack: Cosine by which normals may miss being across their tangents, see ``Part``.
        known: A robot that shares fields with this one: legs whose fields are the same objects are not
            read again, as one number may be all that differs. They have its strain modes.

    Raises:
        DescriptionError: Names the field, what was found and what was expected.
    """
    kept, read = _kept_legs(content, known)
    part = Part(source, "", content, content["space"] == "planar", read, slack)
    platform = part.part("platform")
    point = platform.get("shape", "body") == "point"
    if point and not part.planar:
        raise platform.fail("shape", "a point platform needs a planar robot")
    tolerance, legs = described_tolerance(part), _legs(part, kept)
    description = RobotDescription(
        name=content["name"],
        source=source,
        planar=part.planar,
        point_platform=point,
        platform_mass=platform.number("mass", 0.0),
        center_of_mass=platform.vector("center_of_mass", (0.0, 0.0, 0.0)),
        legs=legs,
        controlled=tuple(content["controlled"]),
        home=home_guess(part, legs),
        loads=_loads(part, legs),
        stations=tuple(content.get("stations", ())),
        platform_inertia=_inertia(platform, point),
        tolerance=tolerance,
        tracker=Tracker.from_description(part.part("tracker")) if "tracker" in part else None,
        written=WrittenFields(content, part.read, text),
    )
    _check_controlled(part, description)
    check_places(part, description)
    check_gravity(part, description)
    check_slender(part, description)
    check_tolerance(part, description)
    check_inertia(part, description)
    check_twist(part, description)
    return description


def _inertia(platform: Part, point: bool) -> Floats:
    """Inertia of the platform about its centre of mass, (3, 3) [kg m^2]."""
    if "inertia" not in platform:
        return np.zeros((3, 3))
    given = platform.get("inertia")
    if point:
        raise platform.fail("inertia", "a point platform does not turn: leave it out")
    if not platform.number("mass", 0.0):
        raise platform.fail("inertia", "a platform without mass has none: expected mass too")
    xx, yy, zz, xy, xz, yz = map(float, given)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if platform.planar:
        if zz < 0.0:
            raise platform.fail("inertia", f"expected Izz of at least zero, got {zz:g}")
        return inertia
    # What masses add up to, int r r^T dm: no negative eigenvalue means no negative principal moment,
    # and none greater than the other two together.
    scaled = inertia / max(np.abs(inertia).max(), 1e-300)
    if np.linalg.eigvalsh(0.5 * np.trace(scaled) * np.eye(3) - scaled)[0] < -_ROUNDED:
        moments = ", ".join(f"{moment:g}" for moment in np.linalg.eigvalsh(inertia))
        raise platform.fail(
            "inertia",
            f"got principal moments {moments}: expected none negative, and none greater than the other "
            "two together",
        )
    return inertia


def _kept_legs(
    content: dict[str, Any], known: RobotDescription | None
) -> tuple[dict[int, LegDescription], dict[str, Any]]:
    """Legs by number that are those of a known robot, and what was read of it, their defaults too."""
    if known is None or known.written is None:
        return {}, {}
    theirs = known.written.content
    if any(content.get(name) is not theirs.get(name) for name in ("rod", "strain", "space")):
        return {}, {}
    pairs = enumerate(zip(known.legs, content["legs"], theirs["legs"], strict=True))
    kept = {number: leg for number, (leg, fields, read) in pairs if fields is read}
    return kept, dict(known.written.read) if kept else {}


def _legs(part: Part, kept: dict[int, LegDescription]) -> tuple[LegDescription, ...]:
    rods = (leg.rod for number, leg in kept.items() if "rod" not in part.content["legs"][number])
    shared = next(rods, None)
    if shared is None and "rod" in part:
        shared = described_rod(part.part("rod"))
    legs = tuple(
        kept.get(index)
        or (chain_leg if "chain" in leg else _leg)(
            part, leg, index, _leg_rod(part, leg, index, shared)
        )
        for index, leg in enumerate(part.parts("legs"))
    )
    check_motors(part, legs)
    _check_motor_names(part, legs)
    _check_characters(part, legs)
    _check_leg_names(part, legs)
    legs = tuple(
        leg if index in kept or "chain" in leg_part else _geared(leg, leg_part)
        for index, (leg, leg_part) in enumerate(zip(legs, part.parts("legs"), strict=True))
    )
    _check_rod_names(part, legs)
    check_joints(part, legs)
    check_fed(part, legs)
    if not any(leg.rods for leg in legs):
        raise part.fail("legs", "expected a rod in at least one leg")
    return legs


def _check_leg_names(part: Part, legs: tuple[LegDescription, ...]) -> None:
    """Whether every leg has a name of its own, and every motor that is not written in a chain.

    Raises:
        DescriptionError: It has not.
    """
    several = "; one that moves several legs is written in a chain of each"
    for kind, names, known in (
        ("name", [leg.name for leg in legs], "leg already"),
        ("motor.name", [leg.drive.motor for leg in legs], f"motor already{several}"),
    ):
        for index, name in enumerate(names):
            if name is not None and name in names[:index]:
                raise part.fail(
                    f"legs[{index}].{kind}", f"{name!r} is the name of an earlier {known}"
                )


def _check_rod_names(part: Part, legs: tuple[LegDescription, ...]) -> None:
    """Whether every rod has a name of its own: a leg may be called like a rod of another leg.

    Raises:
        DescriptionError: It has not.
    """
    owners: dict[str, LegDescription] = {}
    for index, leg in enumerate(legs):
        for name in leg.rod_names:
            if name in owners:
                problem = f"{name!r} is the name of a rod of {owners[name].name} already"
                raise part.fail(f"legs[{index}].name", problem)
            owners[name] = leg


def _check_characters(part: Part, legs: tuple[LegDescription, ...]) -> None:
    """Whether names of the robot, legs and joints hold nothing that messages or terminals act on.

    Raises:
        DescriptionError: One does.
    """
    names = [("name", str(part.content["name"]))]
    for index, leg in enumerate(legs):
        joints = [(f"legs[{index}]", joint.name) for joint in leg.joints]
        names += [(f"legs[{index}].name", leg.name), *joints]
    for place, name in names:
        if _CONTROL.search(name):
            raise part.fail(place, f"expected a name without control characters, got {name!r:.80}")


def _check_motor_names(part: Part, legs: tuple[LegDescription, ...]) -> None:
    """Whether motors are called so that messages, and columns of a file of measurements, can name them.

    Raises:
        DescriptionError: One is not.
    """
    names = [motor.name for motor in described_motors(legs)]
    for name in names:
        expected = ""
        if name.startswith("#"):  # its line would be a comment
            expected = "one that does not begin with #"
        elif name != name.strip() or len(name.splitlines()) > 1:
            expected = "one without spaces around it and without line breaks"
        elif _CONTROL.search(name):
            expected = "one without control characters"
        for column in _COLUMNS_OF_MOTORS:
            if name.startswith(column) and name.removeprefix(column) in names:
                other = name.removeprefix(column)
                expected = f"another one, which is a column of motor {other} in measurements"
        if expected:
            raise part.fail("legs", f"motor {name!r:.80}: expected a name, {expected}")


def _leg_rod(whole: Part, part: Part, index: int, shared: Rod | None) -> Rod:
    """The rod of a leg: its own or that of the robot."""
    if "rod" in part:
        return described_rod(part.part("rod"))
    if shared is not None:
        return shared
    for element in part.parts("chain"):  # of one whose rods all say what they are it is the first
        if element.part("rod").content:
            return described_rod(element.part("rod"))
    raise whole.fail("", f"missing field 'rod': legs[{index}] has none of its own")


def _leg(whole: Part, part: Part, index: int, rod: Rod) -> LegDescription:
    """One leg with a rod, and strain modes of its own or those of the robot."""
    motor_part, tip = part.part("motor"), part.part("tip")
    motor = MOTORS[motor_part.get("type")].from_description(motor_part)
    modes = described_modes((part if "strain" in part else whole).part("strain"))
    if motor.extensible and not rod.uniform:
        raise motor_part.fail(
            "type",
            "an extensible leg needs a uniform rod: no profile, no second radius, and a rest_curvature "
            "that is the same all along",
        )
    joint = JOINTS[tip.get("type")].from_description(tip)
    motor.check_tip(motor_part, len(joint.orientation(part.planar)) > 0)
    drive = UNDRIVEN
    if motor.actuated:
        drive = Drive.of_motor(motor_part.get("name", f"motor{index + 1}"), motor_part)
    base = part.part("base")
    return LegDescription(
        name=part.get("name", f"leg{index + 1}"),
        rod=rod,
        modes=modes,
        base_position=base.vector("position"),
        base_rotation=_base_rotation(base, motor, joint),
        motor=motor,
        joint=joint,
        drive=drive,
    )


def _geared(leg: LegDescription, part: Part) -> LegDescription:
    """The leg, as the chain it is where there is a gear or a screw behind its motor."""
    if leg.drive.ratio != 1.0 or leg.drive.screw:
        leg = replace(leg, motor=Welded(), drive=UNDRIVEN, elements=leg.chain)
    for element in leg.chain:
        if element.motor is not None:
            check_ways(part.part("motor"), element, leg.rod.length)
    return leg


def _base_rotation(part: Part, motor: Motor, joint: Joint) -> Floats:
    """Base frame in the world, joint at zero, (3, 3)."""
    tangent, across = part.direction("tangent"), motor.across()
    free = not part.planar and not len(joint.orientation(part.planar))
    # Where no joint asks for d2 it follows the motor's axis too, so that it does not jump where that is
    # not quite across.
    slack = _ALONG if free else part.slack
    if across is not None and abs(np.dot(across, tangent)) <= slack:
        return part.frame(np.array(across))
    if free:
        return part.frame(directions_across(tangent)[0])  # any one: no joint asks for it
    return part.frame()


def _loads(part: Part, legs: tuple[LegDescription, ...]) -> Loads:
    """Loads that always act."""
    loads = part.part("loads")
    names = [name for leg in legs for name in leg.rod_names]

    def leg(force: Part) -> str:
        name = force.get("leg")
        if name not in names:
            raise force.fail("leg", f"expected one of {', '.join(names)}, got {name!r}")
        return str(name)

    distributed = []
    for force in loads.parts("distributed"):
        at, given = force.stations("at"), force.get("force")
        if len(given) != len(at):
            raise force.fail("force", f"expected {len(at)} vectors, got {len(given)}")
        vectors = [force.in_plane(f"force[{row}]", vector) for row, vector in enumerate(given)]
        distributed.append(DistributedForce(leg(force), at, np.array(vectors)))
    nothing = (0.0, 0.0, 0.0)
    return Loads.none().with_(
        gravity=part.vector("gravity", nothing),
        rod_force=loads.vector("rod_force", nothing),
        wrench_world=[*nothing, *loads.vector("platform_force", nothing)],
        distributed=distributed,
        points=[
            PointForce(leg(force), force.number("at"), force.vector("force"))
            for force in loads.parts("points")
        ],
    )


def _check_controlled(part: Part, description: RobotDescription) -> None:
    """Whether the motors can control these coordinates."""
    controlled = description.controlled
    space = "planar" if part.planar else "spatial"
    allowed = [
        name
        for name, coordinate in CONTROLLED_COORDINATES.items()
        if space in coordinate.spaces and not (coordinate.turns and description.point_platform)
    ]
    for name in controlled:
        if name not in allowed:
            raise part.fail("controlled", f"expected some of {', '.join(allowed)}, got {name!r}")
    axes = [axis for name in controlled for axis in CONTROLLED_COORDINATES[name].axes]
    count = len(axes)
    if len(set(axes)) < count:
        raise part.fail("controlled", "expected either orientation or single angles, got both")
    motor_count, freedom = len(description.motor_names), description.platform_freedom
    if count != motor_count and motor_count <= freedom:
        raise part.fail(
            "controlled",
            f"expected {motor_count} coordinates, as many as motors, got {count} "
            f"({', '.join(controlled)}; orientation counts for three)",
        )
