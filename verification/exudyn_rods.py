# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods in Exudyn: ANCF cables in the plane, geometrically exact beams in space.

Of both is kept what their nodes are: of a cable place and slope, of a beam the frame. A rod that is
cut into twice as many elements begins in the same shape, so that no element is stretched by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import exudyn
import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation

from .placed_robot import Frame, PlacedRod

__all__ = ["BEAMS", "CABLES", "AddedRod", "RodKind", "coordinates_of", "quaternion"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class AddedRod:
    """Numbers in the system.

    Attributes:
        nodes: Its nodes.
        base: Marker of its first frame.
        tip: Marker of its last frame.
    """

    nodes: tuple[int, ...]
    base: int
    tip: int


class RodKind(Protocol):
    """A kind of elements."""

    @property
    def name(self) -> str:
        """In tables."""
        ...

    @property
    def order(self) -> int:
        """Of convergence in the length of an element."""
        ...

    @property
    def planar(self) -> bool:
        """Whether it lives in the plane."""
        ...

    def straight(self, frame: Frame, length: float, elements: int) -> Floats:
        """Nodes of a straight rod, (elements + 1, c)."""
        ...

    def halved(self, nodes: Floats, length: float) -> Floats:
        """The nodes of a rod cut into twice as many elements, (2 elements + 1, c)."""
        ...

    def add(
        self, system: Any, rod: PlacedRod, rest: Floats, nodes: Floats, factor: float
    ) -> AddedRod:
        """A rod with its weight.

        Args:
            system: Exudyn's.
            rod: The rod.
            rest: Nodes of the straight rod, (elements + 1, c).
            nodes: Nodes where it starts, (elements + 1, c).
            factor: On what resists stretch and shear.
        """
        ...

    def weigh(self, system: Any, rod: PlacedRod, added: AddedRod, gravity: Floats) -> None:
        """The weight of a rod, gravity (3,) [m/s^2]."""
        ...


def coordinates_of(system: Any, nodes: Sequence[int]) -> Floats:
    """Coordinates of nodes as they are now, (len(nodes), c)."""
    kind = exudyn.OutputVariableType.Coordinates
    reference = exudyn.ConfigurationType.Reference
    return np.array(
        [
            np.array(system.GetNodeOutput(node, kind))
            + np.array(system.GetNodeOutput(node, kind, reference))
            for node in nodes
        ]
    )


@dataclass(frozen=True)
class Cables:
    """ANCF cables: Bernoulli-Euler rods that stretch, cubic between place and slope, in the plane."""

    name: str = "ANCFCable2D"
    order: int = 4
    planar: bool = True

    def straight(self, frame: Frame, length: float, elements: int) -> Floats:
        """Places and slopes on a line."""
        tangent = frame.rotation[:2, 0]
        along = np.linspace(0.0, length, elements + 1)[:, None]
        return np.hstack(
            [frame.position[:2] + along * tangent, np.tile(tangent, (elements + 1, 1))]
        )

    def halved(self, nodes: Floats, length: float) -> Floats:
        """The cubics of the elements, at their middles."""
        first, last, size = nodes[:-1], nodes[1:], length / (len(nodes) - 1)
        place = 0.5 * (first[:, :2] + last[:, :2]) + size / 8.0 * (first[:, 2:] - last[:, 2:])
        slope = 1.5 / size * (last[:, :2] - first[:, :2]) - 0.25 * (first[:, 2:] + last[:, 2:])
        return _between(nodes, np.hstack([place, slope]))

    def add(
        self, system: Any, rod: PlacedRod, rest: Floats, nodes: Floats, factor: float
    ) -> AddedRod:
        """One cable after the other."""
        size = rod.length / (len(nodes) - 1)
        numbers = [
            int(
                system.AddNode(
                    items.NodePoint2DSlope1(
                        referenceCoordinates=list(at_rest), initialCoordinates=list(node - at_rest)
                    )
                )
            )
            for at_rest, node in zip(rest, nodes, strict=True)
        ]
        bodies = [
            system.AddObject(
                items.ObjectANCFCable2D(
                    nodeNumbers=[first, last],
                    length=size,
                    massPerLength=max(rod.mass, 1e-3),
                    bendingStiffness=float(rod.rigidities[2]),
                    axialStiffness=factor * rod.stretch,
                    useReducedOrderIntegration=2,  # with 0 RFRFR is 2e-6 m off in the limit
                )
            )
            for first, last in pairwise(numbers)
        ]
        base = items.MarkerBodyRigid(bodyNumber=bodies[0], localPosition=[0.0, 0.0, 0.0])
        tip = items.MarkerBodyRigid(bodyNumber=bodies[-1], localPosition=[size, 0.0, 0.0])
        return AddedRod(tuple(numbers), int(system.AddMarker(base)), int(system.AddMarker(tip)))

    def weigh(self, system: Any, rod: PlacedRod, added: AddedRod, gravity: Floats) -> None:
        """As nodes carry it whose slopes are the shape: consistent with the cubics."""
        size = rod.length / (len(added.nodes) - 1)
        for number, node in enumerate(added.nodes):
            end = number in (0, len(added.nodes) - 1)
            force = rod.mass * size * (0.5 if end else 1.0) * gravity
            marker = system.AddMarker(items.MarkerNodePosition(nodeNumber=node))
            system.AddLoad(items.Force(markerNumber=marker, loadVector=force.tolist()))
            if not end:
                continue
            # The slopes of neighbours cancel but at the ends: a force on the slope, w h^2 / 12.
            sign = 1.0 if number == 0 else -1.0
            for axis in (0, 1):
                value = sign * rod.mass * size**2 / 12.0 * float(gravity[axis])
                slope = system.AddMarker(
                    items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2 + axis)
                )
                system.AddLoad(items.LoadCoordinate(markerNumber=slope, load=value))


@dataclass(frozen=True)
class Beams:
    """Geometrically exact beams: helices between two frames, that stretch and shear, in space."""

    name: str = "BeamGeometricallyExact"
    order: int = 2
    planar: bool = False

    def straight(self, frame: Frame, length: float, elements: int) -> Floats:
        """Places and unit quaternions on a line."""
        along = np.linspace(0.0, length, elements + 1)[:, None]
        places = frame.position + along * frame.rotation[:, 0]
        return np.hstack([places, np.tile(quaternion(frame.rotation), (elements + 1, 1))])

    def halved(self, nodes: Floats, length: float) -> Floats:
        """Halfway along the helices."""
        middles = []
        for first, last in pairwise(nodes):
            begin, end = _matrix(first), _matrix(last)
            middle = begin @ expm(0.5 * logm(np.linalg.solve(begin, end)).real)
            turn = quaternion(middle[:3, :3])
            middles.append(np.append(middle[:3, 3], np.copysign(1.0, turn @ first[3:]) * turn))
        return _between(nodes, np.array(middles))

    def add(
        self, system: Any, rod: PlacedRod, rest: Floats, nodes: Floats, factor: float
    ) -> AddedRod:
        """One beam after the other."""
        section = exudyn.BeamSection()
        stretch, shear = factor * rod.stretch, factor * rod.shear
        section.stiffnessMatrix = np.diag([stretch, shear, shear, *rod.rigidities])
        # Statics asks for neither, but Exudyn for both.
        section.massPerLength, section.inertia = max(rod.mass, 1e-3), 1e-6 * np.eye(3)
        numbers = [
            int(
                system.AddNode(
                    items.NodeRigidBodyEP(
                        referenceCoordinates=list(at_rest), initialCoordinates=list(node - at_rest)
                    )
                )
            )
            for at_rest, node in zip(rest, nodes, strict=True)
        ]
        for first, last in pairwise(numbers):
            system.AddObject(
                items.ObjectBeamGeometricallyExact(
                    nodeNumbers=[first, last],
                    length=rod.length / (len(nodes) - 1),
                    sectionData=section,
                )
            )
        ends = [
            int(system.AddMarker(items.MarkerNodeRigid(nodeNumber=numbers[end]))) for end in (0, -1)
        ]
        return AddedRod(tuple(numbers), ends[0], ends[1])

    def weigh(self, system: Any, rod: PlacedRod, added: AddedRod, gravity: Floats) -> None:
        """Half of every element on either node: Exudyn knows no load along these beams."""
        size = rod.length / (len(added.nodes) - 1)
        for number, node in enumerate(added.nodes):
            part = 0.5 if number in (0, len(added.nodes) - 1) else 1.0
            marker = system.AddMarker(items.MarkerNodePosition(nodeNumber=node))
            force = (part * rod.mass * size * gravity).tolist()
            system.AddLoad(items.Force(markerNumber=marker, loadVector=force))


def quaternion(rotation: Floats) -> Floats:
    """Euler parameters of a rotation, the scalar first, (4,)."""
    return Rotation.from_matrix(rotation).as_quat()[[3, 0, 1, 2]]


def _matrix(node: Floats) -> Floats:
    """Frame of a node of a beam as a homogeneous matrix, (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(node[[4, 5, 6, 3]]).as_matrix()
    matrix[:3, 3] = node[:3]
    return matrix


def _between(nodes: Floats, middles: Floats) -> Floats:
    found = np.empty((2 * len(nodes) - 1, nodes.shape[1]))
    found[::2], found[1::2] = nodes, middles
    return found


CABLES, BEAMS = Cables(), Beams()
