# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is asked of all programs: robots at motors, and our answers."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, NotReached, Robot, load_robot, solve_forward
from cpr_core.reference.continuous_equilibrium import ContinuousEquilibrium
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.validation import cached_property

__all__ = ["CASES", "MODES", "Case", "OurSolve"]

Floats = NDArray[np.float64]

#: Strain modes of ours a direction.
MODES = 14
#: Distances below this are rounding, ours or theirs [m].
ROUNDING = 1e-12
ROBOTS = Path(__file__).parent / "robots"


@dataclass(frozen=True)
class OurSolve:
    """A forward solve from nothing but the description.

    Attributes:
        modes: Strain modes a direction.
        distance: Of the platform from continuous rods [m].
        seconds: Wall clock, kernels in the cache.
    """

    modes: int
    distance: float
    seconds: float


@dataclass(frozen=True)
class Case:
    """A forward problem.

    Attributes:
        name: Of the robot.
        motors: Motor positions, (n,) [rad or m].
        position_bound: How far others may be from us [m].
        effort_bound: The same of efforts, relative to the largest one.
        coarse_bound: How far programs of rigid pieces may be from us, both figures.
        damped_bound: How far programs that only move in time may be from us, both figures.
        halvings: How often beams and cables are halved, from eight elements on.
    """

    name: str
    motors: tuple[float, ...]
    position_bound: float
    effort_bound: float
    coarse_bound: float = 1e-6
    damped_bound: float = 1e-7
    halvings: int = 3

    @property
    def file(self) -> str:
        """What the library loads it from."""
        own = ROBOTS / f"{self.name}.yaml"
        return str(own) if own.is_file() else self.name

    def robot(self, modes: int = MODES) -> Robot:
        """The robot, new every time."""
        return load_robot(self.file, modes=modes)

    @cached_property
    def ours(self) -> Equilibrium:
        """Our answer with many modes."""
        return solve_forward(self.robot(), self.motors)

    @cached_property
    def exact(self) -> ContinuousEquilibrium:
        """Continuous rods by shooting: what others are compared with."""
        return solve_continuous(self.ours)

    def distance(self, position: Floats) -> float:
        """Of a platform position from the exact one [m]."""
        return float(np.linalg.norm(position - self.exact.platform_position))

    def effort_difference(self, efforts: Floats) -> float:
        """Of efforts from the exact ones, relative to the largest of them."""
        largest = np.abs(self.exact.efforts).max()
        return float(np.abs(efforts - self.exact.efforts).max() / largest)

    def as_accurate_as(self, distance: float, repeats: int = 5) -> OurSolve:
        """Ours with the fewest modes that are so near the exact platform, timed from the description on.

        Args:
            distance: Of another program [m].
            repeats: Solves; the median counts.
        """
        for modes in range(3, MODES + 1):
            try:
                found = solve_forward(self.robot(modes), self.motors)
            except NotReached:
                continue  # too few to assemble the robot
            if modes == MODES or self.distance(found.platform_position) <= max(distance, ROUNDING):
                break
        samples = []
        for _ in range(repeats):
            begin = time.perf_counter()
            found = solve_forward(self.robot(modes), self.motors)
            samples.append(time.perf_counter() - begin)
        return OurSolve(modes, self.distance(found.platform_position), float(np.median(samples)))


CASES = (
    Case("rfrfr", (2.59, 0.55), 1e-9, 1e-8),
    Case("six_rfs", (5.86, 5.56, 5.86, 5.46, 5.86, 5.26), 1e-7, 1e-6),
    Case("clamped", (0.3, -0.1, 0.15), 1e-6, 1e-6),
    Case("gough_stewart", (0.45, 0.455, 0.46, 0.45, 0.445, 0.45), 1e-7, 1e-5),
    Case("three_rfr_hubs", (0.4, 0.6, 0.3), 1e-8, 1e-6),
    Case("two_rods", (2.3, 0.84), 1e-8, 1e-6),
)
