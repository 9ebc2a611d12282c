# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Another program's answer beside ours, and what is demanded of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .cases import Case, OurSolve

__all__ = ["Comparison", "Requirement", "compared", "requirements_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """What a program says of a case.

    Attributes:
        case: The case.
        program: Its name and version.
        setting: Elements, and how the limit was taken.
        start: Where its own solve began.
        distance_as_is: Of its platform from ours with the stiffness of the real rods [m].
        distance: The same in its limit [m].
        efforts: Difference of the efforts in its limit, relative to the largest effort.
        seconds: Its time, all solves of the limit together.
        ours: Ours, as accurate and in the same run.
        why: Why the rest of the difference is there.
    """

    case: Case
    program: str
    setting: str
    start: str
    distance_as_is: float
    distance: float
    efforts: float
    seconds: float
    ours: OurSolve
    why: str

    @property
    def ratio(self) -> float:
        """Its time over ours."""
        return self.seconds / self.ours.seconds


class FromBentLegs(Protocol):
    """What a forward solve from bent legs has found, with finer and finer pieces."""

    @property
    def finest(self) -> Floats:
        """Position [m] and efforts with the finest, (3 + n,)."""

    @property
    def limit(self) -> Floats:
        """The same in the limit, (3 + n,)."""

    @property
    def seconds(self) -> float:
        """Time for all of it."""

    @property
    def forward_seconds(self) -> float:
        """Of this, from bent legs to the first equilibrium."""


def compared(case: Case, program: str, setting: str, found: FromBentLegs, why: str) -> Comparison:
    """A program's answer from bent legs beside ours.

    Args:
        case: The case.
        program: Its name and version.
        setting: Pieces, and how the limit was taken.
        found: Its answer.
        why: Why the rest of the difference is there.
    """
    distance = case.distance(found.limit[:3])
    return Comparison(
        case=case,
        program=program,
        setting=setting,
        start=f"bent legs, {found.forward_seconds:.2g} s to the first equilibrium",
        distance_as_is=case.distance(found.finest[:3]),
        distance=distance,
        efforts=case.effort_difference(found.limit[3:]),
        seconds=found.seconds,
        ours=case.as_accurate_as(distance),
        why=why,
    )


@dataclass(frozen=True)
class Requirement:
    """A bound and what was measured.

    Attributes:
        name: What is demanded.
        measured: The figure.
        bound: It has to be smaller.
        unit: Of both.
    """

    name: str
    measured: float
    bound: float
    unit: str

    @property
    def met(self) -> bool:
        """Whether it is; a NaN is not."""
        return self.measured < self.bound


def requirements_of(
    comparison: Comparison, position_bound: float, effort_bound: float
) -> tuple[Requirement, Requirement]:
    """The bounds of a comparison.

    Args:
        comparison: What was measured.
        position_bound: How far the platform may be from ours [m].
        effort_bound: The same of efforts, relative to the largest one.
    """
    name = f"{comparison.program.split()[0]}, {comparison.case.name}"
    return (
        Requirement(f"{name}: position", comparison.distance, position_bound, "m"),
        Requirement(f"{name}: efforts", comparison.efforts, effort_bound, "of the largest"),
    )
