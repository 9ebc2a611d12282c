# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""First-order behaviour of an equilibrium, computed once: smallest eigenvalues, platform matrices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.kernel_arrays import Lanes
from ..kernels.linearisation_kernel import HELD, REST, linearise
from ..validation import read_only
from .robot import Robot

__all__ = [
    "HeldEigenvalues",
    "Linearisation",
    "Response",
    "held_eigenvalues_of",
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


class HeldEigenvalues(NamedTuple):
    """Smallest eigenvalues of H_r with the motors held; NaN: not found this way, see Linearisation.

    Attributes:
        smallest: On motions of unit size [J].
        margin: Relative to the elastic stiffness.
    """

    smallest: float
    margin: float


class Linearisation(NamedTuple):
    """Found from the legs condensed onto platform and motors.

    Legs that cannot be condensed (straight ones) and motions without stiffness are beyond this method:
    NaN and None then send to the dense one.

    Attributes:
        held: With the motors held.
        smallest_free: Smallest eigenvalue of H_r with the motors free [J]; NaN: not found this way.
        response: None: not found this way.
    """

    held: HeldEigenvalues
    smallest_free: float
    response: Response | None


def held_eigenvalues_of(robot: Robot, factors: Lanes, record: Floats) -> HeldEigenvalues:
    """Stability of an equilibrium with the motors held; arguments as of ``linearised``."""
    eigenvalues = np.empty(3)
    linearise(robot.prepared, factors, record, HELD, eigenvalues, np.empty((0, 0)))
    return HeldEigenvalues(*eigenvalues[:2].tolist())


def linearised(
    robot: Robot, factors: Lanes, record: Floats, held: HeldEigenvalues | None = None
) -> Linearisation:
    """First-order behaviour at an equilibrium.

    Args:
        robot: The robot.
        factors: Its condensed tangent there, as the kernels keep it.
        record: The solution as the kernels keep it.
        held: What is known with the motors held; None: nothing yet.
    """
    size = len(robot.arrays.border_indices)
    eigenvalues, matrix = np.empty(3), np.empty((size, size))
    asked = HELD | REST if held is None else REST
    found = linearise(robot.prepared, factors, record, asked, eigenvalues, matrix)
    smallest, margin, free = eigenvalues.tolist()
    response = Response(read_only(matrix), robot.motor_count) if found else None
    return Linearisation(held or HeldEigenvalues(smallest, margin), free, response)
