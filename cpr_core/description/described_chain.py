# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Legs that are chains, from their parts of a description."""

from __future__ import annotations

from dataclasses import replace

from ..description_part import Part
from ..rods.rod import Rod
from .chain import ChainRod, Link
from .chain_element import ChainElement
from .chain_joints import CHAIN_JOINTS
from .described_rods import described_modes, described_rod
from .joints import JOINTS
from .leg_description import LegDescription
from .motors import NO_LIMITS, Drive, Welded
from .plausibility import check_link, check_ways

__all__ = ["chain_leg", "check_joints", "check_motors"]


def chain_leg(whole: Part, part: Part, index: int, leg_rod: Rod) -> LegDescription:
    """A leg with a chain.

    Args:
        whole: The whole description.
        part: The leg in it.
        index: Number of the leg.
        leg_rod: The rod of the leg, or of the robot where it has none.

    Raises:
        DescriptionError: Something a schema cannot say is wrong.
    """
    rod, strain = (part if name in part else whole for name in ("rod", "strain"))
    leg_name = part.get("name", f"leg{index + 1}")
    elements: list[tuple[Part, ChainElement]] = []
    joints = 0
    for described in part.parts("chain"):
        if "joint" in described:
            joints += 1
            name = described.get("name", f"{leg_name}.joint{joints}")
            found = CHAIN_JOINTS[described.get("joint")].elements(described, name)
            elements += [(described, joint) for joint in found]
        elif "link" in described:
            elements.append((described, Link.from_description(described)))
        else:
            chain_rod = _chain_rod(described, leg_rod, rod.part("rod"), strain.part("strain"))
            elements.append((described, chain_rod))
    tip, base = part.part("tip"), part.part("base")
    leg = LegDescription(
        name=leg_name,
        rod=leg_rod,
        modes=described_modes(strain.part("strain")),
        base_position=base.vector("position"),
        base_rotation=base.frame(),
        motor=Welded(),
        joint=JOINTS[tip.get("type")].from_description(tip),
        elements=tuple(element for _, element in elements),
    )
    for described, element in elements:
        _check_units(described, element, leg.longest_rod)
    return leg


def _check_units(part: Part, element: ChainElement, length: float) -> None:
    """Whether numbers of an element of a leg with rods of a length [m] are in radians and metres."""
    if isinstance(element, Link):
        check_link(part, element, length)
    else:
        check_ways(part, element, length)


def _chain_rod(part: Part, leg_rod: Rod, rod: Part, strain: Part) -> ChainRod:
    """A rod of a chain; what it does not say is as in the leg's or the robot's rod."""
    own, modes = part.part("rod"), part.part("strain")
    described = described_rod(replace(own, content={**rod.content, **own.content}), own.content)
    if not own.content:  # the same one: what is found of a rod is found once
        described = leg_rod
    if "motor" in part and not described.uniform:
        raise part.fail(
            "motor",
            "a rod that is fed has to be uniform: no profile, no second radius, and a rest_curvature "
            "that is the same all along",
        )
    drive = Drive.from_description(part, "feeds this rod")
    strains = described_modes(replace(modes, content={**strain.content, **modes.content}))
    return ChainRod(described, strains, drive)


def check_joints(part: Part, legs: tuple[LegDescription, ...]) -> None:
    """Whether every joint has a name of its own.

    Raises:
        DescriptionError: It has not.
    """
    names: set[str] = set()
    for number, leg in enumerate(legs):
        for joint in leg.joints:
            if joint.name in names:
                problem = f"{joint.name!r} is the name of an earlier joint already"
                raise part.fail(f"legs[{number}].chain", problem)
            names.add(joint.name)


def check_motors(part: Part, legs: tuple[LegDescription, ...]) -> None:
    """Whether every motor turns, shifts or feeds, and nothing else, and has its limits once.

    Raises:
        DescriptionError: It does not.
    """
    known: dict[str, ChainElement] = {}
    for number, leg in enumerate(legs):
        for element in leg.elements or ():
            if element.motor is None:
                continue
            first = known.setdefault(element.motor, element)
            if first.kind != element.kind:
                problem = f"motor {element.motor!r} cannot turn, shift or feed at the same time"
                raise part.fail(f"legs[{number}].chain", problem)
            if first.motor_unit != element.motor_unit:
                problem = (
                    f"motor {element.motor!r} cannot turn at one joint, which has a lead, and shift at "
                    "another, which has none"
                )
                raise part.fail(f"legs[{number}].chain", problem)
            if NO_LIMITS not in (first.limits, element.limits) and first.limits != element.limits:
                problem = f"motor {element.motor!r} has other limits at an earlier joint"
                raise part.fail(f"legs[{number}].chain", problem)
            if first.limits == NO_LIMITS:  # the first that has some is what others are held to
                known[element.motor] = element
    for number, leg in enumerate(legs):
        if leg.drive.motor in known:
            problem = (
                f"{leg.drive.motor!r} is a motor of a chain: several joints share it there only"
            )
            raise part.fail(f"legs[{number}].motor.name", problem)
