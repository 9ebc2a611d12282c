# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot as MuJoCo's XML: rods are rigid pieces between ball joints, sprung by its cable plugin.

A rod of length l with n joints has pieces of length l / n, the first and the last of them half outside:
every joint stands for the piece of rod around it, which makes the error even in the length of a piece.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from cpr_core.description.chain import Link
from cpr_core.description.joints import Fixed, RevoluteJoint, Spherical

from .placed_robot import Frame, NotPossible, PlacedLeg, PlacedRobot, PlacedRod

__all__ = ["xml_of"]

PLUGIN = "mujoco.elasticity.cable"
#: Joints of a clamp beside that which turns it.
SLIDES = (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1"))


def xml_of(robot: PlacedRobot, pieces: int) -> str:
    """The model with so many joints a rod; names: x0, y0, z0, turn0, ..., tip0, ..., platform.

    Clamps can move, though nobody lets them: what their joints then hold is the wrench on the leg. What
    lies between motor and clamp is left out.

    Raises:
        NotPossible: Rods are fed, which MuJoCo does not know, or not round.
    """
    description = robot.description
    instances, bodies = [], []
    for number, leg in enumerate(robot.legs):
        hinged = isinstance(leg.tip, RevoluteJoint) and description.planar
        if not hinged and not isinstance(leg.tip, Fixed | Spherical):
            raise NotPossible("tips that turn about axes")
        for place, rod in enumerate(leg.rods):
            instances.append(_instance(f"rod{number}_{place}", rod))
        bodies.append("".join(_leg(number, leg, pieces)))
    gravity = _text(description.gravity)
    mass = max(description.platform_mass, 1e-9)
    center = _text(description.center_of_mass)
    joint = (
        "".join(f"<joint type='slide' axis='{axis}'/>" for axis in ("1 0 0", "0 1 0", "0 0 1"))
        if description.point_platform
        else "<freejoint/>"
    )
    return (
        f"<mujoco><option gravity='{gravity}'/><compiler autolimits='false' angle='radian'/>"
        f"<extension><plugin plugin='{PLUGIN}'>{''.join(instances)}</plugin></extension>"
        f"<worldbody>{''.join(bodies)}"
        f"<body name='platform' {_place(robot.platform)}>{joint}"
        f"<inertial pos='{center}' mass='{mass!r}' diaginertia='1 1 1'/></body>"
        "</worldbody></mujoco>"
    )


def _instance(name: str, rod: PlacedRod) -> str:
    """Moduli that give the rod its rigidities at the radius of its pieces."""
    torsion, bending_2, bending_3 = rod.rigidities
    if not np.isclose(bending_2, bending_3):
        raise NotPossible("rods that are not round")
    radius = _radius(rod)
    twist, bend = torsion / (np.pi * radius**4 / 2.0), bending_3 / (np.pi * radius**4 / 4.0)
    return (
        f"<instance name='{name}'><config key='twist' value='{twist:.17g}'/>"
        f"<config key='bend' value='{bend:.17g}'/><config key='vmax' value='0'/></instance>"
    )


def _radius(rod: PlacedRod) -> float:
    """Any radius: pieces weigh what they are told."""
    return 1e-3 * rod.length


def _leg(number: int, leg: PlacedLeg, pieces: int) -> Iterator[str]:
    yield f"<body {_place(leg.clamp)}>" + "".join(
        f"<joint name='{name}{number}' type='slide' axis='{axis}'/>" for name, axis in SLIDES
    )
    yield f"<joint name='turn{number}' type='ball'/>{_inertial(None)}"
    closing, forward = 1, 0.0
    for place, rod in enumerate(leg.rods):
        size = rod.length / pieces
        link = rod.before if place else None
        if link is not None:
            yield f"<body pos='{forward!r} 0 0'>{_inertial(link)}"
            closing, forward = closing + 1, float(link.offset[0])
        for piece in range(pieces + 1):
            start = forward - 0.5 * size if piece == 0 else size
            joint = (
                "" if piece == 0 else f"<joint name='bend{number}_{place}_{piece}' type='ball'/>"
            )
            # Half of the end pieces is not there: the centre of mass is that of the rest.
            end = piece in (0, pieces)
            middle = {0: 0.75, pieces: 0.25}.get(piece, 0.5) * size
            mass = max(rod.mass * size * (0.5 if end else 1.0), 1e-12)
            yield (
                f"<body pos='{start!r} 0 0'>{joint}"
                f"<inertial pos='{middle!r} 0 0' mass='{mass!r}' diaginertia='1 1 1'/>"
                f"<geom type='capsule' fromto='0 0 0 {size!r} 0 0' size='{_radius(rod)!r}' "
                f"contype='0' conaffinity='0'/><plugin instance='rod{number}_{place}'/>"
            )
        closing, forward = closing + pieces + 1, 0.5 * size
    if leg.end is not None:
        yield f"<body pos='{forward!r} 0 0'>{_inertial(leg.end)}"
        closing, forward = closing + 1, float(leg.end.offset[0])
    yield f"<site name='tip{number}' pos='{forward!r} 0 0'/>" + "</body>" * closing


def _inertial(link: Link | None) -> str:
    """Mass of a rigid piece in the frame where it begins."""
    if link is None:
        return "<inertial pos='0 0 0' mass='1e-12' diaginertia='1 1 1'/>"
    center, mass = _text(link.center_of_mass), max(link.mass, 1e-12)
    return f"<inertial pos='{center}' mass='{mass!r}' diaginertia='1 1 1'/>"


def _place(frame: Frame) -> str:
    turn = Rotation.from_matrix(frame.rotation).as_quat()[[3, 0, 1, 2]]
    return f"pos='{_text(frame.position)}' quat='{_text(turn)}'"


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
