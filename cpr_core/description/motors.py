# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What holds the base of a rod: motors and passive bases.

A base has at most one coordinate that turns the rod's base about an axis through the base point and
at most one that shifts the base or changes the length of the rod; either may be the motor. A new
motor is a class here and its name in ``MOTORS``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "MOTORS",
    "Extensible",
    "Hinge",
    "Motor",
    "MotorLimits",
    "Prismatic",
    "Revolute",
    "Welded",
]

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class MotorLimits:
    """What a motor can do.

    Attributes:
        lower: Smallest position [rad or m].
        upper: Largest position [rad or m].
        speed: Largest speed [rad/s or m/s].
        effort: Largest effort, either sign [N m or N].
    """

    lower: float = -math.inf
    upper: float = math.inf
    speed: float = math.inf
    effort: float = math.inf


@dataclass(frozen=True)
class Motor:
    """Base of a rod.

    Attributes:
        actuated: Which coordinate is the motor's: ``turn``, ``shift`` or None.
        extensible: Whether the shift is the rod's length.
        unit: Unit of the motor position.
    """

    actuated: ClassVar[Literal["turn", "shift"] | None] = None
    extensible: ClassVar[bool] = False
    unit: ClassVar[str] = ""

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """Unit axis, in the world, of the turn; None where the base cannot turn."""
        return None

    @property
    def shift_axis(self) -> Vector | None:
        """Unit direction, in the world, of the shift; None where there is none."""
        return None


@dataclass(frozen=True)
class Revolute(Motor):
    """Turns the base of the rod: sigma = 0 in Eq. (13).

    Attributes:
        axis: Unit axis in the world, through the base point.
    """

    axis: Vector
    actuated = "turn"
    unit = "rad"

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """The motor axis."""
        return self.axis


@dataclass(frozen=True)
class Prismatic(Motor):
    """Shifts the base of the rod: sigma = 1 in Eq. (13).

    Attributes:
        axis: Unit direction in the world.
    """

    axis: Vector
    actuated = "shift"
    unit = "m"

    @property
    def shift_axis(self) -> Vector | None:
        """The motor axis."""
        return self.axis


@dataclass(frozen=True)
class Extensible(Motor):
    """Feeds the rod through the base point: the motor variable is the rod's length.

    Attributes:
        spin: Whether the rod may turn freely about its own axis at the base.
    """

    spin: bool = False
    actuated = "shift"
    extensible = True
    unit = "m"

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """The base tangent, if the rod may spin."""
        return tuple(base_rotation[:, 0].tolist()) if self.spin else None

    @property
    def shift_axis(self) -> Vector | None:
        """Not a direction in the world; the rod grows along itself."""
        return (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Hinge(Motor):
    """Passive base: turns freely about an axis.

    Attributes:
        axis: Unit axis in the world, through the base point.
    """

    axis: Vector

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """The hinge axis."""
        return self.axis


@dataclass(frozen=True)
class Welded(Motor):
    """Passive base: clamped, no motor."""


#: Motors by the name used in descriptions.
MOTORS: dict[str, type[Motor]] = {
    "revolute": Revolute,
    "prismatic": Prismatic,
    "extensible": Extensible,
    "hinge": Hinge,
    "welded": Welded,
}
