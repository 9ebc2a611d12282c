# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Errors of the models against continuous rods: Tables I, II, IV, V and Figs. 5 and 11."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpr_core import (
    Equilibrium,
    NoSolution,
    kinemato_statics,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.reference.continuous_equilibrium import ContinuousEquilibrium
from cpr_core.reference.continuous_rods import follow_platform
from cpr_core.reference.finite_differences import (
    follow_finite_differences,
    solve_finite_differences,
)

from .cases import RFRFR, SIX_RFS, Case

__all__ = [
    "AWAY",
    "ELEMENTS",
    "MODES",
    "Errors",
    "InverseErrors",
    "all_errors",
    "angle_errors",
    "finite_difference_errors",
    "inverse_errors_of_rfrfr",
    "inverse_errors_of_six_rfs",
    "inverse_singularity",
    "position_errors",
]

Floats = NDArray[np.float64]

MODES = (3, 4, 5)
ELEMENTS = (50, 100, 500, 1000)
#: Steps of the path from which on a pose is away from the inverse singularity.
AWAY = 1.0


def position_errors(case: Case, modes: int) -> Floats:
    """Position error of Mod. #1 along the path, (51,) [mm]."""
    return _distances(case.modes_path(modes), case.continuous_path())


def angle_errors(case: Case, modes: int) -> Floats:
    """Norm of ``(R1^T R2 - R2^T R1)^v`` along the path, (51,) [deg]."""
    errors = []
    for first, second in zip(case.modes_path(modes), case.continuous_path(), strict=True):
        turn = first.platform_rotation.T @ second.platform_rotation
        skewed = turn - turn.T
        errors.append(np.linalg.norm([skewed[2, 1], skewed[0, 2], skewed[1, 0]]))
    return np.degrees(np.array(errors))


def finite_difference_errors(elements: int) -> Floats:
    """Position error of Mod. #3 along the RFRFR path, (51,) [mm]."""
    start = solve_finite_differences(RFRFR.continuous_home(), elements)
    points = follow_finite_differences(start, RFRFR.path())
    return _distances(points, RFRFR.continuous_path())


def _distances(points: Sequence, exact: Sequence[ContinuousEquilibrium]) -> Floats:
    pairs = zip(points, exact, strict=True)
    return 1e3 * np.array(
        [np.linalg.norm(a.platform_position - b.platform_position) for a, b in pairs]
    )


@dataclass(frozen=True, eq=False)
class InverseErrors:
    """Motor errors of the inverse problem of Mod. #1.

    Attributes:
        errors: Absolute errors, (K, n) [mdeg]; K poses were reached.
        poses: Number of poses asked for.
        indices: Negative eigenvalues of H_r, motors locked, at the poses reached, (K,).
    """

    errors: Floats
    poses: int
    indices: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors along the paths, by modes or elements, and where inverse errors are large.

    Attributes:
        planar: Position errors of Mod. #1, RFRFR [mm].
        straight: Inverse errors on Eq. (54).
        finite: Position errors of Mod. #3, RFRFR [mm].
        spatial: Position errors of Mod. #1, 6-RFS [mm].
        angles: Orientation errors of Mod. #1, 6-RFS [deg].
        inverse: Inverse errors of Table V.
        other_side: The same from the inverse solution of the pose before.
        singular: Signed smallest singular value of the inverse problem at t = 0..50.
        crossing: t of the inverse singularity.
    """

    planar: dict[int, Floats]
    straight: dict[int, InverseErrors]
    finite: dict[int, Floats]
    spatial: dict[int, Floats]
    angles: dict[int, Floats]
    inverse: InverseErrors
    other_side: InverseErrors
    singular: Floats
    crossing: float

    @property
    def away(self) -> NDArray[np.bool_]:
        """Which configurations are away from the inverse singularity, (51,)."""
        return np.abs(np.arange(51) - self.crossing) > AWAY


def inverse_errors_of_rfrfr(modes: int) -> InverseErrors:
    """On the straight platform path of Eq. (54), as far as both models reach."""
    ends = RFRFR.continuous_path()
    first, last = ends[0].platform_position, ends[-1].platform_position
    robot = RFRFR.robot(modes)
    exact, found = ends[0], solve_home(robot)
    errors, indices = [], []
    for t in range(51):
        place = first + (last - first) * t / 50
        try:
            exact = follow_platform(exact, [place])[0]
            found = solve_inverse(robot, place[:2], start=found)
        except NoSolution:
            break
        errors.append(_millidegrees(found, exact))
        indices.append(found.index_locked)
    return InverseErrors(np.array(errors), 51, tuple(indices))


def inverse_errors_of_six_rfs(modes: int = 5) -> tuple[InverseErrors, InverseErrors]:
    """At the poses of Mod. #2 on the motor path.

    Beyond the inverse singularity of the path every pose has two solutions nearby. The first result
    starts each solve from the forward solution of that pose, on the side of the path; the second from
    the inverse solution of the pose before, which stays on the side before the singularity.
    """
    exact = SIX_RFS.continuous_path()
    sides = []
    for of_path in (True, False):
        errors, indices, last = [], [], solve_home(SIX_RFS.robot(modes))
        for guess, wanted in zip(SIX_RFS.modes_path(modes), exact, strict=True):
            pose = [*wanted.platform_position, *wanted.platform_quaternion]
            last = solve_inverse(guess.robot, pose, start=guess if of_path else last)
            errors.append(_millidegrees(last, wanted))
            indices.append(last.index_locked)
        sides.append(InverseErrors(np.array(errors), len(exact), tuple(indices)))
    return sides[0], sides[1]


def _millidegrees(found: Equilibrium, exact: ContinuousEquilibrium) -> Floats:
    return 1e3 * np.degrees(np.abs(found.motors - exact.motors))


def inverse_singularity() -> tuple[Floats, float]:
    """How near the 6-RFS path is to an inverse singularity.

    Returns:
        Smallest singular value of the inverse problem at t = 0..50 (with the sign of the
        determinant), and t where it changes sign.
    """

    def signed(equilibrium: Equilibrium) -> float:
        found = kinemato_statics(equilibrium).singularity("inverse")
        return found.sign * found.smallest

    points = SIX_RFS.modes_path(12)
    values = np.array([signed(point) for point in points])
    (before,) = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    low, high, nearest = float(before), float(before + 1), points[before]
    first, last = SIX_RFS.path()[[0, -1]]
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        nearest = solve_forward(nearest.robot, first + (last - first) * middle / 50, start=nearest)
        if signed(nearest) * values[before] > 0.0:
            low = middle
        else:
            high = middle
    return values, low


def all_errors(step: Callable[[str], None]) -> Errors:
    """All models against continuous rods."""
    step("Table I")
    planar = {modes: position_errors(RFRFR, modes) for modes in MODES}
    straight = {modes: inverse_errors_of_rfrfr(modes) for modes in MODES}
    step("Table II")
    finite = {count: finite_difference_errors(count) for count in ELEMENTS}
    step("Table IV")
    spatial = {modes: position_errors(SIX_RFS, modes) for modes in MODES}
    angles = {modes: angle_errors(SIX_RFS, modes) for modes in MODES}
    step("Table V")
    inverse, other_side = inverse_errors_of_six_rfs()
    singular, crossing = inverse_singularity()
    return Errors(
        planar=planar,
        straight=straight,
        finite=finite,
        spatial=spatial,
        angles=angles,
        inverse=inverse,
        other_side=other_side,
        singular=singular,
        crossing=crossing,
    )
