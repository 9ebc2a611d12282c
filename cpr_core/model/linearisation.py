# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour of an equilibrium, computed once: smallest eigenvalues, platform matrices."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.kernel_arrays import Lanes
from ..kernels.linearisation_kernel import MARGIN
from ..kernels.prepared_robot import evaluate_record, linearise_prepared
from ..validation import ReadOnlyArrays, cached_property
from .model_state import ModelState

__all__ = [
    "Linearisation",
    "LinearisedState",
    "Response",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Response(ReadOnlyArrays):
    """How platform and efforts answer to motors and wrench; body twists and wrenches.

    Attributes:
        matrix: Platform twist, then efforts, by motors, then wrench, (platform + n, n + platform).
        motor_count: n.
    """

    matrix: Floats
    motor_count: int

    @property
    def jacobian(self) -> Floats:
        """Platform Jacobian ``dSigma_p/dq_a``, (platform, n)."""
        return self.matrix[: self._platform, : self.motor_count]

    @property
    def platform_by_wrench(self) -> Floats:
        """``dSigma_p/dw_p``, motors held, (platform, platform)."""
        return self.matrix[: self._platform, self.motor_count :]

    @property
    def efforts_by_motors(self) -> Floats:
        """``dtau_a/dq_a``, (n, n)."""
        return self.matrix[self._platform :, : self.motor_count]

    @property
    def efforts_by_wrench(self) -> Floats:
        """``dtau_a/dw_p``, motors held, (n, platform)."""
        return self.matrix[self._platform :, self.motor_count :]

    @property
    def _platform(self) -> int:
        return len(self.matrix) - self.motor_count


class Linearisation(NamedTuple):
    """Found from the legs condensed onto platform and motors.

    Motions without stiffness are beyond this method, and so are legs of which more cannot be eliminated
    than what holds their tip: NaN and None then send to the dense one.

    Attributes:
        margin: Smallest eigenvalue of H_r with the motors held, relative to the elastic stiffness.
        smallest_locked: Smallest eigenvalue of H_r with the motors held, on motions of unit size [J].
        smallest_free: The same with the motors free [J].
        response: How platform and efforts answer.
    """

    margin: float
    smallest_locked: float
    smallest_free: float
    response: Response | None


@dataclass(frozen=True, eq=False)
class LinearisedState(ModelState):
    """An equilibrium with its condensed tangent, and what follows to first order, once it is asked for.

    Attributes:
        factors: The condensed tangent, as the kernels keep it.
    """

    factors: Lanes

    @cached_property
    def condensed_margin(self) -> float:
        """The margin from the condensed legs, before anything else is asked for; NaN: not found so."""
        known = self.__dict__.get("linearisation")
        return (
            known.margin if known is not None else self._found(False, np.empty((0, 0)))[0][MARGIN]
        )

    @cached_property
    def linearisation(self) -> Linearisation:
        """Margin, smallest eigenvalues, and how platform and efforts answer to motors and wrench."""
        size = len(self.robot.kernel_arrays.border_indices)
        known = self.__dict__.get("condensed_margin")
        matrix = np.empty((size, size))
        (margin, locked, free), answered = self._found(True, matrix)
        response = Response(matrix, self.robot.motor_count) if answered else None
        return Linearisation(margin if known is None else known, locked, free, response)

    def _found(self, all_of_it: bool, matrix: Floats) -> tuple[list[float], bool]:
        """Results of ``linearise``: from the factors, or the tangent where these tell too little."""
        eigenvalues, prepared = np.empty(3), self.robot.prepared
        asked, results = (self.factors, self.record, all_of_it), (eigenvalues, matrix)
        known, answered = linearise_prepared(prepared, *asked, False, *results)
        if not known or math.isnan(eigenvalues[MARGIN]):
            evaluate_record(prepared, self.load_arrays, self.record)
            _, answered = linearise_prepared(prepared, *asked, True, *results)
        return eigenvalues.tolist(), answered
