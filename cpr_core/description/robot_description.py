# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a robot is made of: immutable values, whatever file they come from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description_part import triple
from ..errors import InvalidRequest
from ..lie import rotation_exp, skew
from ..rods.rod import Rod, StrainModes
from ..validation import checked_count
from . import joints, motors
from .chain import ChainElement, ChainJoint, ChainRod, Link, Shift, Turn
from .loads import Loads
from .motors import MotorLimits

__all__ = [
    "CONTROLLED_COORDINATES",
    "BasePose",
    "DescribedMotor",
    "HomeGuess",
    "LegDescription",
    "RobotDescription",
    "described_motors",
]

Floats = NDArray[np.float64]

#: Number of scalars of every controllable platform coordinate.
CONTROLLED_COORDINATES = {
    "x": 1,
    "y": 1,
    "z": 1,
    "angle": 1,
    "orientation": 3,
    "roll": 1,
    "pitch": 1,
    "yaw": 1,
}


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
        feeds_rod: Whether its position is the length of a rod.
    """

    name: str
    unit: str
    limits: MotorLimits
    feeds_rod: bool

    @property
    def effort_unit(self) -> str:
        """Unit of its effort."""
        return "N m" if self.unit == "rad" else "N"


@dataclass(frozen=True, eq=False, repr=False)
class LegDescription:
    """One leg.

    Attributes:
        name: Name of the leg.
        motor_name: Name of its motor in messages; None for a passive base.
        rod: The rod; of a chain what its rods are where they do not say otherwise.
        modes: Its strain modes.
        base_position: Base point in the world at motor zero, (3,) [m].
        base_rotation: Base frame (d1, d2, d3 as columns) in the world at motor zero, (3, 3).
        motor: What holds the base; that of a chain is welded.
        joint: What holds the tip.
        limits: What the motor can do.
        elements: A chain in place of motor and rod.
    """

    name: str
    motor_name: str | None
    rod: Rod
    modes: StrainModes
    base_position: Floats
    base_rotation: Floats
    motor: motors.Motor
    joint: joints.Joint
    limits: motors.MotorLimits = field(default_factory=motors.MotorLimits)
    elements: tuple[ChainElement, ...] | None = None

    def __repr__(self) -> str:
        parts = (type(part).__name__ for part in (self.motor, self.rod.section, self.joint))
        return f"<LegDescription {self.name}: {', '.join(parts)}>"

    @cached_property
    def chain(self) -> tuple[ChainElement, ...]:
        """From base to tip: the joints of the motor, and the rod."""
        if self.elements is not None:
            return self.elements
        across = self.base_rotation.T
        turn, shift = self.motor.turn_axis(self.base_rotation), self.motor.shift_axis
        turned, shifted = (
            self.motor_name if self.motor.actuated == kind else None for kind in ("turn", "shift")
        )
        joints: list[ChainElement] = []
        if turn is not None:
            joints.append(Turn(triple(across @ turn), turned, limits=self.limits))
        if shift is not None and not self.motor.extensible:
            joints.append(Shift(triple(across @ shift), shifted, limits=self.limits))
        fed = self.motor_name if self.motor.extensible else None
        return (*joints, ChainRod(self.rod, self.modes, fed, self.limits))

    def without_limits(self) -> LegDescription:
        """The same leg with motors that can do everything and rods that bear everything."""
        elements = None
        if self.elements is not None:
            elements = tuple(
                replace(element, limits=MotorLimits())
                if isinstance(element, ChainJoint)
                else replace(element, limits=MotorLimits(), rod=_unbreakable(element.rod))
                if isinstance(element, ChainRod)
                else element
                for element in self.elements
            )
        return replace(self, limits=MotorLimits(), rod=_unbreakable(self.rod), elements=elements)

    def with_modes(self, modes: int) -> LegDescription:
        """The same leg with another number of modes in every direction that has any."""
        elements = None
        if self.elements is not None:
            elements = tuple(
                replace(element, modes=_with_modes(element.modes, modes))
                if isinstance(element, ChainRod)
                else element
                for element in self.elements
            )
        return replace(self, modes=_with_modes(self.modes, modes), elements=elements)

    def rod_frame(self, motors: Mapping[str, float]) -> Floats:
        """Frame in the world where the first rod begins, (3, 3), passive joints at zero.

        Args:
            motors: Motor positions by name [rad or m].
        """
        rotation = self.base_rotation
        for element in self.chain:
            if isinstance(element, ChainRod):
                break
            if isinstance(element, Link):
                rotation = rotation @ element.rotation
            elif isinstance(element, Turn):
                turn = element.zero
                if element.motor is not None:
                    turn += element.ratio * motors[element.motor]
                rotation = rotation @ rotation_exp(turn * np.array(element.axis))
        return rotation

    @cached_property
    def rods(self) -> tuple[ChainRod, ...]:
        """The rods of the chain."""
        return tuple(element for element in self.chain if isinstance(element, ChainRod))

    def base_pose(self, turn: float = 0.0, shift: float = 0.0) -> BasePose:
        """Base with its coordinates, be they the motor's or passive; the kernels keep to this.

        Args:
            turn: About the turn axis of the motor [rad]; without effect where it has none.
            shift: Along its shift axis, or the length of the rod if the leg is extensible [m].
        """
        rotation, position, length = self.base_rotation, self.base_position, self.rod.length
        turn_axis, shift_axis = self.motor.turn_axis(rotation), self.motor.shift_axis
        if turn_axis is not None:
            across = skew(turn_axis)
            turned = np.eye(3) + np.sin(turn) * across + (1.0 - np.cos(turn)) * across @ across
            rotation = turned @ rotation
        if self.motor.extensible:
            length = float(shift)
        elif shift_axis is not None:
            position = position + shift * np.array(shift_axis)
        return BasePose(rotation, position, length)

    def base_at(self, motor: float) -> BasePose:
        """Base at a motor position [rad or m], a passive coordinate at zero."""
        if self.motor.actuated == "turn":
            return self.base_pose(turn=motor)
        return self.base_pose(shift=motor)


@dataclass(frozen=True, eq=False)
class HomeGuess:
    """What is known of the home equilibrium; the rest is found by assembling the robot.

    Attributes:
        motors: Motor positions, (n,); these are exact.
        platform_position: Roughly, (3,) [m]; None: not known.
        platform_rotation: Roughly, (3, 3).
        strain: For every leg and every strain component Legendre coefficients of the curvature [1/m]
            without loads: close enough for Newton's method. None: not known.
        bow: For every leg the side to which its middle stands out, a vector in the world, (3,); None
            where it is not known.
    """

    motors: Floats
    platform_position: Floats | None
    platform_rotation: Floats
    strain: tuple[tuple[Floats, Floats, Floats], ...] | None
    bow: tuple[Floats | None, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class RobotDescription:
    """A whole robot, as its file says.

    Attributes:
        name: Name of the robot.
        source: Where the description came from.
        planar: Whether the robot lives in the plane z = 0.
        point_platform: Whether the platform has no orientation (planar only).
        platform_mass: [kg].
        center_of_mass: Of the platform in its frame, (3,) [m].
        legs: The legs.
        controlled: Platform coordinates of the inverse problem, in order; none if there are more
            motors than platform coordinates.
        home: Rough home equilibrium.
        loads: Loads that always act, gravity included.
        stations: s/l where point forces may act, on every leg.
        text: The description as it was read.
    """

    name: str
    source: str
    planar: bool
    point_platform: bool
    platform_mass: float
    center_of_mass: Floats
    legs: tuple[LegDescription, ...]
    controlled: tuple[str, ...]
    home: HomeGuess
    loads: Loads = field(default_factory=Loads.none)
    stations: tuple[float, ...] = ()
    text: str = ""

    def __repr__(self) -> str:
        return (
            f"<RobotDescription {self.name} from {self.source}: "
            f"{'planar' if self.planar else 'spatial'}, {len(self.legs)} legs, "
            f"controlled {' '.join(self.controlled) or 'nothing'}>"
        )

    @property
    def platform_freedom(self) -> int:
        """Number of platform coordinates."""
        if self.planar:
            return 2 if self.point_platform else 3
        return 6

    @property
    def mean_length(self) -> float:
        """Mean (nominal) rod length, the natural unit of length [m]."""
        return float(np.mean([element.rod.length for leg in self.legs for element in leg.rods]))

    @property
    def gravity(self) -> Floats:
        """Gravity in the world, (3,) [m/s^2]."""
        return self.loads.gravity

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors in order."""
        return tuple(motor.name for motor in self.motors)

    @cached_property
    def motors(self) -> tuple[DescribedMotor, ...]:
        """The motors in order; one may move joints of several legs."""
        return described_motors(self.legs)

    def with_modes(self, modes: int) -> RobotDescription:
        """The same robot with another number of modes in every direction that has any."""
        modes = checked_count("modes", modes, 1)
        rods = [element for leg in self.legs for element in leg.rods]
        if any(getattr(element.modes.basis, "modes", None) is not None for element in rods):
            raise InvalidRequest(
                "modes", "B-splines have as many modes as degree and knots say: change those"
            )
        return replace(self, legs=tuple(leg.with_modes(modes) for leg in self.legs))


def described_motors(legs: Sequence[LegDescription]) -> tuple[DescribedMotor, ...]:
    """The motors of legs in order; one may move joints of several legs."""
    found: dict[str, DescribedMotor] = {}
    for leg in legs:
        for element in leg.chain:
            if isinstance(element, Link) or element.motor is None:
                continue
            feeds = isinstance(element, ChainRod)
            motor = DescribedMotor(element.motor, element.unit, element.limits, feeds)
            if found.setdefault(motor.name, motor).limits == MotorLimits():
                found[motor.name] = motor  # limits may be said at any of its joints
    return tuple(found.values())


def _with_modes(given: StrainModes, modes: int) -> StrainModes:
    torsion, bending_2, bending_3 = (modes if count else 0 for count in given.counts)
    return replace(given, counts=(torsion, bending_2, bending_3))


def _unbreakable(rod: Rod) -> Rod:
    return replace(rod, yield_strain=math.inf)
