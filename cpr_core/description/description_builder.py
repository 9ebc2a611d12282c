# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the content of a description file to values; checks what a schema cannot.

Motors, tip joints, sections and strain bases read their own parts; here is what all robots share.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description_part import Part
from ..rods.rod import DIRECTIONS, UNIFORM, Profile, Rod, StrainModes, strain_series
from ..rods.sections import SECTIONS
from ..rods.strain_basis import STRAIN_BASES
from .description_schema import DEFAULT_BASIS
from .home_guess import home_guess
from .joints import JOINTS, Joint
from .loads import DistributedForce, Loads, PointForce
from .motors import MOTORS, Motor, MotorLimits
from .plausibility import check_limits, check_positions, check_rod
from .robot_description import CONTROLLED_COORDINATES, LegDescription, RobotDescription

__all__ = ["described_robot"]

Floats = NDArray[np.float64]

_DEFAULT_MODES = 5


def described_robot(source: str, content: dict[str, Any], text: str) -> RobotDescription:
    """The robot a description stands for.

    Args:
        source: Where it came from.
        content: Its fields, checked against the schema.
        text: The description as it was read.

    Raises:
        DescriptionError: Names the field, what was found and what was expected.
    """
    part = Part(source, "", content, content["space"] == "planar")
    platform = part.part("platform")
    point = platform.get("shape", "body") == "point"
    if point and not part.planar:
        raise platform.fail("shape", "a point platform needs a planar robot")
    legs = _legs(part)
    description = RobotDescription(
        name=content["name"],
        source=source,
        planar=part.planar,
        point_platform=point,
        platform_mass=platform.number("mass", 0.0),
        center_of_mass=platform.vector("center_of_mass", (0.0, 0.0, 0.0)),
        legs=legs,
        controlled=tuple(content["controlled"]),
        home=home_guess(part, legs, point),
        loads=_loads(part, legs),
        stations=tuple(content.get("stations", ())),
        text=text,
    )
    _check_controlled(part, description)
    check_positions(part, description)
    return description


def _legs(part: Part) -> tuple[LegDescription, ...]:
    shared = _rod(part.part("rod"))
    legs = tuple(_leg(part, leg, index, shared) for index, leg in enumerate(part.parts("legs")))
    for kind, names in (
        ("name", [leg.name for leg in legs]),
        ("motor.name", [leg.motor_name for leg in legs if leg.motor_name]),
    ):
        for index, name in enumerate(names):
            if name in names[:index]:
                raise part.fail(
                    f"legs[{index}].{kind}", f"{name!r} is the name of an earlier leg already"
                )
    return legs


def _leg(whole: Part, part: Part, index: int, shared: Rod) -> LegDescription:
    """One leg, with a rod and strain modes of its own or those of the robot."""
    motor_part, tip = part.part("motor"), part.part("tip")
    motor = MOTORS[motor_part.get("type")].from_description(motor_part)
    rod = _rod(part.part("rod")) if "rod" in part else shared
    if motor.extensible and not rod.uniform:
        raise motor_part.fail(
            "type", "an extensible leg needs a uniform rod (profile, rest_curvature)"
        )
    joint = JOINTS[tip.get("type")].from_description(tip)
    motor.check_tip(motor_part, len(joint.orientation(part.planar)) > 0)
    limits = MotorLimits.from_description(motor_part.part("limits"), motor.extensible)
    check_limits(motor_part.part("limits"), motor, limits, rod.length)
    base = part.part("base")
    return LegDescription(
        name=part.get("name", f"leg{index + 1}"),
        motor_name=motor_part.get("name", f"motor{index + 1}") if motor.actuated else None,
        rod=rod,
        modes=_modes((part if "strain" in part else whole).part("strain")),
        base_position=base.vector("position"),
        base_rotation=_base_rotation(base, motor, joint),
        motor=motor,
        joint=joint,
        limits=limits,
    )


def _base_rotation(part: Part, motor: Motor, joint: Joint) -> Floats:
    """Base frame in the world, motor at zero, (3, 3)."""
    tangent, across = part.direction("tangent"), motor.across()
    if across is not None and abs(np.dot(across, tangent)) <= 1e-6:
        return part.frame(np.array(across))
    if not part.planar and not len(joint.orientation(part.planar)):
        return part.frame(np.linalg.svd(tangent[None, :])[2][1])  # any one: no joint asks for it
    return part.frame()


def _rod(part: Part) -> Rod:
    """A rod, of all legs or of one."""
    section_part = part.part("section")
    section = SECTIONS[section_part.get("shape")].from_description(section_part)
    modulus = None if section.needs_moduli else 0.0
    rest = part.get("rest_curvature", {})
    if part.planar and (rest.get("torsion") or rest.get("bending_2")):
        raise part.fail("rest_curvature", "a planar rod is curved about d3 only")
    rod = Rod(
        length=part.number("length"),
        section=section,
        young_modulus=part.number("young_modulus", modulus),
        shear_modulus=part.number("shear_modulus", modulus),
        density=part.number("density", 0.0),
        profile=_profile(part.part("profile")) if "profile" in part else UNIFORM,
        rest_curvature=strain_series(rest),
        yield_strain=part.number("yield_strain", np.inf),
    )
    if "yield_strain" in part and section.bending_strain(np.ones(1), np.ones(1))[0] == 0.0:
        raise section_part.fail("", "missing field 'outer_radius': it has a yield_strain")
    check_rod(part, rod)
    return rod


def _profile(part: Part) -> Profile:
    """How a rod varies along its length."""
    at = part.stations("at")
    factors = []
    for name in ("stiffness", "mass"):
        given = part.get(name, [1.0] * len(at))
        if len(given) != len(at):
            raise part.fail(name, f"expected {len(at)} numbers, one per station, got {len(given)}")
        factors.append(np.array(given, float))
    return Profile(at, *factors)


def _modes(part: Part) -> StrainModes:
    """The strain modes."""
    basis = STRAIN_BASES[part.get("basis", DEFAULT_BASIS)].from_description(part)
    most = _DEFAULT_MODES if basis.modes is None else basis.modes
    default = dict.fromkeys(DIRECTIONS, most) | {"torsion": 0}
    if part.planar:
        default["bending_2"] = 0
    # 5.0 is a whole number in JSON
    torsion, bending_2, bending_3 = (int(part.get(name, default[name])) for name in DIRECTIONS)
    counts = (torsion, bending_2, bending_3)
    if part.planar and (torsion or bending_2):
        raise part.fail("", "a planar robot bends about d3 only: expected bending_3")
    if not any(counts):
        raise part.fail("", "expected at least one mode")
    if basis.modes is not None and any(count not in (0, most) for count in counts):
        problem = f"expected {most} or 0 modes with this degree and these knots, got {counts}"
        raise part.fail("", problem)
    return StrainModes(counts, basis)


def _loads(part: Part, legs: tuple[LegDescription, ...]) -> Loads:
    """Loads that always act."""
    loads = part.part("loads")
    names = [leg.name for leg in legs]

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
    """Whether the inverse problem is a square one."""
    controlled = description.controlled
    allowed = ["x", "y"]
    if not part.planar:
        allowed += ["z", "orientation", "roll", "pitch", "yaw"]
    elif not description.point_platform:
        allowed.append("angle")
    for name in controlled:
        if name not in allowed:
            raise part.fail("controlled", f"expected some of {', '.join(allowed)}, got {name!r}")
    if "orientation" in controlled and {"roll", "pitch", "yaw"} & set(controlled):
        raise part.fail("controlled", "expected either orientation or single angles, got both")
    count = sum(CONTROLLED_COORDINATES[name] for name in controlled)
    motor_count, freedom = len(description.motor_names), description.platform_freedom
    if motor_count > freedom:
        if controlled:
            raise part.fail(
                "controlled",
                f"expected none: {motor_count} motors for {freedom} platform coordinates, the "
                "inverse problem has no single solution",
            )
    elif count != motor_count:
        raise part.fail(
            "controlled",
            f"expected {motor_count} coordinates, as many as motors, got {count} "
            f"({', '.join(controlled)}; orientation counts for three)",
        )
