# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A straight path in what a request imposes, and the solves on it.

A path is a curve F(x, t) = 0 of the unknowns x and the fraction t of the way. It is solved in two ways:
at a given fraction (`Path.at`), which is fast, and at a given arc length along the curve
(`Path.along`), which also works where the curve turns back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread
from ..description.loads import Loads
from ..kernels.continuation_kernel import FREELY, UNPREDICTED
from ..kernels.square_problem import CONTRACTION, ITERATIONS, RESIDUAL_TOLERANCE
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import equilibrium_at, stepped
from ..model.model_state import configuration_of, evaluate
from ..model.stability import elastic_hessian
from .deadline import Deadline
from .hidden_changes import Watched
from .limits import Limit, margins, may_be_kept_again, violated
from .path_equations import PathEquations
from .targets import Target
from .watching import Watching

__all__ = ["OutOfTime", "Path", "Point", "Tangent"]

Floats = NDArray[np.float64]

#: A point predicted along a tangent is at most so far from the curve, per arc length of the step.
PREDICTION = 0.25
#: Residual below which a point found by arc length is not corrected once more: where branches cross, an
#: error is divided by the distance from the crossing.
POLISHED = 1e-14
#: Elastic energy below this part of what the stiffest strain stores is that of no strain.
_UNBENT = 1e-6


class OutOfTime(Exception):
    """The deadline of a path is over; who walks it takes this up."""


@dataclass(frozen=True, eq=False)
class Tangent:
    """Unit tangent of the curve at a point, dimensionless.

    Attributes:
        unknowns: Change of the unknowns per arc length, legs first, (M,).
        fraction: Change of the fraction per arc length.
    """

    unknowns: Floats
    fraction: float

    def cosine(self, second: Tangent) -> float:
        """Cosine of the angle between two tangents."""
        return float(self.unknowns @ second.unknowns) + self.fraction * second.fraction


@dataclass(frozen=True, eq=False)
class Point:
    """A solution on a path.

    Attributes:
        fraction: Fraction of the way.
        equilibrium: The equilibrium there.
        index: Stability index, of the motors as the problem has them (of the symmetric part of the
            tangent, where loads have no potential).
        sign: Sign of the determinant of the problem.
        inverse_sign: Sign of the determinant of the inverse problem; 0 where it is not watched.
        margins: How far the limits are, (K,).
        violated: Limits that do not hold.
        watched: What must not change its sign unseen within a step.
        tangent: Tangent of the branch, where it was followed by arc length; None: to larger fractions.
    """

    fraction: float
    equilibrium: Equilibrium
    index: int
    sign: int
    inverse_sign: int
    margins: Floats
    violated: frozenset[Limit]
    watched: Watched
    tangent: Tangent | None = None

    @property
    def forward(self) -> bool:
        """Whether the branch leads on to larger fractions here."""
        return self.tangent is None or self.tangent.fraction > 0.0

    @property
    def side(self) -> int:
        """Side of a bifurcation: a fold changes the determinant and the direction, so not this."""
        return self.sign if self.forward else -self.sign


class Path:
    """The straight path from an equilibrium to a target, the loads changing along with it.

    Attributes:
        start: Equilibrium at fraction 0.
        problem: Key of ``Robot.problems``.
        iterations: Newton steps used so far.
        conservative: Whether all loads on the way have a potential.
        looks_closely: Whether inverse singularities are looked for that the problem does not ask for.
    """

    def __init__(
        self,
        start: Equilibrium,
        target: Target,
        loads: Loads,
        stability: bool = False,
        singularities: bool = False,
        time_limit: float | None = None,
    ) -> None:
        """Prepare the solves; nothing is solved yet.

        Args:
            start: Equilibrium at fraction 0.
            target: What is imposed at fraction 1.
            loads: Loads there.
            stability: Watch the margin of stability on the way of a pose; for motors and efforts it is
                that of the problem itself.
            singularities: Tell the sides of inverse singularities on the way of motors or efforts.
            time_limit: Refuse to solve after this time [s]; default never.
        """
        robot = start.robot
        self.start, self.iterations, self._deadline = start, 0, Deadline(time_limit)
        self.problem, self._robot, self._target = target.problem, robot, target
        self._equations = PathEquations(start, target, loads)
        self.looks_closely = singularities and target.problem != "pose"
        self.conservative = self._equations.conservative
        pose, square = self.problem == "pose", robot.description.controlled and not robot.redundancy
        self._watching = Watching(
            may_be_kept_again(robot, self.problem),
            self.conservative and stability and pose,
            bool(square) and (pose or self.looks_closely),
        )

    @property
    def load_distance(self) -> float:
        """How far the loads change, comparable to a motor in radians."""
        return self._equations.load_distance

    def begin(self) -> Point:
        """The start as a point of the path."""
        return self._point(0.0, self.start)

    def at(self, near: Point, fraction: float) -> Point | None:
        """The solution at a fraction, by Newton's method from a point nearby.

        Returns:
            None if a correction did not contract: then the fraction is too far from the point.
        """
        if self._deadline.over:
            raise OutOfTime
        before, equations = near.equilibrium, self._equations
        loads = equations.loads_between(fraction), equations.loads_at(fraction)
        imposed = self._target.given(self.start, fraction, before)
        mode = UNPREDICTED if equations.loads_change else FREELY
        solution = stepped(before, self._robot, *loads, self.problem, imposed, mode)
        if solution is None:
            return None
        self.iterations += solution.iterations
        return self._point(fraction, solution)

    @on_one_blas_thread
    def crossing(self, low: Point, high: Point) -> float:
        """Fraction where the determinant of the problem vanishes between two neighbours, linearly."""
        logarithms = []
        for point in (low, high):
            matrix, _ = self._equations.linearised(point.equilibrium, point.fraction)
            logarithms.append(float(np.linalg.slogdet(matrix)[1]))
        weight = 1.0 / (1.0 + np.exp(min(700.0, logarithms[1] - logarithms[0])))
        return float(low.fraction + weight * (high.fraction - low.fraction))

    @on_one_blas_thread
    def singular_values(self, point: Point) -> Floats:
        """Of the dimensionless matrix of the problem at a point, ascending.

        Strains by their L2 norm along the rod, which no strain basis makes small.
        """
        return np.asarray(scipy.linalg.svdvals(self._orthonormal_matrix(point))[::-1])

    @on_one_blas_thread
    def bent_ways(self, point: Point, bound: float) -> int:
        """In how many ways branches may go on that bend rods: singular values below a bound.

        What hangs by little weight has small ones everywhere, at no elastic energy: that is no crossing.
        """
        _, values, rows = scipy.linalg.svd(self._orthonormal_matrix(point))
        legs = slice(self._robot.kernel_arrays.platform_index)
        motions = self._robot.unit_motions[legs, legs]
        elastic = motions.T @ elastic_hessian(point.equilibrium)[legs, legs] @ motions
        ways = rows[values < bound, legs]
        stored = np.linalg.eigvalsh(ways @ elastic @ ways.T)  # takes an empty one as well
        return int(np.sum(stored > _UNBENT * np.diag(elastic).max()))

    def _orthonormal_matrix(self, point: Point) -> Floats:
        """The dimensionless matrix, strains by their L2 norm along the rod."""
        matrix, _ = self._equations.linearised(point.equilibrium, point.fraction)
        robot, legs = self._robot, slice(self._robot.kernel_arrays.platform_index)
        orthonormal = robot.unit_motions[legs, legs] / robot.kernel_arrays.unit[legs, None]
        matrix[legs] = orthonormal.T @ matrix[legs]
        matrix[:, legs] = matrix[:, legs] @ orthonormal
        return matrix

    @on_one_blas_thread
    def tangent(self, point: Point, before: Tangent | None = None) -> Tangent:
        """Tangent of the curve at a point.

        Args:
            point: A point.
            before: Tangent at the point before, which tells the direction; default to larger fractions.
        """
        bordered = _bordered(*self._equations.linearised(point.equilibrium, point.fraction))
        last, unit = bordered[-1], np.zeros(len(bordered))
        unit[-1] = 1.0
        last[:] = unit if before is None else np.append(before.unknowns, before.fraction)
        curve = bordered[:-1]
        try:
            direction = np.asarray(np.linalg.solve(bordered, unit), np.float64)
            direction /= np.linalg.norm(direction)
        except np.linalg.LinAlgError:
            direction = np.full(len(last), np.nan)
        if not np.abs(curve @ direction).max() < 1e-6 * np.abs(curve).max():
            # The last direction is across the curve (exactly on a fold), or two branches cross.
            direction = scipy.linalg.svd(curve)[2][-1]
            direction *= 1.0 if direction @ last >= 0.0 else -1.0
        return Tangent(direction[:-1], float(direction[-1]))

    @on_one_blas_thread
    def along(self, point: Point, tangent: Tangent, arc_length: float) -> Point | None:
        """The solution at an arc length from a point, in the plane across its tangent.

        Returns:
            None if a correction did not contract.
        """
        if self._deadline.over:
            raise OutOfTime
        robot, equations = self._robot, self._equations
        across = np.append(tangent.unknowns, tangent.fraction)
        moved = arc_length * across  # since the point
        fraction = point.fraction + moved[-1]
        place = equations.moved(configuration_of(point.equilibrium), moved[:-1])
        polished = False
        last = 2.0 * PREDICTION * abs(arc_length)
        for iteration in range(ITERATIONS):
            load_arrays = equations.loads_at(fraction)
            place, efforts = equations.imposed(place, fraction)
            if not robot.rods_exist(place.state):
                return None
            value = evaluate(robot, load_arrays, *place)
            residual = equations.residual(value, efforts)
            largest = float(np.abs(residual).max())
            if not np.isfinite(largest):
                return None
            if largest < POLISHED or (largest < RESIDUAL_TOLERANCE and polished):
                loads = equations.loads_between(fraction)
                found = equilibrium_at(robot, loads, load_arrays, place, iteration)
                return self._point(fraction, found)
            polished = largest < RESIDUAL_TOLERANCE
            matrix = equations.matrix(value, place.platform_rotation)
            bordered = _bordered(matrix, equations.rate(value, place, fraction))
            bordered[-1] = across
            try:
                change = np.linalg.solve(
                    bordered, -np.append(residual, across @ moved - arc_length)
                )
            except np.linalg.LinAlgError:
                return None
            self.iterations += 1
            length = float(np.linalg.norm(change))
            if length > CONTRACTION * last and length > 1e-9:
                return None
            last = length
            moved += change
            fraction = point.fraction + moved[-1]
            place = equations.moved(place, change[:-1])
        return None

    def _point(self, fraction: float, equilibrium: Equilibrium) -> Point:
        """A solution as a point."""
        problem, left = self.problem, margins(equilibrium)
        index_locked, index_free, inverse_sign = equilibrium.signs
        index = index_free if problem == "efforts" else index_locked
        if problem == "pose":
            sign = inverse_sign
        elif self.conservative:
            sign = -1 if index % 2 else 1
        else:
            sign = self._equations.sign(equilibrium)
        return Point(
            fraction=float(fraction),
            equilibrium=equilibrium,
            index=index,
            sign=sign,
            inverse_sign=inverse_sign if self.looks_closely else 0,
            margins=left,
            violated=violated(self._robot, left),
            watched=self._watching.at(equilibrium, left, inverse_sign),
        )


def _bordered(matrix: Floats, rate: Floats) -> Floats:
    """A matrix with the rate of the residual beside it, and a row below for the caller to fill."""
    size = len(rate)
    bordered = np.empty((size + 1, size + 1))
    bordered[:size, :size], bordered[:size, size] = matrix, rate
    return bordered
