# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Index of an equilibrium of continuous rods, and the conjugate points it is made of, for any robot.

Cut every leg at the same fraction u of the length of its rods and clamp it there: the index of what lies
beyond falls as u goes from the base to the tip, by one at every conjugate point (Morse).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import optimize

from ..blas_threads import on_one_blas_thread
from ..errors import InvalidRequest
from .chain_robot import chain_robot
from .chain_steps import ChainStep, node_cuts
from .continuous_equilibrium import ContinuousEquilibrium
from .rod_integration import RodTrajectory
from .second_variation import PartTooLong, SecondVariation, second_variation

__all__ = ["MorseIndex", "energy_form", "index_beyond", "index_falls", "morse_index"]

#: Turn of the curvature and wave number times length of the longest part of a rod, tried first.
_LONGEST = 1.0
#: Tip parts shorter than this are not looked at: rods so short do not buckle, and where they hold a
#: platform more than once over what they yield drowns in rounding.
_SHORTEST = 0.05
#: How well conjugate points are located.
_LOCATED = 1e-9


class MorseIndex(NamedTuple):
    """Numbers of negative directions of the energy: motors held in position, or at constant effort."""

    locked: int
    free: int


@on_one_blas_thread
def morse_index(solution: ContinuousEquilibrium) -> MorseIndex:
    """Stability of continuous rods in both readings of the motors.

    Args:
        solution: An equilibrium of any robot.

    Raises:
        InvalidRequest: A load without potential: then there is no energy to have an index.
    """
    form = energy_form(solution)
    return MorseIndex(form.index(motors_free=False), form.index(motors_free=True))


@on_one_blas_thread
def index_beyond(solution: ContinuousEquilibrium, u: float) -> int:
    """Index of what lies beyond a section of all legs, clamped there, motors locked.

    Args:
        solution: An equilibrium of any robot.
        u: The section, a fraction of the length of the rods of every leg, at most 0.95. Joints and links
            before the first rod are at 0, those behind the last one at 1.

    Raises:
        InvalidRequest: A load without potential, or another section.
    """
    if not 0.0 <= u <= 1.0 - _SHORTEST:
        raise InvalidRequest("u", f"expected a section from 0 to {1.0 - _SHORTEST:g}, got {u}")
    return energy_form(solution, u).index(motors_free=False)


def energy_form(solution: ContinuousEquilibrium, u: float = 0.0) -> SecondVariation:
    """Second variation of the energy of what lies beyond a section of all legs, clamped there.

    Args:
        solution: An equilibrium of any robot.
        u: The section, as ``index_beyond`` takes it.

    Raises:
        InvalidRequest: A load without potential.
    """
    robot, loads = solution.robot, solution.loads
    if not robot.has_potential(loads):
        raise InvalidRequest("loads", "expected loads that have a potential")
    legs = [
        [step for step in steps if step.trajectory is not None] for steps in solution.balance.legs
    ]
    lengths = [[step.trajectory.part_length for step in parts if step.trajectory] for parts in legs]
    sections = u * np.array([sum(parts) for parts in lengths])
    longest = _LONGEST
    while True:
        cuts = node_cuts(solution.nodes)
        for parts, section in zip(legs, sections, strict=True):
            for rod, own in _cuts(parts, section, longest).items():
                cuts[rod] = [*cuts.get(rod, ()), *own]
        model = chain_robot(robot, loads, solution.method, cuts)
        try:
            return second_variation(model, solution.point, sections)
        except PartTooLong:
            longest *= 0.5


def _cuts(parts: list[ChainStep], section: float, longest: float) -> dict[int, list[float]]:
    """Where the rods of a leg are cut: s/l by number of the rod."""
    rods: dict[int, list[RodTrajectory]] = {}
    for step in parts:
        if step.rod is not None and step.trajectory is not None:
            rods.setdefault(step.rod, []).append(step.trajectory)
    cuts, before = {}, 0.0
    for number, rod in rods.items():
        states, length = np.vstack([part.states for part in rod]), rod[0].length
        compliance = max(float(part.tables.compliance.max()) for part in rod)
        curved = compliance * np.linalg.norm(states[:, 12:15], axis=1).max()
        waves = np.sqrt(compliance * np.linalg.norm(states[:, 15:18], axis=1).max())
        count = max(1, int(np.ceil(max(curved, waves) * length / longest)))
        at = (section - before) / length
        inside = [at] if 0.0 < at < 1.0 else []
        cuts[number] = [*(np.arange(1, count) / count).tolist(), *inside]
        before += length
    return cuts


@on_one_blas_thread
def index_falls(solution: ContinuousEquilibrium) -> tuple[float, ...]:
    """Sections from 0 to 1 where the index of what lies beyond falls, each as often as it falls by one.

    Those at 1 are of what lies behind the last rods, or of a platform that its joints do not hold.

    Args:
        solution: An equilibrium of any robot.

    Raises:
        InvalidRequest: A load without potential.
    """

    def between(low: float, high: float, at_low: int, at_high: int) -> list[float]:
        if at_low == at_high:
            return []
        if at_low - at_high == 1:
            return [optimize.brentq(_more_than(solution, at_high), low, high, xtol=_LOCATED)]
        if high - low < _LOCATED:
            return [0.5 * (low + high)] * (at_low - at_high)
        middle = 0.5 * (low + high)
        at_middle = index_beyond(solution, middle)
        return between(low, middle, at_low, at_middle) + between(middle, high, at_middle, at_high)

    last = 1.0 - _SHORTEST
    ends = [index_beyond(solution, u) for u in (0.0, last)]
    return (*between(0.0, last, *ends), *[1.0] * ends[1])


def _more_than(solution: ContinuousEquilibrium, count: int) -> Callable[[float], float]:
    """Of a section: negative where the index of what lies beyond is larger than a count."""
    return lambda u: energy_form(solution, u).beyond(count, motors_free=False)
