# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Units that make the linear problems of Section V-C dimensionless, for any characteristic length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..kernels.square_problem import ProblemScales
from ..kernels.twist_layout import FIRST_LINEAR
from ..validation import checked_number
from .robot import Robot
from .state_numbers import RodNumbers

__all__ = ["ProblemUnits", "problem_units"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Cosine of the angle between two modes of a rod below which they are orthogonal: rounding is.
_ORTHOGONAL = 1e-12


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

    @property
    def motions(self) -> Floats:
        """Unit motions as columns, strains by their L2 norm along the rod, in state order, (N, N)."""
        return self.robot.unit_motions * (self.states / self.robot.kernel_arrays.unit)

    def scales(self, unknowns: NDArray[np.int64], equations: NDArray[np.int64]) -> ProblemScales:
        """The natural units of a problem as parts of these, strains by their L2 norm along the rod.

        Args:
            unknowns: State indices beside those of the legs.
            equations: State indices beside those of the legs.
        """
        robot, arrays = self.robot, self.robot.kernel_arrays
        norms, oblique = _mode_norms(robot)
        states, energy = norms * arrays.unit / self.states, self.energy / arrays.energy_unit
        legs = np.arange(arrays.platform_index)
        efforts = 1.0 / (states[robot.motor_indices] * energy)
        solved = states.copy()
        solved[robot.multiplier_indices] = 0.0
        balanced = states[np.concatenate([legs, equations, robot.motor_indices])] * energy
        columns = solved[np.concatenate([legs, unknowns])]
        columns = np.concatenate([columns, efforts])
        return ProblemScales(columns, balanced**2, *_gram_factors(robot, oblique))


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
            f"expected a length between {1e-6 * natural:g} and {1e6 * natural:g} m, got {length}",
        )
    return _units(robot, length / natural)


def _mode_norms(robot: Robot) -> tuple[Floats, list[RodNumbers]]:
    """Norms of the modes of a rod in state order, (N,), and the rods whose modes are not orthogonal.

    They are 1 of those rods and of all that is no strain.
    """
    norms, oblique = np.ones(robot.state_size), []
    for rod in robot.numbers.rods:
        gram = robot.strain_grams[rod.strain, rod.strain]
        own = np.sqrt(gram.diagonal())
        cosines = gram / np.outer(own, own)
        if np.abs(cosines - np.eye(len(own))).max(initial=0.0) < _ORTHOGONAL:
            norms[rod.strain] = own
        else:
            oblique.append(rod)
    return norms, oblique


def _gram_factors(robot: Robot, rods: list[RodNumbers]) -> tuple[Integers, Integers, Floats]:
    """First strain coordinates, how many, and the Cholesky factors of the gram matrices."""
    counts = np.array([rod.element.modes.total for rod in rods], np.int64)
    most = counts.max(initial=0)
    factors = np.zeros((len(rods), most, most))
    for rod, count, factor in zip(rods, counts, factors, strict=True):
        gram = robot.strain_grams[rod.strain, rod.strain]
        factor[:count, :count] = np.linalg.cholesky(gram)
    return np.array([rod.strain.start for rod in rods], np.int64), counts, factors


def _units(robot: Robot, ratio: float) -> ProblemUnits:
    """For a length that is so many natural ones."""
    arrays = robot.kernel_arrays
    unit = arrays.unit.copy()
    shifts: set[int] = set()  # a motor may be in several legs
    for leg, chain in zip(robot.numbers.legs, robot.description.legs, strict=True):
        unit[leg.strain] /= ratio
        unit[leg.forces] /= ratio**2
        unit[leg.moments] /= ratio
        moved = zip(leg.coordinates, chain.chain, strict=True)
        shifts |= {i for i, element in moved if i is not None and element.unit == "m"}
    unit[sorted(shifts)] *= ratio
    unit[robot.platform_indices[robot.platform_axes >= FIRST_LINEAR]] *= ratio
    return ProblemUnits(robot, unit, arrays.energy_unit / ratio)
