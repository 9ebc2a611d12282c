# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where everything is in the state of a robot, and what it is measured in.

For every leg its passive joints, its strain coordinates rod by rod, and its multipliers; then the
platform; then the motors. In this order the tangent is block-arrow shaped.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.chain import ChainRod
from ..description.leg_description import LegDescription
from ..description.robot_description import RobotDescription
from ..kernels.twist_layout import FIRST_LINEAR
from ..rods.rod import StrainModes
from ..validation import cached_property
from .platform_coordinates import PlatformCoordinates

__all__ = ["AlikeRods", "LegNumbers", "RodNumbers", "StateNumbers", "state_numbers"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class RodNumbers:
    """A rod in the state.

    Attributes:
        leg: Number of its leg.
        element: The rod in its chain.
        strain: Strain coordinates.
        length_index: State index of the motor that feeds it; None: its length is fixed.
    """

    leg: int
    element: ChainRod
    strain: slice
    length_index: int | None

    def stretch(self, states: Floats) -> Floats:
        """Length over nominal length, (...), in states (..., N)."""
        return self.length(states) / self.element.rod.length

    def length(self, states: Floats) -> Floats:
        """Length, (...) [m], in states (..., N)."""
        if self.length_index is None:
            return np.full(states.shape[:-1], self.element.rod.length)
        return np.asarray(self.element.length_at(states[..., self.length_index]))


@dataclass(frozen=True, eq=False)
class AlikeRods:
    """Rods of equal modes.

    Attributes:
        modes: Their modes.
        numbers: Which rods of the robot they are, (R,).
        strain: State indices of their strain coordinates, (R, m).
    """

    modes: StrainModes
    numbers: Integers
    strain: Integers


@dataclass(frozen=True, eq=False)
class LegNumbers:
    """A leg in the state.

    Attributes:
        coordinates: For every element of the chain the state index of what moves it: the coordinate of
            a joint, of the motor that feeds a rod; None: nothing.
        strain: Strain coordinates of all rods.
        rods: The rods.
        forces: Multipliers that hold the position of the tip.
        moments: Multipliers that hold its orientation.
    """

    coordinates: tuple[int | None, ...]
    strain: slice
    rods: tuple[RodNumbers, ...]
    forces: slice
    moments: slice


@dataclass(frozen=True, eq=False)
class StateNumbers:
    """All of the state.

    Attributes:
        legs: The legs.
        unit: Natural unit of every state: dimensionless = state / unit, (N,).
        energy_unit: Natural unit of energy, E J / l [J].
        platform_index: State index of the first platform coordinate.
        motor_index: State index of the first motor.
    """

    legs: tuple[LegNumbers, ...]
    unit: Floats
    energy_unit: float
    platform_index: int
    motor_index: int

    @property
    def rods(self) -> Iterator[RodNumbers]:
        """The rods of all legs."""
        for leg in self.legs:
            yield from leg.rods

    @cached_property
    def alike_rods(self) -> tuple[AlikeRods, ...]:
        """The same by their modes."""
        rods, alike = list(self.rods), dict[Hashable, list[int]]()
        for number, rod in enumerate(rods):
            alike.setdefault(rod.element.modes.identity, []).append(number)
        states = np.arange(len(self.unit))
        return tuple(
            AlikeRods(
                rods[numbers[0]].element.modes,
                np.array(numbers),
                np.array([states[rods[number].strain] for number in numbers]),
            )
            for numbers in alike.values()
        )


def state_numbers(description: RobotDescription, coordinates: PlatformCoordinates) -> StateNumbers:
    """Number the state of a robot.

    Args:
        description: The robot.
        coordinates: Motions of its platform.
    """
    legs, length_unit = description.legs, description.mean_length
    energy_unit = description.mean_rigidity / length_unit
    held = 2 if description.planar else 3
    unit: list[float] = []

    def take(count: int, natural: float) -> slice:
        unit.extend([natural] * count)
        return slice(len(unit) - count, len(unit))

    numbered = []
    for leg in legs:
        passive = {
            position: take(1, element.natural_unit(length_unit)).start
            for position, element in enumerate(leg.chain)
            if element.passive
        }
        # By length, l int kappa^2 ds: a rod in two pieces has the same natural motions.
        strains = [
            take(element.modes.total, 1.0 / math.sqrt(length_unit * element.rod.length))
            for element in leg.rods
        ]
        forces = take(held, energy_unit / length_unit)
        moments = take(len(leg.joint.orientation(description.planar)), energy_unit)
        numbered.append((passive, strains, forces, moments))
    platform_index = len(unit)
    for axis in coordinates.axes:
        take(1, 1.0 if axis < FIRST_LINEAR else length_unit)
    motor_index = len(unit)
    motors: dict[str, int] = {}
    for leg in legs:
        for element in leg.chain:
            if element.motor is not None:
                natural = element.natural_unit(length_unit)
                index = motors.setdefault(element.motor, len(unit))
                if index == len(unit):
                    unit.append(natural)
                unit[index] = min(unit[index], natural)  # of the joint that goes farthest
    return StateNumbers(
        legs=tuple(
            _leg_numbers(number, leg, *numbers, motors)
            for number, (leg, numbers) in enumerate(zip(legs, numbered, strict=True))
        ),
        unit=np.array(unit),
        energy_unit=energy_unit,
        platform_index=platform_index,
        motor_index=motor_index,
    )


def _leg_numbers(
    number: int,
    leg: LegDescription,
    passive: dict[int, int],
    strains: list[slice],
    forces: slice,
    moments: slice,
    motors: dict[str, int],
) -> LegNumbers:
    coordinates = tuple(
        passive[position] if position in passive else motors.get(element.motor or "")
        for position, element in enumerate(leg.chain)
    )
    fed = [
        index
        for index, element in zip(coordinates, leg.chain, strict=True)
        if element.kind == "rod"
    ]
    return LegNumbers(
        coordinates=coordinates,
        strain=slice(strains[0].start, strains[-1].stop)
        if strains
        else slice(forces.start, forces.start),
        rods=tuple(
            RodNumbers(number, element, strain, index)
            for element, strain, index in zip(leg.rods, strains, fed, strict=True)
        ),
        forces=forces,
        moments=moments,
    )
