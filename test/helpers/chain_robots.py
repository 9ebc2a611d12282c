# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots whose legs are chains."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np

from cpr_core import Robot, load_robot
from cpr_core.description import joints
from cpr_core.description.chain import ChainRod, Link, Shift, Turn
from cpr_core.description.chain_element import ChainElement
from cpr_core.description.motors import Drive
from cpr_core.lie import rotation_exp
from cpr_core.rods.rod import StrainModes
from helpers.yaml_content import shipped_content

_NOWHERE = {"link": [0.0, 0.0, 0.0]}


def as_chains(robot: str | dict[str, Any], links: bool) -> dict[str, Any]:
    """A robot with its motors spelt as chains, and links of length zero about its rods."""
    described = load_robot(robot).description
    content = shipped_content(robot) if isinstance(robot, str) else deepcopy(robot)
    for leg, fields in zip(described.legs, content["legs"], strict=True):
        chain: list[dict[str, Any]] = []
        for element in leg.chain:
            moved = {} if element.motor is None else {"motor": element.motor}
            if isinstance(element, ChainRod):
                rod = {"rod": fields.pop("rod", {}), "strain": fields.pop("strain", {})} | moved
                chain += [_NOWHERE, rod, _NOWHERE] if links else [rod]
            else:
                joint = "revolute" if isinstance(element, Turn) else "prismatic"
                moved |= {"offset": element.zero} if element.zero else {}
                chain.append({"joint": joint, "axis": list(element.axis)} | moved)
        del fields["motor"]
        fields["chain"] = chain
        fields["base"]["tangent"] = leg.base_rotation[:, 0].tolist()
        if not described.planar:
            fields["base"]["normal"] = leg.base_rotation[:, 1].tolist()
    return content


_Y, _Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_TILTED = tuple(np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5]))
_ACROSS = tuple(np.array([-0.4, 0.3, 1.0]) / np.linalg.norm([-0.4, 0.3, 1.0]))
_BENT = rotation_exp([0.3, -0.2, 0.5])


_SHIPPED = load_robot("six_rfs").description.legs[0].rod


def _rod(length=0.6, counts=(1, 2, 3), stiffer=1.0, motor=None):
    modulus = stiffer * _SHIPPED.young_modulus, stiffer * _SHIPPED.shear_modulus
    described = replace(_SHIPPED, length=length, young_modulus=modulus[0], shear_modulus=modulus[1])
    return ChainRod(described, StrainModes(counts), Drive(motor))


_MOTOR = Turn(_TILTED, Drive("motor"))
#: Every element behind a motor and before a rod; then several of them, and more rods.
CHAINS = {
    "motor": [_MOTOR, _rod()],
    "nothing but a rod": [_rod()],
    "zero and ratio": [Turn(_TILTED, Drive("motor", -2.5, 0.4)), _rod()],
    "sprung motor": [_MOTOR, Turn(_TILTED, stiffness=3.0, rest=0.2), _rod()],
    "passive turn": [_MOTOR, Turn(_ACROSS), _rod()],
    "passive shift": [_MOTOR, Shift(_ACROSS, Drive(zero=0.1)), _rod()],
    "sprung shift": [_MOTOR, Shift(_ACROSS, stiffness=40.0, rest=-0.1), _rod()],
    "driven shift": [Shift(_TILTED, Drive("motor", zero=0.2)), _rod()],
    "hub": [_MOTOR, Link((0.03, 0.02, -0.01)), _rod()],
    "bent hub": [_MOTOR, Link((0.03, 0.02, -0.01), _BENT), _rod()],
    "heavy hub": [_MOTOR, Link((0.03, 0.02, -0.01), _BENT, 0.2, (0.01, 0.03, 0.02)), _rod()],
    "end piece": [_MOTOR, _rod(), Link((0.02, 0.0, 0.01), _BENT, 0.05, (0.01, 0.0, 0.0))],
    "universal": [_MOTOR, Link((0.1, 0.0, 0.0)), Turn(_Y), Turn(_Z), _rod()],
    "two rods": [_MOTOR, _rod(0.3, (1, 2, 2)), _rod(0.4, (0, 2, 3), 3.0)],
    "rigid middle": [
        _MOTOR,
        _rod(0.3),
        Link((0.1, 0.0, 0.0), _BENT, 0.1),
        _rod(0.4, (1, 1, 2), 2.0),
    ],
    "joint between rods": [_MOTOR, _rod(0.3), Turn(_ACROSS, stiffness=0.5), _rod(0.4)],
    "joint behind the rod": [_MOTOR, _rod(), Turn(_ACROSS), Link((0.05, 0.0, 0.0))],
    "motor at the far end": [_rod(), Turn(_ACROSS, Drive("motor")), Link((0.05, 0.0, 0.02))],
    "two motors": [_MOTOR, Turn(_ACROSS, Drive("second motor")), _rod()],
    "one motor twice": [_MOTOR, _rod(0.4), Turn(_ACROSS, Drive("motor", -0.5)), _rod(0.3)],
    "fed behind a joint": [Turn(_ACROSS), _rod(0.6, (1, 2, 2), 1.0, "motor")],
    "fed by a roller": [
        Turn(_ACROSS),
        replace(_rod(0.6, (1, 2, 2)), drive=Drive("motor", -0.5, 0.7, screw=True)),
    ],
    "fed and turned": [
        _MOTOR,
        Link((0.05, 0, 0)),
        _rod(0.6, (1, 2, 2), 1.0, "feed"),
        Link((0.03, 0, 0)),
    ],
    "fed behind a rod": [
        _rod(0.3),
        Turn(_ACROSS),
        _rod(0.5, (1, 2, 2), 1.0, "motor"),
        Turn(_TILTED),
    ],
    "crank and universal": [
        Turn((0.0, -1.0, 0.0), Drive("motor")),
        Link((0.1, 0.0, 0.0), np.eye(3), 0.02, (0.05, 0.0, 0.0)),
        Turn(_Y, stiffness=0.1, rest=0.2),
        Turn(_Z),
        _rod(0.4),
        Link((0.02, 0.0, 0.0), np.eye(3), 0.005),
    ],
    "no rod": [_MOTOR, Link((0.1, 0.0, 0.0)), Turn(_Y), Turn(_Z), Link((0.3, 0.0, 0.0))],
}
TIPS = {
    "spherical": joints.Spherical((0.1, -0.05, 0.02)),
    "fixed": joints.Fixed((0.1, -0.05, 0.02), tuple(map(tuple, _BENT))),
}
#: A leg of each kind.
ALL_DIFFERENT = ("two rods", "crank and universal", "one motor twice", "end piece", "motor", "hub")


def _named(element: Any, leg: Any, shared: bool) -> ChainElement:
    """An element whose motor is the leg's own, or that of all legs."""
    motor = getattr(element, "motor", None)
    if motor is None:
        return element
    name = motor if shared else f"{motor} of {leg.name}"
    return replace(element, drive=replace(element.drive, motor=name))


def robot_of(chains: Sequence[str], tip: str = "spherical", shared: bool = False) -> Robot:
    """The paper's robot with some of CHAINS for legs, and a heavy platform.

    Args:
        chains: One for every leg.
        tip: Out of TIPS.
        shared: Whether legs whose motors have one name have one motor.
    """
    description = load_robot("six_rfs").description
    legs = tuple(
        replace(
            leg,
            joint=TIPS[tip],
            elements=tuple(_named(element, leg, shared) for element in CHAINS[chain]),
        )
        for leg, chain in zip(description.legs, chains, strict=False)
    )
    middle = np.array([0.02, -0.03, 0.05])
    return Robot(replace(description, legs=legs, platform_mass=0.3, center_of_mass=middle))
