# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Index of an equilibrium of continuous rods, and the conjugate points it is made of, for any robot.

Cut every leg at the same fraction u of the length of its rods and clamp it there: the index of what lies
beyond falls as u goes from the base to the tip, by one at every conjugate point (Morse).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ..errors import InvalidRequest
from .chain_robot import chain_robot
from .continuous_equilibrium import ContinuousEquilibrium
from .rod_integration import RodTrajectory
from .second_variation import PartTooLong, second_variation

__all__ = ["conjugate_points_of_chains", "index_beyond", "morse_index"]

Floats = NDArray[np.float64]

#: Turn of the curvature and wave number times length of the longest part of a rod, tried first.
_LONGEST = 1.0
#: Eigenvalues smaller than this times the largest are neutral motions: not counted.
_NEUTRAL = 1e-12
#: How well conjugate points are located.
_LOCATED = 1e-9


def morse_index(
    solution: ContinuousEquilibrium, motors_are: Literal["locked", "free"] = "locked"
) -> int:
    """Number of negative directions of the energy of continuous rods.

    Args:
        solution: An equilibrium.
        motors_are: Held in position, or at constant effort.

    Raises:
        InvalidRequest: A load without potential: then there is no energy to have an index.
    """
    return index_beyond(solution, 0.0, motors_are)


def index_beyond(
    solution: ContinuousEquilibrium, u: float, motors_are: Literal["locked", "free"] = "locked"
) -> int:
    """Index of what lies beyond a section of all legs, clamped there.

    Args:
        solution: An equilibrium.
        u: The section, a fraction of the length of the rods of every leg; joints and links before the
            first rod are at 0, those behind the last one at 1.
        motors_are: Held in position, or at constant effort.

    Raises:
        InvalidRequest: A load without potential.
    """
    robot, loads = solution.robot, solution.loads
    if not loads.conservative(robot.planar):
        raise InvalidRequest("loads", "expected loads that have a potential")
    sections = np.array([u * sum(part.part_length for part in rods) for rods in solution.rods])
    longest = _LONGEST
    while True:
        cuts = [
            cut
            for rods, section in zip(solution.rods, sections, strict=True)
            for cut in _cuts(rods, section, longest)
        ]
        model = chain_robot(robot, loads, solution.method, cuts)
        try:
            form = second_variation(
                model, solution.point, sections, motors_free=motors_are == "free"
            )
        except PartTooLong:
            longest *= 0.5
            continue
        values = linalg.eigvalsh(form.matrix)
        return int(np.sum(values < -_NEUTRAL * np.abs(values).max())) - form.multipliers


def _cuts(parts: tuple[RodTrajectory, ...], section: float, longest: float) -> list[list[float]]:
    """Where the rods of a leg are cut: s/l, rod by rod."""
    rods: list[list[RodTrajectory]] = []
    for part in parts:
        if not rods or rods[-1][0].properties is not part.properties:
            rods.append([])
        rods[-1].append(part)
    cuts, before = [], 0.0
    for rod in rods:
        states, length = np.vstack([part.states for part in rod]), rod[0].length
        compliance = max(float(part.tables.compliance.max()) for part in rod)
        curved = compliance * np.linalg.norm(states[:, 12:15], axis=1).max()
        waves = np.sqrt(compliance * np.linalg.norm(states[:, 15:18], axis=1).max())
        count = max(1, int(np.ceil(max(curved, waves) * length / longest)))
        own = (np.arange(1, count) / count).tolist()
        at = (section - before) / length
        cuts.append([*own, at] if 0.0 < at < 1.0 else own)
        before += length
    return cuts


def conjugate_points_of_chains(solution: ContinuousEquilibrium) -> tuple[float, ...]:
    """Conjugate points from 0 to 1, ascending, each as often as the index falls there, motors locked.

    Those at 1 are of what lies behind the last rods, or of the platform between tips that are clamped.

    Args:
        solution: An equilibrium of any robot.

    Raises:
        InvalidRequest: A load without potential.
    """

    def between(low: float, high: float, at_low: int, at_high: int) -> list[float]:
        if at_low == at_high:
            return []
        if high - low < _LOCATED:
            return [0.5 * (low + high)] * (at_low - at_high)
        middle = 0.5 * (low + high)
        at_middle = index_beyond(solution, middle)
        return between(low, middle, at_low, at_middle) + between(middle, high, at_middle, at_high)

    ends = [index_beyond(solution, u) for u in (0.0, 1.0)]
    return (*between(0.0, 1.0, *ends), *[1.0] * ends[1])
