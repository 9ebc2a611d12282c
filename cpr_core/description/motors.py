# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What holds the base of a rod: motors and passive bases.

A base has at most one coordinate that turns the rod's base about an axis through the base point and
at most one that shifts the base or changes the length of the rod; either may be the motor. A new
motor is one class, which reads its own part of a description, and its name in ``MOTORS``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from ..description_part import Described, Part, Vector, field, triple

__all__ = [
    "FARTHEST",
    "LEAD",
    "MOTORS",
    "NO_LIMITS",
    "OFFSET",
    "UNDRIVEN",
    "Drive",
    "Extensible",
    "Hinge",
    "Motor",
    "MotorLimits",
    "Prismatic",
    "RevoluteMotor",
    "Welded",
]


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

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Limits of a motor.

        Raises:
            DescriptionError: The lower position is not below the upper one.
        """
        lower, upper = part.get("position", (-math.inf, math.inf))
        if lower >= upper:
            raise part.fail("position", f"expected lower below upper, got [{lower}, {upper}]")
        speed, effort = part.number("speed", math.inf), part.number("effort", math.inf)
        return cls(float(lower), float(upper), speed, effort)


NO_LIMITS = MotorLimits()

#: Places of a joint beyond this are rounding, as turns and as lengths [rad or m].
FARTHEST = {"minimum": -1e9, "maximum": 1e9}
#: Schema of the zero of a motor, and of what is between it and its joint.
OFFSET = FARTHEST | {
    "type": "number",
    "description": "where the joint is, or how long the rod, at zero of the motor [rad or m]; default 0",
}
_RATIO = {
    "type": "number",
    "description": "way of the joint, or length of the rod, per way of the motor; default 1",
}
LEAD = {
    "type": "number",
    "description": "way per turn of a motor that turns a screw, belt or roller [m], in place of ratio; "
    "default none",
}


#: Bounds of the size of ratios and leads [m], within which their squares, and those of their inverses,
#: neither overflow nor vanish.
_RATIOS = (1e-30, 1e30)


def _described_ratio(part: Part) -> float:
    """Way of a joint per way of its motor, of either sign.

    Raises:
        DescriptionError: It is zero, too small or too large to compute with, or said twice.
    """
    if "lead" in part and "ratio" in part:
        raise part.fail("lead", "a motor that turns has a lead, one that shifts a ratio")
    name = "lead" if "lead" in part else "ratio"
    way = part.number(name, 1.0)
    if way == 0.0:
        raise part.fail(name, "expected a number other than zero")
    smallest, largest = _RATIOS
    if not smallest <= abs(way) <= largest:
        raise part.fail(
            name, f"expected a number from {smallest:g} to {largest:g}, or negative, got {way}"
        )
    return way / (2.0 * math.pi) if name == "lead" else way


@dataclass(frozen=True)
class Drive:
    """What moves a joint or feeds a rod: a motor, and what is between them.

    What else a motor or its gear may have is a field here, and read here, for joints and rods alike.

    Attributes:
        motor: Name of the motor; None: a passive joint, or a rod of fixed length.
        ratio: How far the joint goes, or how much longer the rod gets, when the motor goes one.
        zero: Where the joint is, or how long the rod, with the motor at zero [rad or m].
        limits: What the motor can do.
        screw: Whether the motor turns what shifts, by a screw, a belt or a roller.
    """

    motor: str | None = None
    ratio: float = 1.0
    zero: float = 0.0
    limits: MotorLimits = NO_LIMITS
    screw: bool = False
    fields: ClassVar[Mapping[str, Any]] = {
        "motor": field("name", "the motor that moves it; default passive"),
        "ratio": _RATIO,
        "offset": OFFSET,
        "limits": field("limits", "what the motor can do; default unlimited"),
    }

    @classmethod
    def from_description(cls, part: Part, would: str) -> Self:
        """That of a joint or a rod of a chain.

        Args:
            part: The joint or the rod.
            would: What a motor would do, for errors.

        Raises:
            DescriptionError: Without a motor it has what only one with motor has.
        """
        if "motor" in part:
            return cls.of_motor(str(part.get("motor")), part)
        for given in ("lead", *cls.fields):
            if given in part:
                raise part.fail(given, f"no motor {would}: give one, or leave it out")
        return cls()

    @classmethod
    def of_motor(cls, motor: str, part: Part) -> Self:
        """That of a motor, all else as its part of a description says."""
        return cls(
            motor,
            _described_ratio(part),
            part.number("offset", 0.0),
            MotorLimits.from_description(part.part("limits")),
            "lead" in part,
        )

    def without_limits(self) -> Self:
        """The same with a motor that can do everything."""
        return replace(self, limits=NO_LIMITS)


UNDRIVEN = Drive()


@dataclass(frozen=True)
class Motor(Described):
    """Base of a rod.

    Attributes:
        actuated: Which coordinate is the motor's: ``turn``, ``shift`` or None. One that has any has
            the fields ``name``, ``limits``, ``offset`` and those of a gear in descriptions too.
        extensible: Whether the shift is the rod's length.
        unit: Unit of the motor position.
    """

    actuated: ClassVar[Literal["turn", "shift"] | None] = None
    extensible: ClassVar[bool] = False
    unit: ClassVar[str] = ""

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """One without fields of its own."""
        return cls()

    def check_tip(self, part: Part, holds_orientation: bool) -> None:
        """Whether the tip of the rod leaves no motion that nothing holds.

        Args:
            part: The motor in the description.
            holds_orientation: Whether the tip joint takes moments.

        Raises:
            DescriptionError: It does not.
        """

    def across(self) -> Vector | None:
        """Unit vector in the world, along which d2 is at the base unless said otherwise."""
        return None

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """Unit axis, in the world, of the turn; None where the base cannot turn."""
        return None

    @property
    def shift_axis(self) -> Vector | None:
        """Unit direction, in the world, of the shift; None where there is none."""
        return None


@dataclass(frozen=True)
class _AboutAxis(Motor):
    """Turns about an axis in the world.

    Attributes:
        axis: Unit axis in the world, through the base point.
    """

    axis: Vector
    fields: ClassVar[Mapping[str, Any]] = {"axis": field("axis", "in the world")}
    required = ("axis",)

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Its axis; in the plane +-z."""
        return cls(triple(part.turn_axis("axis")))

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """The axis."""
        return self.axis

    def across(self) -> Vector | None:
        """The axis."""
        return self.axis


@dataclass(frozen=True)
class RevoluteMotor(_AboutAxis):
    """Turns the base of the rod: sigma = 0 in Eq. (13)."""

    actuated = "turn"
    unit = "rad"


@dataclass(frozen=True)
class Prismatic(Motor):
    """Shifts the base of the rod: sigma = 1 in Eq. (13).

    Attributes:
        axis: Unit direction in the world.
    """

    axis: Vector
    actuated = "shift"
    unit = "m"
    fields: ClassVar[Mapping[str, Any]] = {"axis": field("axis", "in the world")}
    required = ("axis",)

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Its axis; in the plane one without z."""
        return cls(triple(part.shift_axis("axis")))

    @property
    def shift_axis(self) -> Vector | None:
        """The motor axis."""
        return self.axis

    def across(self) -> Vector | None:
        """The motor axis."""
        return self.axis


@dataclass(frozen=True)
class Extensible(Motor):
    """Feeds the rod through the base point: the motor variable is the rod's length, but for a gear.

    Attributes:
        spin: Whether the rod may turn freely about its own axis at the base.
    """

    spin: bool = False
    actuated = "shift"
    extensible = True
    unit = "m"
    fields: ClassVar[Mapping[str, Any]] = {
        "spin": {
            "type": "boolean",
            "description": "free to turn about its own axis at the base; default false",
        }
    }

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """Whether it spins."""
        return cls(bool(part.get("spin", False)))

    def check_tip(self, part: Part, holds_orientation: bool) -> None:
        """A rod that spins is held by its tip."""
        if self.spin and not holds_orientation:
            raise part.fail("spin", "nothing would hold the rod against turning about itself")

    def turn_axis(self, base_rotation: NDArray[np.float64]) -> Vector | None:
        """The base tangent, if the rod may spin."""
        return tuple(base_rotation[:, 0].tolist()) if self.spin else None

    @property
    def shift_axis(self) -> Vector | None:
        """Not a direction in the world; the rod grows along itself."""
        return (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Hinge(_AboutAxis):
    """Passive base: turns freely about an axis."""


@dataclass(frozen=True)
class Welded(Motor):
    """Passive base: clamped, no motor."""


#: Motors by the name used in descriptions.
MOTORS: dict[str, type[Motor]] = {
    "revolute": RevoluteMotor,
    "prismatic": Prismatic,
    "extensible": Extensible,
    "hinge": Hinge,
    "welded": Welded,
}
