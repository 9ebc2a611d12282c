# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a calibration found, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..validation import ReadOnlyArrays, cached_array, cached_property
from .compared import ComparedRow
from .compared_layout import KINDS
from .number_doubts import HALF_95_PERCENT

__all__ = ["CalibrationResult", "CalibrationWarning"]

Floats = NDArray[np.float64]


class CalibrationWarning(UserWarning):
    """Measurements that can be used, but of which something looks like a mistake."""


@dataclass(frozen=True, eq=False, repr=False)
class CalibrationResult(ReadOnlyArrays):
    """Parameters of a robot from measurements.

    Attributes:
        robot: The robot with the parameters found; ``robot.description.text`` is a file
            that loads, empty where the robot was no text but a mapping.
        parameters: Their paths.
        start: Values of the description, (P,), in SI units.
        values: Values found, (P,), in SI units.
        covariance: Of the values, (P, P); infinite variances, and no covariances, of parameters in
            which something is not determined.
        undetermined: What the measurements do not tell, one line each; it stays as it was.
        doubts: What looks like a mistake in the measurements, and numbers that they hardly tell or that
            end where descriptions do, one line each.
        fit: Root mean square of the weighted residual, per degree of freedom: 1 where the standard
            deviations are right. With a robust loss from the median.
        rows: How every measurement was compared.
        before: Equilibria of the rows with the parameters of the description; a tracker whose numbers
            were to be found is where it fits these.
        after: Equilibria of the rows with the parameters found; where what drives a row has a standard
            deviation, without the noise that it seems to have.
    """

    robot: Robot
    parameters: tuple[str, ...]
    start: Floats
    values: Floats
    covariance: Floats
    undetermined: tuple[str, ...]
    doubts: tuple[str, ...]
    fit: float
    rows: tuple[ComparedRow, ...]
    before: tuple[Equilibrium, ...]
    after: tuple[Equilibrium, ...]

    def __repr__(self) -> str:
        return (
            f"<CalibrationResult of {self.robot.description.name}: "
            f"{len(self.parameters)} parameters from {len(self.rows)} measurements, "
            f"fit {self.fit:.3g}, {len(self.undetermined)} undetermined, {len(self.doubts)} doubts>"
        )

    @cached_array
    def standard_deviations(self) -> Floats:
        """Of the values, (P,); infinite where the measurements do not tell."""
        return np.sqrt(np.diag(self.covariance))

    @cached_array
    def intervals(self) -> Floats:
        """Intervals that hold the truth with a probability of 95 %, (P, 2)."""
        half = HALF_95_PERCENT * self.standard_deviations
        return np.column_stack([self.values - half, self.values + half])

    @cached_array
    def correlations(self) -> Floats:
        """Correlations of the values, (P, P); NaN where a variance is infinite."""
        sizes = self.standard_deviations
        known = np.where(np.isfinite(sizes), sizes, np.nan)
        found: Floats = self.covariance / np.outer(known, known)
        return found

    @cached_property
    def by_path(self) -> dict[str, float]:
        """The values by their paths, as ``Robot.with_parameters`` takes them."""
        return dict(zip(self.parameters, self.values.tolist(), strict=True))

    def differences(self, calibrated: bool = True) -> dict[str, Floats]:
        """Predicted minus measured in SI units, by kind: position, rotation, motors, efforts.

        Args:
            calibrated: With the parameters found, else as in ``before``.
        """
        found: dict[str, list[Floats]] = {kind: [] for kind in KINDS}
        equilibria = self.after if calibrated else self.before
        for row, equilibrium in zip(self.rows, equilibria, strict=True):
            each = (row if calibrated else row.as_measured()).differences(equilibrium)
            for kind, parts in found.items():
                parts.append(each[row.kinds == kind])
        return {
            kind: np.concatenate(parts)
            for kind, parts in found.items()
            if any(part.size for part in parts)
        }
