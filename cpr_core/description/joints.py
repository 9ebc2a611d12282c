# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Passive joints between the rod tips and the platform.

Every joint holds the tip at a point of the platform (Eq. (15)). What it does to the orientation is a
list of constraints linear in the tip frame R_l and in the joint frame R_j = R_p R_c:

    psi_k = tr((R_j M_k)^T R_l) = 0,

so one kernel serves them all. A new joint is a class here and its name in ``JOINTS``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..lie import skew

__all__ = ["JOINTS", "Fixed", "Joint", "Revolute", "Spherical", "Universal"]

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Joint:
    """Joint at the tip of a rod.

    Attributes:
        position: Tip joint in the platform frame [m].
    """

    position: Vector

    def rotation(self) -> NDArray[np.float64]:
        """Joint frame in the platform frame, R_c of Eq. (16), (3, 3)."""
        return np.eye(3)

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """Matrices M_k of the orientation constraints, shape (0 to 3, 3, 3)."""
        return np.zeros((0, 3, 3))

    def turned_over(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> bool:
        """Whether the constraints hold, but half a turn away from how the joint is built."""
        return False


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

    def rotation(self) -> NDArray[np.float64]:
        """The prescribed tip frame."""
        return np.array(self.frame)

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """Half the skew part of R_j^T R_l: psi vanishes where the frames coincide."""
        axes = np.eye(3)[2:] if planar else np.eye(3)
        return np.array([0.5 * skew(axis) for axis in axes])

    def turned_over(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> bool:
        """Whether the tip is half a turn away from its prescribed frame."""
        return bool(np.trace(self.rotation().T @ platform_rotation.T @ tip_rotation) < 1.0)


@dataclass(frozen=True)
class Revolute(Joint):
    """Hinge: an axis of the rod's tip frame stays along an axis of the platform.

    Attributes:
        axis: Unit axis in the platform frame.
        axis_in_rod: The same axis in the rod's tip frame (d1, d2, d3).
    """

    axis: Vector = (0.0, 0.0, 1.0)
    axis_in_rod: Vector = (0.0, 0.0, 1.0)

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """Two directions across the axis; in the plane nothing is left to hold."""
        if planar:
            return np.zeros((0, 3, 3))
        across = np.linalg.svd(np.array([self.axis]))[2][1:]
        return np.array([np.outer(direction, self.axis_in_rod) for direction in across])

    def turned_over(
        self, platform_rotation: NDArray[np.float64], tip_rotation: NDArray[np.float64]
    ) -> bool:
        """Whether the two axes point in opposite directions."""
        return bool((platform_rotation @ self.axis) @ (tip_rotation @ self.axis_in_rod) < 0.0)


@dataclass(frozen=True)
class Universal(Joint):
    """Cardan joint: an axis of the platform stays perpendicular to an axis of the tip frame.

    Attributes:
        axis: Unit axis in the platform frame.
        axis_in_rod: Unit axis in the rod's tip frame (d1, d2, d3).
    """

    axis: Vector = (0.0, 1.0, 0.0)
    axis_in_rod: Vector = (0.0, 0.0, 1.0)

    def orientation(self, planar: bool) -> NDArray[np.float64]:
        """The cosine between the two axes of the cross."""
        return np.array([np.outer(self.axis, self.axis_in_rod)])


#: Joints by the name used in descriptions.
JOINTS: dict[str, type[Joint]] = {
    "spherical": Spherical,
    "fixed": Fixed,
    "revolute": Revolute,
    "universal": Universal,
}
