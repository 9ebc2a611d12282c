# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Passive joints between the rod tips and the platform.

Every joint holds the tip at a point of the platform (Eq. (15)). What it does to the orientation is a
list of constraints linear in the tip frame R_l and in the joint frame R_j = R_p R_c:

    psi_k = tr((R_j M_k)^T R_l) = 0,

so one kernel serves them all. A new joint is one class, which reads its own part of a description, and
its name in ``JOINTS``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ..description_part import Described, Part, Vector, field, triple
from ..lie import directions_across, skew

__all__ = ["JOINTS", "Fixed", "Joint", "RevoluteJoint", "Spherical", "Universal"]


@dataclass(frozen=True)
class Joint(Described):
    """Joint at the tip of a rod.

    Attributes:
        position: Tip joint in the platform frame [m].
    """

    position: Vector
    fields: ClassVar[Mapping[str, Any]] = {
        "position": field("vector", "in the platform frame [m]"),
    }
    required: ClassVar[tuple[str, ...]] = ("position",)

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """One that is its position."""
        return cls(triple(part.vector("position")))

    def rotation(self) -> NDArray[np.float64]:
        """Joint frame in the platform frame, R_c of Eq. (16), (3, 3)."""
        return np.eye(3)

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """Matrices M_k of the orientation constraints, shape (0 to 3, 3, 3)."""
        return np.zeros((0, 3, 3))

    def misalignment(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> float:
        """How far the tip is turned out of the joint [rad]; the constraints hold at half a turn too.

        Args:
            platform_rotation: R_p in the world, (3, 3).
            tip_rotation: R_l in the world, (3, 3).
        """
        return 0.0


@dataclass(frozen=True)
class Spherical(Joint):
    """Free to turn: position constraint only, Eq. (20). In the plane the same as revolute."""


@dataclass(frozen=True)
class Fixed(Joint):
    """Clamped tip, Eqs. (15)-(16): the moment multipliers are moments about the joint axes [N m].

    Attributes:
        frame: Rod tip frame (d1, d2, d3 as columns) in the platform frame, rows of a (3, 3) matrix.
    """

    frame: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    fields: ClassVar[Mapping[str, Any]] = {
        **Joint.fields,
        "tangent": field("axis", "direction of the rod's tip (d1) in the platform frame"),
        "normal": field("axis", "direction of d2 there; required in space"),
    }
    required = ("position", "tangent")

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Its position, and the frame of tangent and normal."""
        first, second, third = (triple(row) for row in part.frame())
        return cls(triple(part.vector("position")), (first, second, third))

    def rotation(self) -> NDArray[np.float64]:
        """The prescribed tip frame."""
        return np.array(self.frame)

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """Half the skew part of R_j^T R_l: psi vanishes where the frames coincide."""
        axes = np.eye(3)[2:] if planar else np.eye(3)
        return np.array([0.5 * skew(axis) for axis in axes])

    def misalignment(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> float:
        """Angle between the tip frame and its prescribed frame."""
        turn = self.rotation().T @ platform_rotation.T @ tip_rotation
        sines = turn[[2, 0, 1], [1, 2, 0]] - turn[[1, 2, 0], [2, 0, 1]]
        return float(np.arctan2(np.linalg.norm(sines), np.trace(turn) - 1.0))


@dataclass(frozen=True)
class RevoluteJoint(Joint):
    """Hinge: an axis of the rod's tip frame stays along an axis of the platform.

    Attributes:
        axis: Unit axis in the platform frame.
        axis_in_rod: The same axis in the rod's tip frame (d1, d2, d3).
    """

    axis: Vector = (0.0, 0.0, 1.0)
    axis_in_rod: Vector = (0.0, 0.0, 1.0)
    fields: ClassVar[Mapping[str, Any]] = {
        **Joint.fields,
        "axis": field("axis", "in the platform frame; in the plane z"),
        "axis_in_rod": field("axis", "the same axis in the tip frame (d1, d2, d3); default d3"),
    }

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Its position and axes; in the plane +-z."""
        position = triple(part.vector("position"))
        if part.planar:
            for name in ("axis", "axis_in_rod"):
                if name in part:
                    part.turn_axis(name)
            return cls(position)
        in_rod = part.direction("axis_in_rod", (0.0, 0.0, 1.0))
        return cls(position, triple(part.direction("axis")), triple(in_rod))

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """Two directions across the axis; in the plane nothing is left to hold."""
        if planar:
            return np.zeros((0, 3, 3))
        across = directions_across(np.array(self.axis))
        return np.array([np.outer(direction, self.axis_in_rod) for direction in across])

    def misalignment(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> float:
        """Angle between the two axes."""
        axis, axis_in_rod = platform_rotation @ self.axis, tip_rotation @ self.axis_in_rod
        return float(np.arctan2(np.linalg.norm(np.cross(axis, axis_in_rod)), axis @ axis_in_rod))


@dataclass(frozen=True)
class Universal(Joint):
    """Cardan joint: an axis of the platform stays perpendicular to an axis of the tip frame.

    Attributes:
        axis: Unit axis in the platform frame.
        axis_in_rod: Unit axis in the rod's tip frame (d1, d2, d3).
    """

    axis: Vector = (0.0, 1.0, 0.0)
    axis_in_rod: Vector = (0.0, 0.0, 1.0)
    fields: ClassVar[Mapping[str, Any]] = {
        **Joint.fields,
        "axis": field("axis", "axis of the cross fixed to the platform, in its frame"),
        "axis_in_rod": field(
            "axis", "axis of the cross fixed to the rod, in the tip frame; default d3"
        ),
    }
    required = ("position", "axis")

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Its position and axes; in space only."""
        if part.planar:
            raise part.fail("type", "universal joints need a spatial robot")
        axis, in_rod = part.direction("axis"), part.direction("axis_in_rod", (0.0, 0.0, 1.0))
        return cls(triple(part.vector("position")), triple(axis), triple(in_rod))

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """The cosine between the two axes of the cross."""
        return np.array([np.outer(self.axis, self.axis_in_rod)])

    def misalignment(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> float:
        """How far the two axes of the cross are from a right angle."""
        cosine = (platform_rotation @ self.axis) @ (tip_rotation @ self.axis_in_rod)
        return float(abs(np.arcsin(np.clip(cosine, -1.0, 1.0))))


#: Joints by the name used in descriptions.
JOINTS: dict[str, type[Joint]] = {
    "spherical": Spherical,
    "fixed": Fixed,
    "revolute": RevoluteJoint,
    "universal": Universal,
}
