# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot whose legs are chains, of continuous rods, as the shooting sees it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainJoint, ChainRod, Link, Shift, Turn
from ..description.chain_element import ChainElement
from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.robot import Robot
from .rod_integration import RodProperties, RodTables, UniformProperties
from .shooting_method import TABLEAUS, ShootingMethod

__all__ = ["ChainRobot", "FedRod", "LegModel", "RodModel", "RodPart", "chain_robot"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class RodPart(NamedTuple):
    """A part of a rod without kinks of its properties, and the point force where it begins, (3,) [N]."""

    begin: float
    end: float
    tables: RodTables
    push: Floats


class FedRod(NamedTuple):
    """What is fed: length of the whole rod [m], its mean force per length, (3,) [N/m], and the rod."""

    nominal: float
    force: Floats
    rod: ChainRod


@dataclass(frozen=True, eq=False)
class RodModel:
    """A rod.

    Attributes:
        number: In the robot.
        element: As described.
        properties: Along s/l.
        length: Its length [m]; of one that is fed the nominal one.
        parts: From base to tip.
        fed: Where a motor feeds it.
    """

    number: int
    element: ChainRod
    properties: RodProperties
    length: float
    parts: tuple[RodPart, ...]
    fed: FedRod | None


@dataclass(frozen=True, eq=False)
class LegModel:
    """A leg: its elements, each with the state index of what moves it.

    Attributes:
        base_position: (3,) [m].
        base_rotation: (3, 3).
        elements: From base to tip.
        passive: State indices of its passive joints.
        moments: State indices of the multipliers of its tip's orientation.
        tip: Tip joint in the platform frame, (3,) [m].
        conditions: Matrices R_c M_k of the constraints tr((R_p R_c M_k)^T R_l) = 0, (K, 3, 3).
        gravity: (3,) [m/s^2].
    """

    base_position: Floats
    base_rotation: Floats
    elements: tuple[tuple[ChainJoint | Link | RodModel, int | None], ...]
    passive: Integers
    moments: Integers
    tip: Floats
    conditions: Floats
    gravity: Floats


@dataclass(frozen=True, eq=False)
class ChainRobot:
    """A robot, its loads and how its rods are integrated."""

    robot: Robot
    loads: Loads
    method: ShootingMethod
    legs: tuple[LegModel, ...]

    @property
    def in_plane(self) -> Integers:
        """Components of a position or force over a turn or moment that there are, of six."""
        return np.array([0, 1, 5] if self.robot.planar else range(6))

    @property
    def in_chain(self) -> Integers:
        """Components of (dp, dtheta, dm, dn) that there are, of twelve."""
        return np.array([0, 1, 5, 8, 9, 10] if self.robot.planar else range(12))


def chain_robot(
    robot: Robot,
    loads: Loads,
    method: ShootingMethod,
    cuts: Mapping[int, Sequence[float]] | None = None,
) -> ChainRobot:
    """A robot ready for shooting.

    Args:
        robot: The robot.
        loads: The loads.
        method: How its rods are integrated.
        cuts: Where rods are cut beside their kinks, s/l between 0 and 1, by number of the rod.

    Raises:
        InvalidRequest: A joint of a kind this method does not know.
    """
    legs, number = [], 0
    for leg, own in zip(robot.description.legs, robot.numbers.legs, strict=True):
        elements: list[tuple[ChainJoint | Link | RodModel, int | None]] = []
        passive = []
        for element, index in zip(leg.chain, own.coordinates, strict=True):
            if isinstance(element, ChainRod):
                own_cuts = (cuts or {}).get(number, ())
                name = robot.rod_names[number]
                rod = _rod_model(loads, method, name, element, number, own_cuts)
                elements.append((rod, index))
                number += 1
                continue
            elements.append((_known(leg.name, element), index))
            if isinstance(element, ChainJoint) and element.motor is None:
                passive.append(index)
        conditions = leg.joint.orientation(robot.planar)
        legs.append(
            LegModel(
                base_position=np.array(leg.base_position, float),
                base_rotation=np.array(leg.base_rotation, float),
                elements=tuple(elements),
                passive=np.array(passive, np.int64),
                moments=np.arange(own.moments.start, own.moments.stop),
                tip=np.array(leg.joint.position, float),
                conditions=np.array([leg.joint.rotation() @ m for m in conditions]).reshape(
                    -1, 3, 3
                ),
                gravity=loads.gravity,
            )
        )
    return ChainRobot(robot, loads, method, tuple(legs))


def _known(leg: str, element: ChainElement) -> ChainJoint | Link:
    """An element that is no rod, of a kind that is known."""
    if not isinstance(element, (Turn, Shift, Link)):
        expected = "expected turns, shifts, links and rods"
        raise InvalidRequest("robot", f"{leg}: {expected}, got {type(element).__name__}")
    return element


def _rod_model(
    loads: Loads,
    method: ShootingMethod,
    name: str,
    element: ChainRod,
    number: int,
    cuts: Sequence[float],
) -> RodModel:
    rod = element.rod
    distributed = [force for force in loads.distributed if force.leg == name]
    points = [force for force in loads.points if force.leg == name]

    def force_at(sigma: Floats) -> Floats:
        force = rod.mass_at(sigma)[:, None] * loads.gravity + loads.rod_force
        for own in distributed:
            columns = [np.interp(sigma, own.at, own.force[:, axis]) for axis in range(3)]
            force = force + np.column_stack(columns)
        return force

    kind = UniformProperties if rod.uniform and not distributed else RodProperties
    properties = kind(lambda sigma: 1.0 / rod.rigidities_at(sigma), rod.rest_curvature_at, force_at)
    kinks = {0.0, 1.0, *cuts, *(point.at for point in points)}
    if not rod.profile.uniform:
        kinks |= {*rod.profile.at.tolist()}
    for own in distributed:
        kinks |= {*own.at.tolist()}
    ends = sorted(kinks)
    parts = []
    for begin, end in pairwise(ends):
        push = np.sum([point.force for point in points if point.at == begin] or np.zeros((1, 3)), 0)
        steps = max(2, int(np.ceil(method.steps * (end - begin) - 1e-9)))
        tables = properties.tables(begin, end, steps, TABLEAUS[method.tableau])
        parts.append(RodPart(begin, end, tables, push))
    fed = None
    if element.motor is not None:
        fed = FedRod(rod.length, _mean(force_at, ends), element)
    return RodModel(number, element, properties, rod.length, tuple(parts), fed)


def _mean(function: Callable[[Floats], Floats], ends: list[float]) -> Floats:
    """Integral over s/l from 0 to 1 of what is smooth between the ends."""
    points, weights = np.polynomial.legendre.leggauss(12)
    parts = [
        0.5 * (b - a) * weights @ function(a + 0.5 * (b - a) * (points + 1.0))
        for a, b in pairwise(ends)
    ]
    return np.sum(parts, axis=0)
