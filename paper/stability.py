# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Eigenvalues of H_r and conjugate points along lines in the workspace: Figs. 6-8 and 12-14."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from cpr_core import Equilibrium, solve_home, solve_inverse
from cpr_core.reference.conjugate_points import conjugate_points, robot_fields
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.workspace import WorkspaceMap, map_workspace, pose_grid

from .cases import RFRFR, SIX_RFS, SLICE, Case, slice_pose

__all__ = ["Crossing", "Line", "Sample", "line_of", "sample", "workspace_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sample:
    """Stability at one point of a line.

    Attributes:
        value: Coordinate along the line [m].
        eigenvalues: The two smallest of H_r, motors locked [J].
        index: Number of negative ones.
        conjugate: Conjugate points u in (0, 1) of the continuous rods.
        at_base: det b(0), dimensionless.
        sections: u where the determinant was computed.
        determinants: det b(u) there.
    """

    value: float
    eigenvalues: Floats
    index: int
    conjugate: tuple[float, ...]
    at_base: float
    sections: Floats = field(repr=False)
    determinants: Floats = field(repr=False)


@dataclass(frozen=True)
class Crossing:
    """Where one more eigenvalue becomes negative, and where a conjugate point appears.

    Attributes:
        order: 0 for the smallest eigenvalue, 1 for the second.
        eigenvalue: Coordinate of the zero of the eigenvalue [m].
        conjugate: Coordinate where a conjugate point enters at u = 0 [m].
        before: Conjugate points just before.
        after: Conjugate points just after.
        five_modes: Coordinate of the zero with 5 modes, as in the paper [m].
    """

    order: int
    eigenvalue: float
    conjugate: float
    before: int
    after: int
    five_modes: float


@dataclass(frozen=True, eq=False)
class Line:
    """A line of the paper's stability studies.

    Attributes:
        axis: Name of the coordinate along it.
        samples: Its points.
        crossings: Where stability changes.
        marked: Samples at X_1, X_2, ..., in the order of the line.
        places: (x, y) of those [m].
    """

    axis: str
    samples: tuple[Sample, ...]
    crossings: tuple[Crossing, ...]
    marked: tuple[Sample, ...]
    places: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class _Study:
    """A line in the workspace: its robot, its coordinate and the ends of it, and what is asked there."""

    case: Case
    axis: str
    ends: tuple[float, float]
    place: Callable[[float], tuple[float, float]]
    pose: Callable[[float, float], ArrayLike]


_STUDIES = {
    "rfrfr": _Study(RFRFR, "y", (0.8, -0.2), lambda y: (0.0, y), lambda x, y: (x, y)),
    "six_rfs": _Study(SIX_RFS, "y", (0.0, 0.2), lambda y: (-0.4, y), slice_pose),
}


def sample(equilibrium: Equilibrium, value: float, sections: int = 200) -> Sample:
    """Both tests of stability at an equilibrium."""
    spectrum = equilibrium.spectrum_locked
    fields = robot_fields(solve_continuous(equilibrium, "pose"))
    at = np.linspace(0.0, 1.0, sections, endpoint=False)
    determinants = fields.determinants(at)
    return Sample(
        value=value,
        eigenvalues=spectrum.eigenvalues[:2],
        index=spectrum.index,
        conjugate=conjugate_points(fields),
        at_base=float(determinants[0]),
        sections=at,
        determinants=determinants,
    )


def line_of(name: str, modes: int, points: int, progress: Callable[[], object]) -> Line:
    """The line X_1 to X_5 of the RFRFR robot, or X_1 to X_3 of the 6-RFS robot."""
    study = _STUDIES[name]
    values = np.linspace(*study.ends, points)
    equilibria = _follow(study, modes, values)
    samples = []
    for value, equilibrium in zip(values, equilibria, strict=True):
        samples.append(sample(equilibrium, float(value)))
        progress()
    crossings = []
    indices = [point.index for point in samples]
    coarse = _follow(study, 5, values)
    for order in range(max(indices)):
        after = next(k for k, index in enumerate(indices) if index > order)
        crossings.append(_crossing(study, order, equilibria[after - 1], values, after, coarse))
    marks = [float(values[0])]
    for number, crossing in enumerate(crossings):
        marks.append(crossing.eigenvalue)
        ahead = crossings[number + 1].eigenvalue if number + 1 < len(crossings) else values[-1]
        last = number + 1 == len(crossings)
        marks.append(float(values[-1]) if last else 0.5 * (crossing.eigenvalue + float(ahead)))
    marked = []
    for mark in marks:
        near = equilibria[int(np.abs(values - mark).argmin())]
        marked.append(sample(_at(study, near, mark), mark))
    return Line(
        axis=study.axis,
        samples=tuple(samples),
        crossings=tuple(crossings),
        marked=tuple(marked),
        places=tuple(study.place(mark) for mark in marks),
    )


def _at(study: _Study, start: Equilibrium, value: float) -> Equilibrium:
    return solve_inverse(start.robot, study.pose(*study.place(value)), start=start)


def _follow(study: _Study, modes: int, values: Floats) -> list[Equilibrium]:
    last = solve_home(study.case.robot(modes))
    points = []
    for value in values:
        last = _at(study, last, float(value))
        points.append(last)
    return points


def _crossing(
    study: _Study,
    order: int,
    before: Equilibrium,
    values: Floats,
    after: int,
    coarse: list[Equilibrium],
) -> Crossing:
    low, high = float(values[after - 1]), float(values[after])

    def eigenvalue(value: float) -> float:
        return float(_at(study, before, value).spectrum_locked.eigenvalues[order])

    def at_base(value: float) -> float:
        return robot_fields(solve_continuous(_at(study, before, value), "pose")).determinant(0.0)

    def points(value: float) -> int:
        return len(conjugate_points(solve_continuous(_at(study, before, value), "pose")))

    conjugate = float(brentq(at_base, low, high, xtol=1e-9))
    side = 1e-5 * float(np.sign(high - low))
    five = [float(point.spectrum_locked.eigenvalues[order]) for point in coarse]
    first = next(k for k in range(1, len(five)) if five[k] < 0.0)

    def with_five_modes(value: float) -> float:
        return float(_at(study, coarse[first - 1], value).spectrum_locked.eigenvalues[order])

    return Crossing(
        order=order,
        eigenvalue=float(brentq(eigenvalue, low, high, xtol=1e-9)),
        conjugate=conjugate,
        before=points(conjugate - side),
        after=points(conjugate + side),
        five_modes=float(
            brentq(with_five_modes, float(values[first - 1]), float(values[first]), xtol=1e-9)
        ),
    )


def workspace_of(name: str, modes: int, spacing: float) -> WorkspaceMap:
    """Map of the workspace of the RFRFR robot, or of the slice of the 6-RFS robot."""
    study = _STUDIES[name]
    robot = study.case.robot(modes)
    if name == "rfrfr":
        axes, held = {"x": (-0.9, 0.9), "y": (-1.1, 1.1)}, {}
    else:
        axes, held = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}, SLICE
    start = _at(study, solve_home(robot), study.ends[0])
    return map_workspace(robot, pose_grid(robot, axes, held, resolution=spacing), start=start)
