# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A leg as a chain from its base towards the platform: joints, rigid links and rods.

Everything is in the frame (d1, d2, d3) that the elements before lead to, all joints at zero. A new joint
that is made of turns and shifts is one class, which reads its own part of a description, and its name in
``CHAIN_JOINTS``. One that moves otherwise, a screw of one coordinate say, is a new kind of
``ChainElement`` besides: a case of the kernels (``leg_kernel``, ``chain_kernel``) and of what tells
kinds apart (``leg_groups``, ``robot_arrays``, ``shape``, the URDF of the node).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description_part import Described, Part, Vector, triple
from ..description_part import field as described
from ..lie import rotation_exp
from ..rods.rod import Rod, StrainModes
from .chain_element import ChainElement
from .motors import FARTHEST, LEAD, NO_LIMITS, OFFSET, RATIO, MotorLimits, described_ratio

__all__ = [
    "ChainElement",
    "ChainJoint",
    "ChainRod",
    "DescribedJoint",
    "Link",
    "Shift",
    "Turn",
]

Floats = NDArray[np.float64]

_Number = TypeVar("_Number", float, NDArray[np.float64])

_ORIGIN: Vector = (0.0, 0.0, 0.0)
_NAME = described("name", "default leg and number among its joints, leg1.joint2")
_SPRING = {
    "stiffness": described(
        "not_negative", "of its spring, passive joints only [N m/rad or N/m]; default 0"
    ),
    "rest": FARTHEST
    | {"type": "number", "description": "where the spring is at rest [rad or m]; default 0"},
}


class DescribedJoint(Described):
    """A joint of a chain as descriptions know it; it may stand for several of one coordinate."""

    @classmethod
    def elements(cls, part: Part, name: str) -> tuple[ChainJoint, ...]:
        """The joints its part of a description stands for.

        Args:
            part: The part.
            name: Name of the joint; if it stands for several they are ``name[0]``, ``name[1]``, ...

        Raises:
            DescriptionError: Something a schema cannot say is wrong.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class ChainJoint(DescribedJoint, ChainElement):
    """A joint with one coordinate.

    Attributes:
        axis: Unit axis in the frame before the joint.
        motor: Name of the motor that moves it; None: it is passive.
        ratio: How far the joint goes when its motor goes one.
        zero: Where the joint is with its coordinate at zero [rad or m].
        stiffness: Of its spring [N m/rad or N/m].
        rest: Coordinate at which the spring is at rest [rad or m].
        limits: What the motor can do.
        name: In messages, and where home says roughly where a passive joint is.
    """

    axis: Vector
    motor: str | None = None
    ratio: float = 1.0
    zero: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    limits: MotorLimits = NO_LIMITS
    name: str = ""
    fields: ClassVar[Mapping[str, Any]] = {
        "name": _NAME,
        "axis": described("axis", "in the frame before it"),
        "motor": described("name", "the motor that moves it; default passive"),
        "ratio": RATIO,
        "offset": OFFSET,
        "limits": described("limits", "what the motor can do; default unlimited"),
        **_SPRING,
    }
    required = ("axis",)

    @classmethod
    def elements(cls, part: Part, name: str) -> tuple[ChainJoint, ...]:
        """One joint."""
        return (cls.on_axis(triple(cls._axis(part)), part, name),)

    @classmethod
    def on_axis(cls, axis: Vector, part: Part, name: str) -> Self:
        """A joint with a unit axis in the frame before it; all else as its part of a description says.

        Raises:
            DescriptionError: It has a motor and a spring, or neither and what only one with motor has.
        """
        if "motor" not in part:
            for given in ("ratio", "offset", "limits"):
                if given in part:
                    raise part.fail(given, "no motor moves this joint: give one, or leave it out")
            stiffness, rest = part.number("stiffness", 0.0), part.number("rest", 0.0)
            return cls(axis, stiffness=stiffness, rest=rest, name=name)
        for given in ("stiffness", "rest"):
            if given in part:
                raise part.fail(
                    given,
                    "a motor holds this joint: for its compliance put a passive joint behind it",
                )
        return cls(
            axis,
            str(part.get("motor")),
            described_ratio(part),
            part.number("offset", 0.0),
            limits=MotorLimits.from_description(part.part("limits")),
            name=name,
        )

    def constants(self) -> Mapping[str, ArrayLike]:
        """Axis, zero and spring."""
        return {
            "axis": self.axis,
            "zero": self.zero,
            "stiffness": self.stiffness,
            "rest": self.rest,
        }

    def without_limits(self) -> Self:
        """The same joint with a motor that can do everything."""
        return replace(self, limits=NO_LIMITS)

    @classmethod
    def _axis(cls, part: Part) -> Floats:
        raise NotImplementedError


@dataclass(frozen=True)
class Turn(ChainJoint):
    """Turns all behind it about its axis."""

    kind = "turn"
    unit = "rad"

    def behind(
        self, rotation: Floats, position: Floats, coordinate: float
    ) -> tuple[Floats, Floats]:
        """Turned."""
        way = self.zero + self.ratio * coordinate
        return rotation @ rotation_exp(way * np.array(self.axis)), position

    @classmethod
    def _axis(cls, part: Part) -> Floats:
        return part.turn_axis("axis")


@dataclass(frozen=True)
class Shift(ChainJoint):
    """Shifts all behind it along its axis.

    Attributes:
        screw: Whether its motor turns, by a screw or a belt.
    """

    screw: bool = False
    kind = "shift"
    unit = "m"
    fields: ClassVar[Mapping[str, Any]] = {**ChainJoint.fields, "lead": LEAD}

    @classmethod
    def on_axis(cls, axis: Vector, part: Part, name: str) -> Self:
        """A joint with a motor that shifts, or turns a screw, or without one."""
        if "lead" in part and "motor" not in part:
            raise part.fail("lead", "no motor moves this joint: give one, or leave it out")
        return replace(super().on_axis(axis, part, name), screw="lead" in part)

    @property
    def motor_unit(self) -> Literal["rad", "m"]:
        """Unit of the position of its motor."""
        return "rad" if self.screw else "m"

    def behind(
        self, rotation: Floats, position: Floats, coordinate: float
    ) -> tuple[Floats, Floats]:
        """Shifted."""
        way = self.zero + self.ratio * coordinate
        return rotation, position + way * rotation @ self.axis

    @classmethod
    def _axis(cls, part: Part) -> Floats:
        return part.shift_axis("axis")


@dataclass(frozen=True, eq=False)
class Link(ChainElement):
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
    kind = "link"
    fields: ClassVar[Mapping[str, Any]] = {
        "link": described("vector", "where it leads, in the frame before it [m]"),
        "tangent": described("axis", "d1 behind it; default as before it"),
        "normal": described("axis", "d2 behind it, in space, beside tangent; default as before it"),
        "mass": described("not_negative", "[kg]; default 0"),
        "center_of_mass": described("vector", "in the frame before it [m]; default its middle"),
    }

    def constants(self) -> Mapping[str, ArrayLike]:
        """Where it leads, and its mass."""
        return {
            "offset": self.offset,
            "rotation": self.rotation,
            "mass": self.mass,
            "center": self.center_of_mass,
        }

    def behind(
        self, rotation: Floats, position: Floats, coordinate: float
    ) -> tuple[Floats, Floats]:
        """At its end."""
        return rotation @ self.rotation, position + rotation @ self.offset

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """A link; its mass is in the middle where nothing else is said."""
        offset = part.vector("link")
        turned = "tangent" in part or "normal" in part
        return cls(
            triple(offset),
            part.frame() if turned else np.eye(3),
            part.number("mass", 0.0),
            triple(part.vector("center_of_mass", (0.5 * offset).tolist())),
        )


@dataclass(frozen=True, eq=False)
class ChainRod(ChainElement):
    """A rod.

    Attributes:
        rod: The rod.
        modes: Its strain modes.
        motor: Name of the motor that feeds it. None: its length is fixed.
        limits: What the motor can do.
        zero: Its length with the motor at zero [m].
        ratio: How much longer it gets when the motor goes one.
        screw: Whether the motor turns, by a screw or a roller.
    """

    rod: Rod
    modes: StrainModes
    motor: str | None = None
    limits: MotorLimits = NO_LIMITS
    zero: float = 0.0
    ratio: float = 1.0
    screw: bool = False
    kind = "rod"
    unit = "m"
    fields: ClassVar[Mapping[str, Any]] = {
        "rod": described("chain_rod", "what it is made of"),
        "strain": described("strain", "its modes; fields left out are the leg's or the robot's"),
        "motor": described("name", "the motor that feeds it; default fixed length"),
        "limits": described("limits", "what that motor can do; default unlimited"),
        "offset": OFFSET | {"description": "its length with that motor at zero [m]; default 0"},
        "ratio": RATIO,
        "lead": LEAD,
    }

    @property
    def motor_unit(self) -> Literal["rad", "m"]:
        """Unit of the position of its motor."""
        return "rad" if self.screw else "m"

    @property
    def uncoils(self) -> tuple[bool, bool, bool]:
        """Directions in which it is curved at rest and fed, and so has to have modes."""
        if self.motor is None:
            return False, False, False
        torsion, bending_2, bending_3 = (bool(np.any(rest)) for rest in self.rod.rest_curvature)
        return torsion, bending_2, bending_3

    def length_at(self, motor: _Number) -> _Number:
        """Its length at a position of the motor that feeds it, or at many of them [m]."""
        return self.zero + self.ratio * motor

    def without_limits(self) -> Self:
        """The same rod, unbreakable, with a motor that can do everything."""
        return replace(self, limits=NO_LIMITS, rod=replace(self.rod, yield_strain=math.inf))

    def with_modes(self, changed: Callable[[StrainModes], StrainModes]) -> Self:
        """The same rod with other strain modes."""
        return replace(self, modes=changed(self.modes))
