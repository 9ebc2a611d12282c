# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour of an equilibrium, computed once: smallest eigenvalues, platform matrices."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.kernel_arrays import Lanes, LoadArrays
from ..kernels.prepared_robot import evaluate_record, linearise_prepared
from ..validation import read_only
from .robot import Robot

__all__ = [
    "Linearisation",
    "Response",
    "condensed_margin",
    "linearised",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Response:
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


def condensed_margin(
    robot: Robot, factors: Lanes, load_arrays: LoadArrays, record: Floats
) -> float:
    """The margin alone; arguments as of ``linearised``."""
    eigenvalues, _ = _found(robot, factors, load_arrays, record, False, np.empty((0, 0)))
    return eigenvalues[0]


def linearised(
    robot: Robot,
    factors: Lanes,
    load_arrays: LoadArrays,
    record: Floats,
    margin: float | None = None,
) -> Linearisation:
    """First-order behaviour at an equilibrium.

    Args:
        robot: The robot.
        factors: Its condensed tangent there, as the kernels keep it.
        load_arrays: The loads as the kernels see them.
        record: The solution as the kernels keep it.
        margin: The margin, where it was told before.
    """
    size = len(robot.arrays.border_indices)
    matrix = np.empty((size, size))
    (own, locked, free), answered = _found(robot, factors, load_arrays, record, True, matrix)
    response = Response(read_only(matrix), robot.motor_count) if answered else None
    return Linearisation(own if margin is None else margin, locked, free, response)


def _found(
    robot: Robot,
    factors: Lanes,
    load_arrays: LoadArrays,
    record: Floats,
    all_of_it: bool,
    matrix: Floats,
) -> tuple[list[float], bool]:
    """Results of ``linearise``, from the factors, or from the tangent where these tell too little."""
    eigenvalues, prepared = np.empty(3), robot.prepared
    asked, results = (factors, record, all_of_it), (eigenvalues, matrix)
    known, answered = linearise_prepared(prepared, *asked, False, *results)
    if not known or math.isnan(eigenvalues[0]):
        evaluate_record(prepared, load_arrays, record)
        _, answered = linearise_prepared(prepared, *asked, True, *results)
    return eigenvalues.tolist(), answered
