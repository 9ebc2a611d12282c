# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A leg as a chain from its base towards the platform: joints, rigid links and rods.

Everything is in the frame (d1, d2, d3) that the elements before lead to, all joints at zero. A new joint
that is made of turns and shifts is one class, which reads its own part of a description, and its name in
``CHAIN_JOINTS``. One that moves otherwise, a screw of one coordinate say, is a new kind of
``ChainElement`` besides: a case of the kernels (``leg_kernel``, ``chain_kernel``) and of what numbers
kinds for them (``leg_groups``, ``robot_arrays``). What moves any of them is a ``Drive``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description_part import Described, Part, Vector, triple
from ..description_part import field as described
from ..lie import rotation_exp
from ..rods.rod import Rod, StrainModes
from .chain_element import ChainElement
from .motors import FARTHEST, LEAD, OFFSET, UNDRIVEN, Drive

__all__ = [
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
        drive: What moves it; without a motor it is passive.
        stiffness: Of its spring [N m/rad or N/m].
        rest: Coordinate at which the spring is at rest [rad or m].
        name: In messages, and where home says roughly where a passive joint is.
    """

    axis: Vector
    drive: Drive = UNDRIVEN
    stiffness: float = 0.0
    rest: float = 0.0
    name: str = ""
    fields: ClassVar[Mapping[str, Any]] = {
        "name": _NAME,
        "axis": described("axis", "in the frame before it"),
        **Drive.fields,
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
        drive = Drive.from_description(part, "moves this joint")
        if drive.motor is None:
            stiffness, rest = part.number("stiffness", 0.0), part.number("rest", 0.0)
            return cls(axis, drive, stiffness, rest, name)
        for given in ("stiffness", "rest"):
            if given in part:
                raise part.fail(
                    given,
                    "a motor holds this joint: for its compliance put a passive joint behind it",
                )
        return cls(axis, drive, name=name)

    @property
    def passive(self) -> bool:
        """Whether no motor moves it."""
        return self.drive.motor is None

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
        return replace(self, drive=self.drive.without_limits())

    @classmethod
    def _axis(cls, part: Part) -> Floats:
        raise NotImplementedError


@dataclass(frozen=True)
class Turn(ChainJoint):
    """Turns all behind it about its axis."""

    kind = "turn"
    unit = "rad"
    shown_kind = "revolute"
    adds_point = False

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
    """Shifts all behind it along its axis."""

    kind = "shift"
    unit = "m"
    shown_kind = "prismatic"
    fields: ClassVar[Mapping[str, Any]] = {**ChainJoint.fields, "lead": LEAD}

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
        drive: What feeds it; without a motor its length is fixed.
    """

    rod: Rod
    modes: StrainModes
    drive: Drive = UNDRIVEN
    kind = "rod"
    unit = "m"
    shown_kind = "feed"
    fields: ClassVar[Mapping[str, Any]] = {
        "rod": described("chain_rod", "what it is made of"),
        "strain": described("strain", "its modes; fields left out are the leg's or the robot's"),
        **Drive.fields,
        "motor": described("name", "the motor that feeds it; default fixed length"),
        "limits": described("limits", "what that motor can do; default unlimited"),
        "offset": OFFSET | {"description": "its length with that motor at zero [m]; default 0"},
        "lead": LEAD,
    }

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
        unbreakable = replace(self.rod, yield_strain=math.inf)
        return replace(self, drive=self.drive.without_limits(), rod=unbreakable)

    def with_modes(self, changed: Callable[[StrainModes], StrainModes]) -> Self:
        """The same rod with other strain modes."""
        return replace(self, modes=changed(self.modes))
