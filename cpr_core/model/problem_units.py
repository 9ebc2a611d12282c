# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Units that make the linear problems of Section V-C dimensionless, for any characteristic length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..kernels.square_problem import ProblemScales
from ..validation import checked_number
from .robot import Robot

__all__ = ["ProblemUnits", "problem_units"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ProblemUnits:
    """Units of the states and of energy.

    Attributes:
        robot: The robot.
        states: Units in state order, (N,).
        energy: [J].
    """

    robot: Robot
    states: Floats
    energy: float

    def scales(self, unknowns: NDArray[np.int64], equations: NDArray[np.int64]) -> ProblemScales:
        """The natural units of a problem as parts of these.

        Args:
            unknowns: State indices beside those of the legs.
            equations: State indices beside those of the legs.
        """
        robot, arrays = self.robot, self.robot.arrays
        states, energy = arrays.unit / self.states, self.energy / arrays.energy_unit
        legs = np.arange(arrays.platform_index)
        efforts = 1.0 / (states[robot.motor_indices] * energy)
        solved = states.copy()
        solved[robot.multiplier_indices] = 0.0
        balanced = states[np.concatenate([legs, equations, robot.motor_indices])] * energy
        columns = solved[np.concatenate([legs, unknowns])]
        return ProblemScales(np.concatenate([columns, efforts]), balanced**2)


def problem_units(robot: Robot, characteristic_length: float | None) -> ProblemUnits:
    """Rotations count in radians, lengths in the characteristic length, strains in its inverse.

    Args:
        robot: The robot.
        characteristic_length: [m]; None: the mean rod length.

    Raises:
        InvalidRequest: No such length.
    """
    length = natural = robot.mean_length
    if characteristic_length is not None:
        length = checked_number("characteristic_length", characteristic_length)
    if not 1e-6 * natural <= length <= 1e6 * natural:
        raise InvalidRequest(
            "characteristic_length",
            f"expected a length between {1e-6 * natural:g} and {1e6 * natural:g} m, got {length:g}",
        )
    return _units(robot, length / natural)


def _units(robot: Robot, ratio: float) -> ProblemUnits:
    """For a length that is so many natural ones."""
    arrays = robot.arrays
    unit = arrays.unit.copy()
    shifts: set[int] = set()  # a motor may be in several legs
    for leg, chain in zip(robot.numbers.legs, robot.description.legs, strict=True):
        unit[leg.strain] /= ratio
        unit[leg.forces] /= ratio**2
        unit[leg.moments] /= ratio
        moved = zip(leg.coordinates, chain.chain, strict=True)
        shifts |= {i for i, element in moved if i is not None and element.unit == "m"}
    unit[sorted(shifts)] *= ratio
    unit[robot.platform_indices[robot.platform_axes >= 3]] *= ratio
    return ProblemUnits(robot, unit, arrays.energy_unit / ratio)
