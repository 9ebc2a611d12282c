# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One leg: a chain from its base to the joint at its tip, and the motors that move it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description_part import Vector, triple
from ..lie import rotation_exp
from ..rods.rod import Rod, StrainModes
from ..validation import cached_property
from .chain import ChainJoint, ChainRod, Shift, Turn
from .chain_element import ChainElement
from .joints import Joint
from .motors import NO_LIMITS, UNDRIVEN, Drive, Motor, MotorLimits

__all__ = ["BasePose", "DescribedMotor", "LegDescription", "described_motors"]

Floats = NDArray[np.float64]


class BasePose(NamedTuple):
    """Base of a rod in the world.

    Attributes:
        rotation: Base frame (d1, d2, d3 as columns), (3, 3).
        position: Base point, (3,) [m].
        length: Length of the rod from there on [m].
    """

    rotation: Floats
    position: Floats
    length: float


@dataclass(frozen=True)
class DescribedMotor:
    """A motor of a robot.

    Attributes:
        name: In messages.
        unit: Of its position.
        limits: What it can do.
        moves: Unit of the joint or rod that it moves: metres, where it turns a screw.
        ratio: How far that joint goes when it goes one; of several the one that goes farthest.
    """

    name: str
    unit: Literal["rad", "m", ""]
    limits: MotorLimits
    moves: Literal["rad", "m", ""]
    ratio: float

    @property
    def effort_unit(self) -> str:
        """Unit of its effort."""
        return "N m" if self.unit == "rad" else "N"


@dataclass(frozen=True, eq=False, repr=False)
class LegDescription:
    """One leg.

    Attributes:
        name: Name of the leg.
        rod: The rod; of a chain what its rods are where they do not say otherwise.
        modes: Its strain modes.
        base_position: Base point in the world, all joints at zero, (3,) [m].
        base_rotation: Base frame (d1, d2, d3 as columns) in the world, all joints at zero, (3, 3).
        motor: What holds the base; that of a chain is welded.
        joint: What holds the tip.
        drive: What moves the base or feeds the rod, in place of that of a chain.
        elements: A chain in place of motor and rod.
    """

    name: str
    rod: Rod
    modes: StrainModes
    base_position: Floats
    base_rotation: Floats
    motor: Motor
    joint: Joint
    drive: Drive = UNDRIVEN
    elements: tuple[ChainElement, ...] | None = None

    def __repr__(self) -> str:
        parts = (type(part).__name__ for part in (self.motor, self.rod.section, self.joint))
        return f"<LegDescription {self.name}: {', '.join(parts)}>"

    @cached_property
    def chain(self) -> tuple[ChainElement, ...]:
        """From base to tip: the joints of the motor, and the rod."""
        if self.elements is not None:
            return self.elements
        turn, shift = self.motor.turn_axis(self.base_rotation), self.motor.shift_axis
        joints: list[ChainElement] = []
        if turn is not None:
            joints.append(self._joint(Turn, turn, self.motor.actuated == "turn"))
        if shift is not None and not self.motor.extensible:
            joints.append(self._joint(Shift, shift, self.motor.actuated == "shift"))
        fed = self.drive if self.motor.extensible else UNDRIVEN
        return (*joints, ChainRod(self.rod, self.modes, fed))

    def _joint(self, kind: type[ChainJoint], axis: Vector, moved: bool) -> ChainJoint:
        """The joint of the motor about or along an axis in the world, or a passive one."""
        drive = self.drive if moved else UNDRIVEN
        return kind(triple(self.base_rotation.T @ axis), drive, name=f"{self.name}.joint1")

    def without_limits(self) -> LegDescription:
        """The same leg with motors that can do everything and rods that bear everything."""
        elements = self.elements and tuple(element.without_limits() for element in self.elements)
        rod = replace(self.rod, yield_strain=math.inf)
        return replace(self, drive=self.drive.without_limits(), rod=rod, elements=elements)

    def with_modes(self, changed: Callable[[StrainModes], StrainModes]) -> LegDescription:
        """The same leg with other strain modes of its rods."""
        if self.elements is None:
            return replace(self, modes=changed(self.modes))
        return replace(self, elements=tuple(part.with_modes(changed) for part in self.elements))

    def with_modes_of(self, leg: LegDescription) -> LegDescription:
        """The same leg with the strain modes of another one that has the same chain.

        One of the two may be written as a chain, for a gear behind its motor, and the other not.
        """
        if self.elements is None:
            return replace(self, modes=leg.rods[0].modes)
        elements = tuple(
            replace(element, modes=other.modes)
            if isinstance(element, ChainRod) and isinstance(other, ChainRod)
            else element
            for element, other in zip(self.elements, leg.chain, strict=True)
        )
        return replace(self, modes=leg.modes, elements=elements)

    def rod_frame(self, motors: Mapping[str, float], joints: Mapping[str, float]) -> Floats:
        """Frame in the world where the first rod begins, (3, 3).

        Args:
            motors: Motor positions by name [rad or m].
            joints: Passive joints by name [rad or m]; those left out are where their springs rest.
        """
        rotation = self.base_rotation
        for element in self.chain:
            if isinstance(element, ChainRod):
                break
            at = 0.0
            if isinstance(element, ChainJoint):
                passive = joints.get(element.name, element.rest)
                at = passive if element.motor is None else motors[element.motor]
            rotation, _ = element.behind(rotation, self.base_position, at)
        return rotation

    @cached_property
    def rods(self) -> tuple[ChainRod, ...]:
        """The rods of the chain."""
        return tuple(element for element in self.chain if isinstance(element, ChainRod))

    @property
    def rod_length(self) -> float:
        """Length of its rods together, as described [m]."""
        return float(sum(element.rod.length for element in self.rods))

    @property
    def longest_rod(self) -> float:
        """Length of the longest of them, as described [m]; of a leg without any, what it would have."""
        return max((element.rod.length for element in self.rods), default=self.rod.length)

    def rod_rigidity(self, planar: bool) -> float:
        """E J of one uniform rod as long as its rods and as soft [N m^2], see ``Rod.mean_rigidity``."""
        first, *others = (element.rod for element in self.rods)
        if not others:
            return first.mean_rigidity(planar)
        softness = sum(rod.length / rod.mean_rigidity(planar) for rod in (first, *others))
        return self.rod_length / float(softness)

    @property
    def rod_names(self) -> tuple[str, ...]:
        """Names of the rods: the leg's, or numbered where it has several."""
        if len(self.rods) == 1:
            return (self.name,)
        return tuple(f"{self.name}.rod{number + 1}" for number in range(len(self.rods)))

    @cached_property
    def joints(self) -> tuple[ChainJoint, ...]:
        """The joints of the chain, with motors and passive."""
        return tuple(element for element in self.chain if isinstance(element, ChainJoint))

    def base_pose(self, turn: float = 0.0, shift: float = 0.0) -> BasePose:
        """Base with its coordinates, be they the motor's or passive; the kernels keep to this.

        Args:
            turn: About the turn axis of the motor [rad]; without effect where it has none.
            shift: Along its shift axis, or the length of the rod if the leg is extensible [m].
        """
        rotation, position, length = self.base_rotation, self.base_position, self.rod.length
        turn_axis, shift_axis = self.motor.turn_axis(rotation), self.motor.shift_axis
        if turn_axis is not None:
            rotation = rotation_exp(turn * np.array(turn_axis)) @ rotation
        if self.motor.extensible:
            length = float(shift)
        elif shift_axis is not None:
            position = position + shift * np.array(shift_axis)
        return BasePose(rotation, position, length)

    def base_at(self, motor: float) -> BasePose:
        """Base at a motor position [rad or m], a passive coordinate at zero."""
        way = self.drive.zero + motor
        return (
            self.base_pose(turn=way) if self.motor.actuated == "turn" else self.base_pose(0.0, way)
        )


def described_motors(legs: Sequence[LegDescription]) -> tuple[DescribedMotor, ...]:
    """The motors of legs in order; one may move joints of several legs."""
    moved: dict[str, list[ChainElement]] = {}
    for leg in legs:
        for element in leg.chain:
            if element.motor is not None:
                moved.setdefault(element.motor, []).append(element)
    return tuple(_described_motor(name, elements) for name, elements in moved.items())


def _described_motor(name: str, elements: Sequence[ChainElement]) -> DescribedMotor:
    """What moves these elements; limits may be said at any of them."""
    farthest = max(elements, key=lambda element: abs(element.ratio))
    limits = (element.limits for element in elements if element.limits != NO_LIMITS)
    return DescribedMotor(
        name,
        farthest.motor_unit,
        next(limits, NO_LIMITS),
        moves=farthest.unit,
        ratio=farthest.ratio,
    )
