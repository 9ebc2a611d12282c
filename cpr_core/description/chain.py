# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A leg as a chain from its base towards the platform: joints, rigid links and rods, one after the other.

Everything is in the frame (d1, d2, d3) that the elements before lead to, all joints at zero.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..description_part import Vector
from ..rods.rod import Rod, StrainModes

__all__ = ["ChainElement", "ChainJoint", "ChainRod", "Link", "Shift", "Turn"]

_ORIGIN: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class ChainJoint:
    """A joint with one coordinate.

    Attributes:
        axis: Unit axis in the frame before the joint.
        motor: Name of the motor that moves it; None: it is passive.
        ratio: How far the joint goes when its motor goes one.
        zero: Where the joint is with its coordinate at zero [rad or m].
        stiffness: Of its spring [N m/rad or N/m].
        rest: Coordinate at which the spring is at rest [rad or m].
        unit: Unit of the coordinate.
    """

    axis: Vector
    motor: str | None = None
    ratio: float = 1.0
    zero: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    unit: ClassVar[str] = ""


@dataclass(frozen=True)
class Turn(ChainJoint):
    """Turns all behind it about its axis."""

    unit = "rad"


@dataclass(frozen=True)
class Shift(ChainJoint):
    """Shifts all behind it along its axis."""

    unit = "m"


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid piece.

    Attributes:
        offset: Where it leads [m].
        rotation: Frame behind it (d1, d2, d3 as columns), (3, 3).
        mass: [kg].
        center_of_mass: [m].
    """

    offset: Vector = _ORIGIN
    rotation: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    mass: float = 0.0
    center_of_mass: Vector = _ORIGIN


@dataclass(frozen=True, eq=False)
class ChainRod:
    """A rod.

    Attributes:
        rod: The rod.
        modes: Its strain modes.
        motor: Name of the motor that feeds it: its length then is the motor's position. None: its
            length is fixed.
    """

    rod: Rod
    modes: StrainModes
    motor: str | None = None


ChainElement: TypeAlias = ChainJoint | Link | ChainRod
