# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Elastic stability: the spectrum of the reduced Hessian H_r = Z^T H Z, Eqs. (47)-(52)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread, on_one_numpy_thread
from ..validation import cached_array, cached_property
from .linearisation import LinearisedState
from .model_state import ModelState

__all__ = ["DEPENDENT", "MotorReading", "Spectrum", "elastic_hessian", "null_space_of"]

Floats = NDArray[np.float64]

#: How the motors are read: held in position, or giving a constant effort.
MotorReading = Literal["locked", "free"]

#: Elastic stiffness below this part of all of it is none.
_NO_ENERGY = 1e-12
#: What is new in a constraint, below this part of the newest, is rounding.
DEPENDENT = 1e-12


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Spectrum of H_r on an orthonormal basis of the admissible motions.

    Motions are dimensionless (``Robot.unit_motions``), so the eigenvalues are energies and depend
    neither on units nor on the strain basis. ``smallest`` and ``margin`` come from the condensed legs;
    the whole spectrum is computed when it is first asked for, which takes longer.

    Attributes:
        motors_are: Reading of the motors.
    """

    motors_are: MotorReading
    _solution: LinearisedState = field(repr=False)

    @property
    def energy_criterion_applies(self) -> bool:
        """Whether energy decides stability: False where a non-conservative load acts."""
        return self._solution.robot.has_potential(self._solution.loads)

    @cached_property
    def smallest(self) -> float:
        """Smallest eigenvalue [J]; infinite where the constraints leave nothing to move."""
        found = self._solution.linearisation
        value = found.smallest_locked if self.motors_are == "locked" else found.smallest_free
        return float(self.eigenvalues.min(initial=np.inf)) if math.isnan(value) else value

    @cached_property
    def margin(self) -> float:
        """Smallest eigenvalue relative to the elastic stiffness, dimensionless.

        ``min v^T H_r v / v^T K_r v``: 1 without loads and forces, 0 where stability is lost, more than 1
        under tension. NaN where some motion costs no elastic energy (of what hangs, or with free
        motors: see ``firm_margin``); infinite where the constraints leave nothing to move.
        """
        value = self._solution.linearisation.margin if self.motors_are == "locked" else math.nan
        return self._dense.margin() if math.isnan(value) else value

    @cached_property
    def firm_margin(self) -> float:
        """The margin; where some motion costs no elastic energy, that of all others, which it follows.

        A platform that hangs by two ball joints, say, swings under its weight. Positive where all is
        stable, minus infinity where such a motion is not.
        """
        return self._dense.firm_margin() if math.isnan(self.margin) else self.margin

    @cached_array
    def eigenvalues(self) -> Floats:
        """All eigenvalues, ascending [J]."""
        return self._dense.eigenvalues()

    @cached_array
    def motions(self) -> Floats:
        """Their eigenvectors as motions of the whole robot, columns in state order, (N, ...).

        Motors [rad, m], platform in the world [rad, m], leg coordinates [1/m]; rows of multipliers are
        zero.
        """
        return self._dense.motions()

    @property
    def softest_motion(self) -> Floats:
        """The motion of the smallest eigenvalue, (N,); zeros where nothing is left to move."""
        return self.motions[:, 0] if len(self.eigenvalues) else np.zeros(len(self.motions))

    @property
    def index(self) -> int:
        """Number of negative eigenvalues; those that vanish to rounding are not counted."""
        sizes = np.abs(self.eigenvalues)
        return int(np.sum(self.eigenvalues < -1e-11 * sizes.max(initial=0.0)))

    @property
    def inverse_condition_number(self) -> float:
        """Smallest over largest absolute eigenvalue, as in Figs. 6 and 12."""
        sizes = np.abs(self.eigenvalues)
        return float(sizes.min() / sizes.max()) if len(sizes) else 1.0

    @cached_property
    def _dense(self) -> _Dense:
        return _Dense(self._solution, self.motors_are)


class _Dense:
    """H_r as a matrix, for whoever wants all of it."""

    @on_one_numpy_thread
    def __init__(self, solution: ModelState, motors_are: MotorReading) -> None:
        robot = solution.robot
        self.solution = solution
        self.moving = robot.moving_indices
        if motors_are == "free":
            self.moving = np.concatenate([self.moving, robot.motor_indices])
        motions = robot.unit_motions[np.ix_(self.moving, self.moving)]
        tangent = solution.tangent
        constraints = tangent[np.ix_(robot.multiplier_indices, self.moving)] @ motions
        self.null_space = motions @ null_space_of(constraints)
        hessian = tangent[np.ix_(self.moving, self.moving)]
        self.reduced = self.null_space.T @ (0.5 * (hessian + hessian.T)) @ self.null_space

    @on_one_numpy_thread
    def eigenvalues(self) -> Floats:
        """Without the motions, in half the time: streams tell the eigenvalues only."""
        return np.asarray(np.linalg.eigvalsh(self.reduced), float)  # takes an empty one as well

    @on_one_numpy_thread
    def motions(self) -> Floats:
        """Eigenvectors as motions of the whole robot, columns in state order."""
        _, directions = np.linalg.eigh(self.reduced)
        whole = np.zeros((len(self.solution.state), directions.shape[1]))
        whole[self.moving] = self.null_space @ directions
        return whole

    @cached_property
    def _elastic(self) -> Floats:
        """The elastic part of H_r."""
        elastic = elastic_hessian(self.solution)[np.ix_(self.moving, self.moving)]
        return self.null_space.T @ elastic @ self.null_space

    @on_one_blas_thread
    def margin(self) -> float:
        """Smallest eigenvalue relative to the elastic stiffness."""
        elastic = self._elastic
        if not len(elastic):
            return math.inf
        factor, failed = scipy.linalg.lapack.dpotrf(elastic, lower=True, clean=True)
        if failed:
            return math.nan
        inverse, _ = scipy.linalg.lapack.dtrtri(factor, lower=True)
        negligible = _NO_ENERGY * np.trace(elastic)
        if 1.0 / np.sum(inverse**2) <= negligible:  # of the smallest eigenvalue a bound from below
            smallest = scipy.linalg.eigvalsh(elastic, subset_by_index=[0, 0])[0]
            if smallest <= negligible:
                return math.nan
        relative = inverse @ self.reduced @ inverse.T
        return float(scipy.linalg.eigvalsh(relative, subset_by_index=[0, 0])[0])

    @on_one_blas_thread
    def firm_margin(self) -> float:
        """As ``margin``, motions without elastic energy left to go where they like."""
        stored, basis = scipy.linalg.eigh(self._elastic)
        loose, firm = np.split(basis, [np.sum(stored <= _NO_ENERGY * stored.sum())], axis=1)
        units = np.sqrt(stored[loose.shape[1] :])
        across = loose.T @ self.reduced @ firm / units
        relative = firm.T @ self.reduced @ firm / units / units[:, None]
        try:
            loose_factor = scipy.linalg.cho_factor(loose.T @ self.reduced @ loose)
        except np.linalg.LinAlgError:
            return -math.inf
        relative -= across.T @ scipy.linalg.cho_solve(loose_factor, across)
        return float(scipy.linalg.eigvalsh(relative).min(initial=math.inf))


@on_one_blas_thread
def null_space_of(matrix: Floats) -> Floats:
    """Orthonormal basis of the null space of a wide matrix, as columns."""
    basis, triangle, _ = scipy.linalg.qr(matrix.T, pivoting=True, check_finite=False)
    pivots = np.abs(np.diag(triangle))
    rank = int(np.sum(pivots > DEPENDENT * pivots.max(initial=0.0)))
    null: Floats = basis[:, rank:]
    return null


def elastic_hessian(solution: ModelState) -> Floats:
    """Second derivative of what rods (``l0/l q^T K q / 2``) and springs store, by the state, (N, N)."""
    robot, state = solution.robot, solution.state
    elastic = robot.strain_stiffness.copy()
    for rod in robot.numbers.rods:
        if rod.length_index is None:
            continue
        strains, shift = rod.strain, rod.length_index
        couple = robot.strain_stiffness[strains, strains] @ state[strains]
        length = rod.length(state)
        ratio, grows = rod.element.rod.length / length, rod.element.ratio / length
        elastic[strains, strains] *= ratio
        elastic[strains, shift] = elastic[shift, strains] = -ratio * grows * couple
        elastic[shift, shift] += ratio * grows**2 * couple @ state[strains]
    for leg, numbers in zip(robot.description.legs, robot.numbers.legs, strict=True):
        for element, index in zip(leg.chain, numbers.coordinates, strict=True):
            if index is not None:
                elastic[index, index] += element.stiffness
    return elastic
