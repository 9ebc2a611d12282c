# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shapes of the legs, for drawings and checks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainJoint, ChainRod
from ..description.joints import JOINTS
from ..description.leg_description import LegDescription
from ..validation import ReadOnlyArrays, checked_count
from .equilibrium import Equilibrium, check_equilibrium
from .robot import Robot
from .rod_shapes import RodShape, rod_curvatures, rods_from_identity

__all__ = ["JointPlace", "LegShape", "Pose", "leg_shapes", "rod_bases", "state_shapes", "tip_poses"]

Floats = NDArray[np.float64]


class Pose(NamedTuple):
    """A frame in the world.

    Attributes:
        rotation: d1, d2, d3 as columns, (3, 3).
        position: (3,) [m].
    """

    rotation: Floats
    position: Floats


@dataclass(frozen=True, eq=False)
class JointPlace(ReadOnlyArrays):
    """A joint of a leg, in the world.

    Attributes:
        kind: ``revolute`` (a universal joint is two of them), ``prismatic``, or ``feed`` where a rod of
            varying length comes out; of the tip as descriptions call it, or the name of a class of one's
            own that they do not know.
        motor: Name of the motor that moves it; None: it is passive.
        position: (3,) [m].
    """

    kind: str
    motor: str | None
    position: Floats


#: Points of a rod: its ends at least, and no more than anybody draws.
_FEWEST_POINTS, _MOST_POINTS = 2, 1000


@dataclass(frozen=True, eq=False, repr=False)
class LegShape(ReadOnlyArrays):
    """One leg from base to tip: points along its rods, and where its links and shifts lead.

    Attributes:
        arc_length: Length of the way from the base, (P,) [m].
        position: Centre line in the world, (P, 3) [m].
        rotation: Cross-section frames in the world, (P, 3, 3); columns d1 (tangent), d2, d3.
        curvature: Strain (torsion, bending about d2, d3), (P, 3) [1/m]; zero on links.
        rod: Number of the rod in its leg, (P,); -1: a point of a rigid piece.
        joints: Its joints, from the base on; the last one is that of the tip.
    """

    arc_length: Floats
    position: Floats
    rotation: Floats
    curvature: Floats
    rod: NDArray[np.int64]
    joints: tuple[JointPlace, ...] = ()

    def __repr__(self) -> str:
        joints = " ".join(joint.kind for joint in self.joints) or "none"
        points, way = len(self.arc_length), self.arc_length[-1]
        return f"<LegShape: {points} points along {way:.4g} m, joints {joints}>"

    @property
    def rigid_pieces(self) -> tuple[Floats, ...]:
        """Lines of the links and shifts, between the rods, (2 or more, 3) each [m]."""
        if not np.any(self.rod < 0):
            return ()
        found, points = [], len(self.rod)
        ends = np.flatnonzero(np.diff(self.rod)) + 1
        for start, stop in zip([0, *ends], [*ends, points], strict=True):
            if self.rod[start] < 0 and stop - start + (start > 0) + (stop < points) > 1:
                found.append(self.position[max(start - 1, 0) : stop + 1])
        return tuple(found)


def leg_shapes(equilibrium: Equilibrium, points: int = 32) -> tuple[LegShape, ...]:
    """Shape of every leg at some points.

    Args:
        equilibrium: Where.
        points: Points of a rod, evenly spaced, both ends included, from 2 to 1000. How accurate they are
            does not depend on how many there are.

    Raises:
        InvalidRequest: No equilibrium; too few points or too many, or no whole number of them.
    """
    check_equilibrium(equilibrium)
    robot, state = equilibrium.robot, equilibrium.state
    return state_shapes(robot, state, checked_count("points", points, _FEWEST_POINTS, _MOST_POINTS))


def state_shapes(robot: Robot, state: Floats, points: int = 32) -> tuple[LegShape, ...]:
    """Shape of every leg in any state (N,), in equilibrium or not; then tips miss the platform."""
    rods, shapes = rods_from_identity(robot, state, points), []
    curvatures = rod_curvatures(robot, state, points)
    for number, leg in enumerate(robot.description.legs):
        poses, count = _element_poses(robot, number, state, rods)
        shapes.append(_along(leg, poses, rods[:count], curvatures[:count]))
        rods, curvatures = rods[count:], curvatures[count:]
    return tuple(shapes)


def tip_poses(robot: Robot, state: Floats) -> tuple[Pose, ...]:
    """Tips of the legs in the world in any state (N,), in equilibrium or not."""
    rods, tips = rods_from_identity(robot, state, _FEWEST_POINTS), []
    for number in range(len(robot.description.legs)):
        poses, own = _element_poses(robot, number, state, rods)
        tips.append(poses[-1])
        rods = rods[own:]
    return tuple(tips)


def rod_bases(robot: Robot, state: Floats) -> tuple[tuple[Pose, ...], ...]:
    """Where the rods of every leg begin in any state (N,)."""
    rods = rods_from_identity(robot, state, _FEWEST_POINTS)
    found = []
    for number, leg in enumerate(robot.description.legs):
        poses, own = _element_poses(robot, number, state, rods)
        found.append(
            tuple(
                pose
                for pose, element in zip(poses, leg.chain, strict=False)
                if isinstance(element, ChainRod)
            )
        )
        rods = rods[own:]
    return tuple(found)


def _joint_places(leg: LegDescription, poses: list[Pose]) -> tuple[JointPlace, ...]:
    """The joints of a leg where they are."""
    found = []
    for element, before, behind in zip(leg.chain, poses, poses[1:], strict=False):
        if isinstance(element, ChainJoint):
            found.append(JointPlace(element.shown_kind, element.motor, behind.position))
        elif element.shown_kind and element.motor is not None:
            found.append(JointPlace(element.shown_kind, element.motor, before.position))
    own = type(leg.joint)
    tip = next((kind for kind, joint in JOINTS.items() if joint is own), own.__name__)
    return (*found, JointPlace(tip, None, poses[-1].position))


def _along(
    leg: LegDescription,
    poses: list[Pose],
    rods: list[RodShape],
    curvatures: list[Floats],
) -> LegShape:
    """Points of the elements of a chain, one after the other; turns add none."""
    chain = leg.chain
    parts, way, number = [], 0.0, 0
    pieces = [element for element in chain if element.adds_point]
    if not pieces or not isinstance(pieces[0], ChainRod):
        parts.append(_point(way, poses[0]))
    for element, start, end in zip(chain, poses, poses[1:], strict=False):
        if isinstance(element, ChainRod):
            shape = rods[number]
            parts.append(
                LegShape(
                    arc_length=way + shape.length * np.linspace(0.0, 1.0, len(shape.position)),
                    position=start.position + shape.position @ start.rotation.T,
                    rotation=start.rotation @ shape.rotation,
                    curvature=curvatures[number],
                    rod=np.full(len(shape.position), number),
                )
            )
            way, number = way + shape.length, number + 1
        elif element.adds_point:
            way += float(np.linalg.norm(end.position - start.position))
            parts.append(_point(way, end))
    if not chain[-1].adds_point:  # the tip is behind it
        parts.append(_point(way, poses[-1]))
    joints = _joint_places(leg, poses)
    if len(parts) == 1:
        return replace(parts[0], joints=joints)
    return LegShape(
        arc_length=np.concatenate([part.arc_length for part in parts]),
        position=np.concatenate([part.position for part in parts]),
        rotation=np.concatenate([part.rotation for part in parts]),
        curvature=np.concatenate([part.curvature for part in parts]),
        rod=np.concatenate([part.rod for part in parts]),
        joints=joints,
    )


def _point(way: float, pose: Pose) -> LegShape:
    """A point of a rigid piece."""
    return LegShape(
        arc_length=np.array([way]),
        position=pose.position[None],
        rotation=pose.rotation[None],
        curvature=np.zeros((1, 3)),
        rod=np.array([-1]),
    )


def _element_poses(
    robot: Robot, number: int, state: Floats, rods: list[RodShape]
) -> tuple[list[Pose], int]:
    """Where the elements of a leg begin, and its tip; and how many of the rods were its own."""
    leg, coordinates = robot.description.legs[number], robot.numbers.legs[number].coordinates
    rotation, position, count = leg.base_rotation, leg.base_position, 0
    poses = [Pose(rotation, position)]
    for element, index in zip(leg.chain, coordinates, strict=True):
        if isinstance(element, ChainRod):
            shape, count = rods[count], count + 1
            position = position + rotation @ shape.position[-1]
            rotation = rotation @ shape.rotation[-1]
        else:
            at = 0.0 if index is None else float(state[index])
            rotation, position = element.behind(rotation, position, at)
        poses.append(Pose(rotation, position))
    return poses, count
