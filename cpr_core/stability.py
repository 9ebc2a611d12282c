"""Elastic stability: the spectrum of the reduced Hessian H_r = Z^T H Z, Eqs. (47)-(52)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from .equilibrium import Equilibrium
from .model import tangent_at

__all__ = ["MotorReading", "Spectrum", "null_space_of", "spectrum"]

Floats = NDArray[np.float64]

#: How the motors are read: held in position, or giving a constant effort.
MotorReading = Literal["locked", "free"]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Spectrum of H_r on an orthonormal basis of the admissible motions.

    Motions are dimensionless (``Robot.unit_motions``), so the eigenvalues are energies and depend
    neither on units nor on the strain basis.

    Attributes:
        motors_are: Reading of the motors.
        eigenvalues: All eigenvalues, ascending [J].
        motions: Their eigenvectors as motions of the whole robot, columns in state order, (N, ...):
            motors [rad, m], platform in the world [rad, m], leg coordinates [1/m]; rows of
            multipliers are zero.
        margin: Smallest eigenvalue of H_r relative to the elastic stiffness on the same motions,
            ``min v^T H_r v / v^T K_r v``, dimensionless: 1 without loads and forces, 0 where stability
            is lost, more than 1 under tension. NaN where some motion costs no elastic energy (possible
            with free motors); infinite where the constraints leave nothing to move.
        energy_criterion_applies: False where a non-conservative load acts.
    """

    motors_are: MotorReading
    eigenvalues: Floats
    motions: Floats
    margin: float
    energy_criterion_applies: bool

    @property
    def index(self) -> int:
        """Number of negative eigenvalues; those that vanish to rounding are not counted."""
        sizes = np.abs(self.eigenvalues)
        return int(np.sum(self.eigenvalues < -1e-11 * sizes.max(initial=0.0)))

    @property
    def smallest(self) -> float:
        """Smallest eigenvalue [J]; infinite where the constraints leave nothing to move."""
        return float(self.eigenvalues.min(initial=np.inf))

    @property
    def inverse_condition_number(self) -> float:
        """Smallest over largest absolute eigenvalue, as in Figs. 6 and 12."""
        sizes = np.abs(self.eigenvalues)
        return float(sizes.min() / sizes.max()) if len(sizes) else 1.0


def spectrum(equilibrium: Equilibrium, motors_are: MotorReading = "locked") -> Spectrum:
    """Spectrum of H_r at an equilibrium.

    Args:
        equilibrium: Where.
        motors_are: ``locked`` (motors held, the reading behind the paper's case studies) or ``free``
            (motors at constant effort, Eq. (48) literally).
    """
    robot = equilibrium.robot
    moving = np.concatenate([robot.elastic_indices, robot.platform_indices])
    if motors_are == "free":
        moving = np.concatenate([moving, robot.motor_indices])
    motions = robot.unit_motions[np.ix_(moving, moving)]
    tangent = tangent_at(equilibrium)
    constraints = tangent[np.ix_(robot.multiplier_indices, moving)] @ motions
    null_space = motions @ null_space_of(constraints)
    hessian = tangent[np.ix_(moving, moving)]
    reduced = null_space.T @ (0.5 * (hessian + hessian.T)) @ null_space
    eigenvalues, directions = np.linalg.eigh(reduced)  # takes an empty one as well
    whole = np.zeros((len(tangent), len(eigenvalues)))
    whole[moving] = null_space @ directions
    return Spectrum(
        motors_are=motors_are,
        eigenvalues=eigenvalues,
        motions=whole,
        margin=_margin(equilibrium, moving, null_space, reduced),
        energy_criterion_applies=equilibrium.loads.conservative(robot.planar),
    )


def null_space_of(matrix: Floats) -> Floats:
    """Orthonormal basis of the null space of a wide matrix, as columns."""
    orthogonal, triangular, _ = linalg.qr(matrix.T, pivoting=True)
    diagonal = np.abs(np.diag(triangular))
    return orthogonal[:, int(np.sum(diagonal > 1e-12 * diagonal[0])) :]


def _margin(
    equilibrium: Equilibrium, moving: NDArray[np.int64], null_space: Floats, reduced: Floats
) -> float:
    elastic = _elastic_hessian(equilibrium)
    projected = null_space.T @ elastic[np.ix_(moving, moving)] @ null_space
    if not len(projected):
        return float("inf")
    smallest = linalg.eigvalsh(projected, subset_by_index=[0, 0])[0]
    if smallest <= 1e-12 * np.trace(projected):
        return float("nan")
    return float(linalg.eigvalsh(reduced, projected, subset_by_index=[0, 0])[0])


def _elastic_hessian(equilibrium: Equilibrium) -> Floats:
    """Second derivative of the elastic energy ``l0/l q^T K q / 2`` by the state, (N, N)."""
    arrays, state = equilibrium.robot.arrays, equilibrium.state
    elastic = np.zeros((len(state), len(state)))
    for leg, stiffness in zip(arrays.legs, arrays.stiffness, strict=True):
        count, first, shift = leg["strain_count"], leg["strain_index"], leg["translation_index"]
        here = slice(first, first + count)
        elastic[here, here] = stiffness[:count, :count]
        if leg["extensible"]:
            length, strain = state[shift], state[here]
            couple = stiffness[:count, :count] @ strain
            ratio = leg["length"] / length
            elastic[here, here] *= ratio
            elastic[here, shift] = elastic[shift, here] = -ratio / length * couple
            elastic[shift, shift] = ratio / length**2 * couple @ strain
    return elastic
