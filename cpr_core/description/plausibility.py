# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of a description that look like another unit: errors where none can be meant, else warnings.

The bounds leave room for every robot that is known to be built: rods of hydrogel and of diamond, of
micrometres and of tens of metres.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..description_part import Part
from ..errors import DescriptionWarning
from ..rods.rod import Rod
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
    "check_home_joints",
    "check_home_motors",
    "check_inertia",
    "check_link",
    "check_moved",
    "check_positions",
    "check_quaternion",
    "check_rod",
]

Floats = NDArray[np.float64]

#: Longest rods [m]: beyond doubt, and beyond all robots.
_LONG, _LONGEST = 10.0, 100.0
#: Half the thickness of a rod, over its length: of none. Over that of the rods of a leg: of no slender
#: one; a fitting in a chain may be as thick as it is long.
_THICKEST, _THICK = 0.5, 0.09
#: Moduli [Pa]: of the softest solid there is, of soft ones, of none.
_SOFTEST, _SOFT, _STIFFEST = 1e4, 1e6, 2e12
#: Shear modulus over Young's, below and above what is doubted: metals have 0.4, glass and carbon along
#: their fibres down to 0.02, tubes of crosswise fibres 2; of metals the other way round it is above 2.5.
_SHEARS_EASILY, _SHEARS_HARDLY = 3e-3, 2.4
#: Densities [kg/m^3]: of the heaviest metal in g/cm^3, of what is soft.
_LIGHTEST, _HEAVY = 30.0, 2000.0
#: Strain that no material bears linearly: spring steel yields at 0.006, carbon fibre breaks at 0.015,
#: nitinol comes back from 0.08, rubbers go farther and stiffen. In per cent the first two are above it.
_YIELDED = 0.1
#: Turns that a rod bends by at rest which is a coil, and points at which its curvature is looked at.
_COILED, _LOOKED_AT = 2.0, 9
#: Range of a joint behind a gear [rad and rod lengths], and way in a second, that are nothing.
_NOTHING = 1e-3
#: No speed that a motor is limited to behind its gear, rod lengths or radians per second: honest screws
#: make a thousandth.
_SLOWEST = 1e-4
#: Distance of tips that are meant to be at one point, in rod lengths: parameters may be a little off.
_APART = 0.05
#: Error of a platform, in rod lengths, that nobody chooses modes for.
_COARSE = 0.01
#: Distance that no robot has, in rod lengths.
_BEYOND = 1e9
#: Distance from the origin of the world, in rod lengths, from which on rounding is seen.
_FROM_THE_WORLD = 1e5


def _warn(part: Part, name: str, problem: str) -> None:
    warnings.warn(
        f"{part.source}: {part.path_of(name)}: {problem}", DescriptionWarning, stacklevel=2
    )


def check_rod(part: Part, rod: Rod, own: Collection[str]) -> None:
    """Whether length, thickness and material can be those of a rod.

    Args:
        part: The rod in the description.
        rod: What it says.
        own: Names of the fields that stand there: what looks wrong is told where it stands, once.

    Raises:
        DescriptionError: They cannot.
    """
    if rod.length > _LONGEST:
        raise part.fail("length", f"got {rod.length:g}: {MILLIMETRES}")
    if rod.length > _LONG and "length" in own:
        _warn(part, "length", f"{rod.length:g} m: {MILLIMETRES}?")
    if rod.section.needs_moduli:
        _check_moduli(part, rod, own)
    _check_bent_at_rest(part, rod, own)
    section = part.part("section")
    if max(_half_extents(rod)) > _THICKEST * rod.length:
        sizes = ", ".join(f"{name} {value}" for name, value in section.content.items())
        raise section.fail("", f"got {sizes} for a rod {rod.length:g} m long: {MILLIMETRES}")
    if 0.0 < rod.density < _LIGHTEST and "density" in own:
        _warn(part, "density", f"{rod.density:g}: looks like g/cm^3, expected kg/m^3")
    if _YIELDED < rod.yield_strain < math.inf and "yield_strain" in own:
        _warn(
            part,
            "yield_strain",
            f"{rod.yield_strain:g}: looks like per cent or a stress, expected a ratio, 0.01 for 1 %",
        )
    if not _can_be_computed(rod):
        raise part.fail(
            "", "expected sizes and moduli of a rod: its stiffness is beyond all numbers"
        )


def _half_extents(rod: Rod) -> list[float]:
    """Half its thickness across both directions of bending [m]; NaN where it is not known."""
    bent = np.array([1.0, 0.0])
    return rod.section.bending_strain(bent, bent[::-1]).tolist()


def _check_moduli(part: Part, rod: Rod, own: Collection[str]) -> None:
    moduli = {"young_modulus": rod.young_modulus, "shear_modulus": rod.shear_modulus}
    for name, modulus in moduli.items():
        if modulus < _SOFTEST:
            raise part.fail(name, f"got {modulus:g}: looks like GPa, expected Pa")
        if modulus > _STIFFEST:
            raise part.fail(name, f"got {modulus:g}: no material is as stiff, expected Pa")
    light = 0.0 < rod.density < _HEAVY
    soft = [name for name, modulus in moduli.items() if modulus < _SOFT and not light]
    for name in soft:
        if name in own or "density" in own:
            _warn(part, name, f"{moduli[name]:g}: looks like MPa, expected Pa")
    shears = rod.shear_modulus / rod.young_modulus
    doubtful = not _SHEARS_EASILY < shears < _SHEARS_HARDLY
    if doubtful and not soft and not moduli.keys().isdisjoint(own):
        _warn(
            part,
            "shear_modulus" if "shear_modulus" in own else "young_modulus",
            f"the shear modulus {rod.shear_modulus:g} is {shears:.2g} of Young's, "
            f"{rod.young_modulus:g}, expected both in Pa: metals have 0.4 (or the other way round?)",
        )


def _check_bent_at_rest(part: Part, rod: Rod, own: Collection[str]) -> None:
    """Whether curvatures at rest are in 1/m: they coil no rod, though a strip may be twisted far."""
    bent = np.hypot(*rod.rest_curvature_at(np.linspace(0.0, 1.0, _LOOKED_AT)).T[1:])
    turns = float(bent.max()) * rod.length / (2.0 * math.pi)
    if turns > _COILED and ("rest_curvature" in own or "length" in own):
        _warn(
            part,
            "rest_curvature",
            f"{bent.max():g} 1/m coil a rod of {rod.length:g} m by {turns:.3g} turns: looks like "
            "degrees per metre, or a radius in millimetres, expected 1/m",
        )


def _can_be_computed(rod: Rod) -> bool:
    """Whether stiffness, its natural units and the weight are numbers a computer can work with."""
    try:
        scales = [
            rigidity * rod.length**power
            for rigidity in rod.rigidities
            for power in (-3, -2, -1, 0, 1)
        ]
        mass = rod.mass_per_length * rod.length
    except OverflowError:
        return False
    return all(1e-100 < scale < 1e100 for scale in scales) and mass < 1e100


def check_moved(part: Part, element: ChainElement, length: float) -> None:
    """Whether positions of a joint, or lengths of a rod, are in radians and metres, and those of motors.

    Args:
        part: The joint, motor or rod in the description.
        element: The same.
        length: Of the rods of its leg [m].
    """
    if doubtful_lead(element.motor_unit, element.unit, element.ratio, length):
        _warn(part, "lead", f"{part.number('lead', 0.0):g}: {MILLIMETRES}?")
        return  # what follows from it is no mistake of its own
    for position in (element.limits.lower, element.limits.upper):
        way = element.ratio * position
        if math.isfinite(way) and (
            doubt := way_doubt(element.motor_unit, element.unit, way, length)
        ):
            if "ratio" in part and not way_doubt(
                element.motor_unit, element.unit, position, length
            ):
                _warn(part, "ratio", _turned_around(element, position))
            else:
                _warn(part, "limits.position", f"{position:g}: {doubt}")
            return
    for name, way in (("offset", element.zero), ("rest", element.rest)):
        if doubt := way_doubt(element.unit, element.unit, way, length):
            _warn(part, name, f"{way:g}: {doubt}")
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
        if way < (_NOTHING if name == "position" else _SLOWEST) * unit:
            _warn(
                part,
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
            _warn(part, name, f"{size:g} m, more than {FAR:g} rod lengths: {MILLIMETRES}?")
            return


def check_inertia(part: Part, description: RobotDescription) -> None:
    """Whether the inertia of the platform is that of a body as large as the robot at most."""
    moment = float(np.abs(description.platform_inertia).max())
    farthest = FAR * reach_of(description)[0]
    if moment > description.platform_mass * farthest**2:
        mass = f"{description.platform_mass:g} kg"
        _warn(part, "platform.inertia", f"{moment:g} with {mass}: looks like kg mm^2, not kg m^2")


def check_home_motors(
    part: Part, motors: Sequence[DescribedMotor], positions: Sequence[float], length: float
) -> None:
    """Whether motor positions at home are in radians and metres."""
    for index, (motor, position) in enumerate(zip(motors, positions, strict=True)):
        doubt = motor_doubt(motor, position, length)
        if doubt:
            _warn(part, f"motors[{index}]", f"{position:g}: {doubt}")
            return


def check_home_joints(
    part: Part, joints: Iterable[ChainJoint], positions: Mapping[str, float], length: float
) -> None:
    """Whether rough positions of passive joints at home are in radians and metres."""
    for joint in joints:
        position = positions.get(joint.name, 0.0)
        doubt = way_doubt(joint.unit, joint.unit, position, length)
        if doubt:
            _warn(part, f"joints.{joint.name}", f"{position:g}: {doubt}")
            return


def check_quaternion(part: Part, name: str, quaternion: Sequence[float]) -> None:
    """Whether the real part of a quaternion is where it is expected."""
    first, *_, last = quaternion
    if abs(first) < 0.2 and abs(last) > 0.9:
        turn = math.degrees(2.0 * math.acos(min(1.0, abs(first))))
        _warn(part, name, f"{list(quaternion)} is a turn by {turn:.0f} degrees: {ORDER}?")


def check_positions(part: Part, description: RobotDescription) -> None:
    """Whether bases, tips and platform are where the rods can reach, and an error is a small distance.

    Raises:
        DescriptionError: One is so far away that rounding hides the robot.
    """
    distances = list(_distances(description))
    for name, distance in distances:
        if distance > _BEYOND:
            raise part.fail(name, f"more than {_BEYOND:g} rod lengths away: {MILLIMETRES}")
    found = [name for name, distance in distances if distance > FAR]
    if found:
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        _warn(part, found[0] + more, f"more than {FAR:g} rod lengths away: {MILLIMETRES}")
    longest, middle = reach_of(description)
    if math.hypot(*middle) > _FROM_THE_WORLD * longest:
        _warn(
            part,
            "legs[*].base.position",
            f"more than {_FROM_THE_WORLD:g} rod lengths from the origin of the world, where rounding "
            "is seen: expected an origin near the robot",
        )
    tracker = description.tracker
    if tracker is not None and math.hypot(*tracker.position) > _LONGEST:
        _warn(part, "tracker.position", f"more than {_LONGEST:g} m away: {MILLIMETRES}")
    _check_point(part, description)
    _check_slender(part, description)
    if _COARSE * longest <= description.tolerance < math.inf:
        coarse = f"{description.tolerance:g} m of rods of {longest:g} m: {MILLIMETRES}?"
        _warn(part, "strain.tolerance", coarse)


def _check_point(part: Part, description: RobotDescription) -> None:
    """Whether the tips on a point are at one place: apart they hold a body that nothing turns."""
    first, *others = (leg.joint.position for leg in description.legs)
    apart = max((math.dist(first, other) for other in others), default=0.0)
    if description.point_platform and apart > _APART * reach_of(description)[0]:
        _warn(
            part,
            "platform.shape",
            f"a point never turns, and tips on it are {apart:g} m apart: expected body?",
        )


def _check_slender(part: Part, description: RobotDescription) -> None:
    """Whether all rods are thin beside their legs, to one side at least: a strip may be wide."""
    longest = max(leg.rod_length for leg in description.legs)
    for index, leg in enumerate(description.legs):
        for half in (min(_half_extents(element.rod)) for element in leg.rods):
            if half >= _THICK * longest:
                thick = f"a rod {2.0 * half:g} m thick, where legs have {longest:g} m of rods"
                _warn(part, f"legs[{index}]", f"{thick}: {MILLIMETRES}?")
                return


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
