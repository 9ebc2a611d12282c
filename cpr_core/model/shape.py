# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shapes of the legs, for drawings and checks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainJoint, ChainRod
from ..description.joints import JOINTS
from ..description.leg_description import LegDescription
from ..kernels.rotation_kernel import rotation_steps
from ..lie import rotations_exp
from ..rods.quadrature import MAGNUS_WEIGHTS, RodGrid, integration_to, steps_to
from ..rods.rod import StrainModes
from ..validation import ReadOnlyArrays, checked_count
from .equilibrium import Equilibrium, check_equilibrium
from .robot import Robot

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
    sampling, shapes = _sampling(robot.grid, points), []
    rods = _rods_from_identity(robot, state, sampling)
    curvatures = [
        _sampled(rod.element.modes, sampling).values @ state[rod.strain] / rod.stretch(state)
        + _at_rest_beyond(rod.element, sampling).values
        for rod in robot.numbers.rods
    ]
    for number, leg in enumerate(robot.description.legs):
        poses, count = _element_poses(robot, number, state, rods)
        shapes.append(_along(leg, poses, rods[:count], curvatures[:count]))
        rods, curvatures = rods[count:], curvatures[count:]
    return tuple(shapes)


def tip_poses(robot: Robot, state: Floats) -> tuple[Pose, ...]:
    """Tips of the legs in the world in any state (N,), in equilibrium or not."""
    rods, tips = _rods_from_identity(robot, state, _sampling(robot.grid, _FEWEST_POINTS)), []
    for number in range(len(robot.description.legs)):
        poses, own = _element_poses(robot, number, state, rods)
        tips.append(poses[-1])
        rods = rods[own:]
    return tuple(tips)


def rod_bases(robot: Robot, state: Floats) -> tuple[tuple[Pose, ...], ...]:
    """Where the rods of every leg begin in any state (N,)."""
    rods = _rods_from_identity(robot, state, _sampling(robot.grid, _FEWEST_POINTS))
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


class _RodShape(NamedTuple):
    """A rod that begins at the origin along the axes of the world."""

    position: Floats  # (P, 3)
    rotation: Floats  # (P, 3, 3)
    length: float


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
    rods: list[_RodShape],
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
    robot: Robot, number: int, state: Floats, rods: list[_RodShape]
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


def _rods_from_identity(robot: Robot, state: Floats, sampling: _Sampling) -> list[_RodShape]:
    """All rods at once, step by step."""
    rods, steps = list(robot.numbers.rods), sampling.steps
    moments = np.empty((len(rods), len(steps), 3, 3))
    for alike in robot.numbers.alike_rods:
        step_moments = _sampled(alike.modes, sampling).step_moments
        found = state[alike.strain] @ step_moments.reshape(len(step_moments), -1)
        moments[alike.numbers] = found.reshape(-1, len(steps), 3, 3)
    for number, rod in enumerate(rods):
        if not rod.element.modes.hold(rod.element.rod.rest_curvature):
            moments[number] += _at_rest_beyond(rod.element, sampling).step_moments
    nominal = np.array([rod.element.rod.length for rod in rods])
    turns = np.empty((len(rods) * len(steps), 3))
    rotation_steps(moments.reshape(-1, 3, 3), np.outer(nominal, steps).ravel(), turns)
    frames = _products(rotations_exp(turns.reshape(len(rods), -1, 3)))
    positions = sampling.integration @ frames[:, sampling.at_nodes][..., 0]
    lengths = [float(rod.length(state)) for rod in rods]
    return [
        _RodShape(length * position, frame, length)
        for length, position, frame in zip(
            lengths, positions, frames[:, sampling.at_places], strict=True
        )
    ]


def _products(turns: Floats) -> Floats:
    """The identity, and all products of the first rotations: (R, H, 3, 3) to (R, H + 1, 3, 3)."""
    found = np.concatenate([np.broadcast_to(np.eye(3), (len(turns), 1, 3, 3)), turns], axis=1)
    reach = 1  # every product is of so many
    while reach < found.shape[1]:
        found[:, reach:] = found[:, :-reach] @ found[:, reach:]
        reach *= 2
    return found


@dataclass(frozen=True, eq=False)
class _Sampling:
    """Points wanted of a rod, and how the quadrature of equilibria leads to them.

    Attributes:
        places: Where they are, as sigma, (P,).
        steps: Lengths of rotation steps from 0 to 1 that end at every node and every place, (H,).
        step_points: Points of every step, (H, 16).
        at_nodes: Steps up to every node of the quadrature, (K,).
        at_places: Steps up to every place, (P,).
        integration: From values at the nodes to integrals from 0 to the places, (P, K).
    """

    places: Floats
    steps: Floats
    step_points: Floats
    at_nodes: NDArray[np.int64]
    at_places: NDArray[np.int64]
    integration: Floats


@lru_cache(maxsize=64)
def _sampling(grid: RodGrid, points: int) -> _Sampling:
    places = np.linspace(0.0, 1.0, points)
    ends = np.union1d(grid.stops, places)  # of the steps, the origin before them
    return _Sampling(
        places,
        *steps_to(ends[1:]),
        np.searchsorted(ends, grid.nodes),
        np.searchsorted(ends, places),
        integration_to(places, grid.edges, grid.panel_nodes),
    )


class _Sampled(NamedTuple):
    """Shape functions of a rod where its shape is wanted."""

    step_moments: Floats  # (m, H, 3, 3): moments of the three strain components over rotation steps
    values: Floats  # (P, 3, m)


@lru_cache(maxsize=64)
def _sampled(modes: StrainModes, sampling: _Sampling) -> _Sampled:
    """They are the same for rods of the same modes, and in every configuration."""
    points, one_hot = sampling.step_points, np.eye(3)[modes.directions].T
    steps = modes.values(points.ravel()).reshape(*points.shape, modes.total)
    moments = np.einsum("mk,hkj,cj->jhmc", MAGNUS_WEIGHTS, steps, one_hot)
    return _Sampled(moments, modes.values(sampling.places)[:, None, :] * one_hot)


class _AtRest(NamedTuple):
    """Curvature at rest of a rod beyond its modes where its shape is wanted."""

    step_moments: Floats  # (H, 3, 3): its moments over rotation steps, by component
    values: Floats  # (P, 3)


@lru_cache(maxsize=64)
def _at_rest_beyond(element: ChainRod, sampling: _Sampling) -> _AtRest:
    """It is the same in every configuration."""
    rod, modes = element.rod, element.modes
    steps = rod.rest_beyond_steps(modes, sampling.step_points)
    return _AtRest(steps, rod.rest_beyond_at(modes, sampling.places))
