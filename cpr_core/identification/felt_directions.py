# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which wrenches measurements tell apart, and how well: the singular values of what they answer by.

Wrenches are counted in natural units, moments in E J / l and forces in E J / l^2: a load of 1 bends the
rods far. A direction is felt where its standard deviation is below that, and not lost in rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..kernels.twist_layout import ANGULAR
from ..model.platform_coordinates import six_components
from ..model.robot import Robot
from ..model.world_response import WorldResponse
from ..validation import ReadOnlyArrays, cached_array
from .wrench_measurements import WrenchMeasurements

__all__ = ["FeltDirections", "felt_directions"]

Floats = NDArray[np.float64]

#: Standard deviation of what is not felt, in natural units: as good as infinite, and a number.
_UNFELT = 1e3
#: Largest standard deviation of what is felt, in natural units.
_LARGEST_DEVIATION = 1.0
#: Smallest answer to a wrench, of the largest, that is more than rounding.
_ROUNDING = 1e-9
#: Part of an axis, squared, that counts as all of it; what is left of one counts as none.
_WHOLE = 0.99
_NAMES = [f"a {part} {axis}" for part in ("moment about", "force along") for axis in "xyz"]


@dataclass(frozen=True, eq=False)
class FeltDirections(ReadOnlyArrays):
    """Directions of wrenches in world axes and natural units, the best felt first; b coordinates.

    Attributes:
        response: First-order behaviour at the equilibrium they are felt at.
        directions: Orthonormal columns, (b, b).
        answers: What a wrench of 1 along each changes, in standard deviations of measurements, (b,).
        count: How many of them are felt.
        gain: Wrench in natural units by residual, (b, M).
        residuals: What those that are felt change in the residual, orthonormal columns, (M, f).
    """

    response: WorldResponse
    directions: Floats
    answers: Floats
    count: int
    gain: Floats
    residuals: Floats

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self.response.equilibrium.robot

    @property
    def observability(self) -> float:
        """Smallest over largest answer of all platform coordinates, in [0, 1]; 0: not all are felt."""
        whole = self.count == len(self.answers) and self.answers[0] > 0.0
        return float(self.answers[-1] / self.answers[0]) if whole else 0.0

    @cached_array
    def felt(self) -> Floats:
        """World wrenches that are felt, the best first, as rows, (f, 6) [N m, N]."""
        return self._rows(slice(None, self.count))

    @cached_array
    def unfelt(self) -> Floats:
        """World wrenches that are not felt, as rows, (b - f, 6) [N m, N]."""
        return self._rows(slice(self.count, None))

    @cached_array
    def covariance(self) -> Floats:
        """Covariance of the wrench in the world, (6, 6); what is not felt is as good as infinite."""
        axes, units = self.robot.platform_axes, self.robot.wrench_units
        deviations = np.full(len(axes), _UNFELT)
        deviations[: self.count] = 1.0 / self.answers[: self.count]
        within = self.directions * deviations
        # Of a planar robot those out of its plane are not felt either.
        covariance = np.diag(np.full(6, _UNFELT**2))
        covariance[np.ix_(axes, axes)] = within @ within.T
        return np.asarray(covariance * units[:, None] * units)

    def step(self, wrench: Floats, residual: Floats) -> Floats:
        """The next wrench in natural units, (b,): nothing of it along what is not felt."""
        step = self.gain @ residual
        if self.count == len(self.answers):
            return np.asarray(wrench + step)
        felt = self.directions[:, : self.count]
        return np.asarray(felt @ (felt.T @ wrench) + step)

    def left_over(self, residual: Floats) -> Floats:
        """What the next step leaves of a residual, to first order, (M,)."""
        return np.asarray(residual - self.residuals @ (self.residuals.T @ residual))

    @property
    def words(self) -> str:
        """What is not felt, in words."""
        axes = self.robot.platform_axes
        unfelt = self.directions[:, self.count :]
        if not unfelt.shape[1]:
            return "all of the wrench is felt"
        shares = np.sum(unfelt**2, axis=1)
        whole = [_NAMES[axis] for axis, part in zip(axes, shares, strict=True) if part > _WHOLE]
        mixed = [
            _NAMES[axis]
            for axis, part in zip(axes, shares, strict=True)
            if 1.0 - _WHOLE <= part <= _WHOLE
        ]
        lines = [f"{name} is not felt" for name in whole]
        more = unfelt.shape[1] - len(whole)
        if mixed and more > 0:
            ways = (
                "one way of combining them is"
                if more == 1
                else f"{more} ways of combining them are"
            )
            lines.append(f"{_listed(mixed)} are not felt separately: {ways} not felt")
        return "; ".join(lines)

    def _rows(self, part: slice) -> Floats:
        """Directions as world wrenches of 1 N, moments counted over the mean rod length."""
        rows = six_components(self.robot.platform_axes, self.directions[:, part]).T
        rows[:, ANGULAR] *= self.robot.mean_length
        return rows


def felt_directions(
    measurements: WrenchMeasurements, response: WorldResponse, count: int | None = None
) -> FeltDirections:
    """What measurements tell of a wrench at an equilibrium.

    Args:
        measurements: Measured numbers.
        response: First-order behaviour at the equilibrium.
        count: How many directions are felt; None: that is to be found.
    """
    answers = measurements.by_wrench(response)
    size = answers.shape[1]
    fewer = len(answers) < size  # than coordinates: some directions are no answer at all
    left, values, right, _ = scipy.linalg.lapack.dgesdd(answers, full_matrices=fewer)
    if fewer:
        values = np.concatenate([values, np.zeros(size - len(values))])
    if count is None:
        threshold = max(1.0 / _LARGEST_DEVIATION, _ROUNDING * values[0])
        count = sum(value > threshold for value in values.tolist())
    gain = (right[:count].T / values[:count]) @ left[:, :count].T
    return FeltDirections(response, right.T, values, count, gain, left[:, :count])


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
