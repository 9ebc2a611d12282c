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
from ..kernels.kernel_arrays import PLATFORM_LOADS, LoadArrays, interpolated_loads
from ..kernels.natural_units import EFFORT_UNIT
from ..kernels.prepared_robot import evaluate_prepared
from ..kernels.square_problem import CONTRACTION, ITERATIONS, RESIDUAL_TOLERANCE
from ..kernels.twist_layout import ANGULAR
from ..lie import angle_motions, rotation_log
from ..model.displacement import displaced
from ..model.equilibrium import Equilibrium, described, stepped
from ..model.smallest_singular_value import smallest_singular_value
from ..validation import cached_property
from .deadline import Deadline
from .hidden_changes import Watched
from .limits import Limit, margins, may_be_kept_again, violated
from .targets import Imposed, Target

__all__ = ["OutOfTime", "Path", "Point", "Tangent"]

Floats = NDArray[np.float64]

#: A point predicted along a tangent is at most so far from the curve, per arc length of the step.
PREDICTION = 0.25
#: Residual below which a point found by arc length is not corrected once more: where branches cross, an
#: error is divided by the distance from the crossing.
POLISHED = 1e-14
#: Step of the fraction by which the rate of the residual is found, central differences.
_RATE_STEP = 1e-5
#: The same for what changes evenly along the whole way: less than a quarter turn.
_EVEN_STEP = 0.25


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
        iterations: Newton steps used so far.
        conservative: Whether all loads on the way have a potential.
        load_distance: Change of the loads, in longest steps of a radian each.
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
        self._robot, self._target, self._loads = robot, target, loads
        self.looks_closely = singularities and target.problem != "pose"
        self._stability = stability and target.problem == "pose"
        self._limits_return = may_be_kept_again(robot, target.problem)
        square = bool(robot.description.controlled) and not robot.redundancy
        self._inverse = square and (target.problem == "pose" or self.looks_closely)
        self._loads_change = loads is not start.loads
        self._last_loads = robot.load_arrays(loads) if self._loads_change else start.load_arrays
        self.conservative = loads.conservative(robot.planar) and (
            not self._loads_change or start.loads.conservative(robot.planar)
        )
        self._columns, self._rows = robot.problems[target.problem]
        self._angles = target.problem == "pose" and robot.controls_angles
        self._residual = np.empty(len(robot.arrays.unit))
        self._even_rates: tuple[Floats, Floats] | None = None

    @cached_property
    def _tangent(self) -> Floats:
        return np.zeros((len(self._residual), len(self._residual)))

    @cached_property
    def _equations(self) -> NDArray[np.int64]:
        """State indices of the equations, legs first."""
        return np.concatenate([np.arange(self._robot.arrays.platform_index), self._rows])

    @cached_property
    def _scales(self) -> Floats:
        """What makes the matrix of the problem dimensionless, entry by entry."""
        arrays = self._robot.arrays
        unknowns = np.concatenate([np.arange(arrays.platform_index), self._columns])
        scales: Floats = np.outer(arrays.unit[self._equations], arrays.unit[unknowns])
        return scales / arrays.energy_unit

    @cached_property
    def load_distance(self) -> float:
        """How far the loads change, comparable to a motor in radians."""
        if not self._loads_change:
            return 0.0
        arrays, length = self._robot.arrays, self._robot.mean_length
        first, last = self.start.load_arrays, self._last_loads
        platform = {
            name: np.abs(last.platform[name] - first.platform[name]).max()
            for name in PLATFORM_LOADS.names or ()
        }
        rods = np.abs(last.distributed - first.distributed).max(initial=0.0) * length
        points = np.abs(last.point - first.point).max(initial=0.0)
        forces = max(
            platform["weight"], platform["force_world"], platform["force_body"], rods, points
        )
        moments = max(platform["moment_world"], platform["moment_body"])
        return float(max(forces * length, moments)) / (EFFORT_UNIT * arrays.energy_unit)

    @property
    def problem(self) -> str:
        """Key of ``Robot.problems``."""
        return self._target.problem

    def begin(self) -> Point:
        """The start as a point of the path."""
        return self._found(0.0, self.start)

    def at(self, near: Point, fraction: float) -> Point | None:
        """The solution at a fraction, by Newton's method from a point nearby.

        Returns:
            None if a correction did not contract: then the fraction is too far from the point.
        """
        if self._deadline.over:
            raise OutOfTime
        before, asked, loads = (
            near.equilibrium,
            self._loads_between(fraction),
            self._loads_at(fraction),
        )
        given = self._target.given(self.start, fraction, before)
        mode = UNPREDICTED if self._loads_change else FREELY
        found = stepped(before, self._robot, asked, loads, self.problem, given, mode)
        if found is None:
            return None
        self.iterations += found.iterations
        return self._found(fraction, found)

    @on_one_blas_thread
    def crossing(self, low: Point, high: Point) -> float:
        """Fraction where the determinant of the problem vanishes between two neighbours, linearly."""
        logarithms = []
        for point in (low, high):
            matrix, _ = self._linearised(point)
            logarithms.append(float(np.linalg.slogdet(matrix)[1]))
        weight = 1.0 / (1.0 + np.exp(min(700.0, logarithms[1] - logarithms[0])))
        return low.fraction + weight * (high.fraction - low.fraction)

    @on_one_blas_thread
    def singular_values(self, point: Point) -> Floats:
        """Of the dimensionless matrix of the problem at a point, ascending.

        Strains by their L2 norm along the rod, which no strain basis makes small.
        """
        matrix, _ = self._linearised(point)
        robot, legs = self._robot, slice(self._robot.arrays.platform_index)
        orthonormal = robot.unit_motions[legs, legs] / robot.arrays.unit[legs, None]
        matrix[legs] = orthonormal.T @ matrix[legs]
        matrix[:, legs] = matrix[:, legs] @ orthonormal
        return np.asarray(scipy.linalg.svdvals(matrix)[::-1])

    @on_one_blas_thread
    def tangent(self, point: Point, before: Tangent | None = None) -> Tangent:
        """Tangent of the curve at a point.

        Args:
            point: A point.
            before: Tangent at the point before, which tells the direction; default to larger fractions.
        """
        bordered = self._bordered(*self._linearised(point))
        last, unit = bordered[-1], np.zeros(len(bordered))
        unit[-1] = 1.0
        last[:] = unit if before is None else np.append(before.unknowns, before.fraction)
        curve = bordered[:-1]
        try:
            found = np.asarray(np.linalg.solve(bordered, unit), np.float64)
            found /= np.linalg.norm(found)
        except np.linalg.LinAlgError:
            found = np.full(len(last), np.nan)
        if not np.abs(curve @ found).max() < 1e-6 * np.abs(curve).max():
            # The last direction is across the curve (exactly on a fold), or two branches cross.
            found = scipy.linalg.svd(curve)[2][-1]
            found *= 1.0 if found @ last >= 0.0 else -1.0
        return Tangent(found[:-1], float(found[-1]))

    @on_one_blas_thread
    def along(self, point: Point, tangent: Tangent, arc_length: float) -> Point | None:
        """The solution at an arc length from a point, in the plane across its tangent.

        Returns:
            None if a correction did not contract.
        """
        if self._deadline.over:
            raise OutOfTime
        robot = self._robot
        state = point.equilibrium.state.copy()
        rotation = point.equilibrium.platform_rotation.copy()
        position = point.equilibrium.platform_position.copy()
        across = np.append(tangent.unknowns, tangent.fraction)
        moved = arc_length * across  # since the point
        fraction = point.fraction + moved[-1]
        self._move(state, rotation, position, moved[:-1])
        polished = False
        last = 2.0 * PREDICTION * abs(arc_length)
        for iteration in range(ITERATIONS):
            loads = self._loads_at(fraction)
            efforts = self._impose(state, rotation, position, fraction)
            if not robot.rods_exist(state):
                return None
            self._evaluate(state, rotation, position, loads)
            residual = self._scaled_residual(efforts)
            largest = float(np.abs(residual).max())
            if not np.isfinite(largest):
                return None
            if largest < POLISHED or (largest < RESIDUAL_TOLERANCE and polished):
                asked = self._loads_between(fraction)
                found = described(robot, asked, loads, state, rotation, position, iteration)
                return self._found(fraction, found)
            polished = largest < RESIDUAL_TOLERANCE
            matrix = self._scaled_tangent(rotation)
            bordered = self._bordered(matrix, self._rate(state, rotation, position, fraction))
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
            self._move(state, rotation, position, change[:-1])
        return None

    def _found(self, fraction: float, equilibrium: Equilibrium) -> Point:
        """A solution as a point."""
        if not self.conservative:
            state, rotation = equilibrium.state.copy(), equilibrium.platform_rotation.copy()
            position = equilibrium.platform_position.copy()
            self._evaluate(state, rotation, position, equilibrium.load_arrays)
        return self._point(fraction, equilibrium)

    def _point(self, fraction: float, equilibrium: Equilibrium) -> Point:
        problem, margin = self._target.problem, margins(equilibrium)
        index_locked, index_free, inverse_sign = equilibrium.signs
        index = index_free if problem == "efforts" else index_locked
        if not self.conservative:
            sign = int(np.linalg.slogdet(self._scaled_tangent(equilibrium.platform_rotation))[0])
        elif problem == "pose":
            sign = inverse_sign
        else:
            sign = -1 if index % 2 else 1
        return Point(
            fraction=fraction,
            equilibrium=equilibrium,
            index=index,
            sign=sign,
            inverse_sign=inverse_sign if self.conservative and self.looks_closely else 0,
            margins=margin,
            violated=violated(self._robot, margin),
            watched=self._watched(equilibrium, margin, inverse_sign),
        )

    def _watched(self, equilibrium: Equilibrium, margin: Floats, inverse_sign: int) -> Watched:
        """What must not change its sign unseen.

        Symmetric robots pass inverse singularities with two singular values at once: the determinant
        keeps its sign, and Newton's method may not see it.
        """
        values, distance = list[float](), list[float]()
        if self._limits_return:
            sides = self._robot.motor_limits.sides_left(equilibrium.motors, equilibrium.efforts)
            values += sides[np.isfinite(sides)].tolist()
            values += margin[len(self._robot.motor_limits.order) :].tolist()
        if self.conservative and self._stability:
            values.append(equilibrium.margin)
        if self.conservative and self._inverse:
            distance.append(inverse_sign * smallest_singular_value(equilibrium, True, None))
        return Watched(tuple(values), tuple(distance))

    def _loads_at(self, fraction: float) -> LoadArrays:
        """Loads part of the way; all entries are linear in what is given."""
        if not self._loads_change or fraction == 1.0:
            return self._last_loads
        return interpolated_loads(self.start.load_arrays, self._last_loads, fraction)

    def _loads_between(self, fraction: float) -> Loads:
        return self.start.loads.toward(self._loads, fraction) if self._loads_change else self._loads

    def _imposed(self, near: Equilibrium, fraction: float) -> tuple[Floats, Floats, Floats, Floats]:
        """State, rotation and position with what is imposed at a fraction, and imposed efforts."""
        state = near.state.copy()
        rotation, position = near.platform_rotation.copy(), near.platform_position.copy()
        return state, rotation, position, self._impose(state, rotation, position, fraction)

    def _impose(self, state: Floats, rotation: Floats, position: Floats, fraction: float) -> Floats:
        """Write what is imposed at a fraction; returns the imposed efforts."""
        efforts = np.zeros(self._robot.motor_count)
        motors = state[self._robot.arrays.motor_index :]
        self._target.impose(self.start, fraction, Imposed(motors, efforts, rotation, position))
        return efforts

    def _evaluate(
        self, state: Floats, rotation: Floats, position: Floats, loads: LoadArrays
    ) -> None:
        """Residual and tangent at any state."""
        evaluate_prepared(
            self._robot.prepared, loads, state, rotation, position, self._residual, self._tangent
        )

    def _scaled_residual(self, efforts: Floats) -> Floats:
        """Dimensionless residual of the problem, legs first."""
        return self._scaled(self._residual.copy(), efforts)

    def _scaled(self, residual: Floats, efforts: Floats) -> Floats:
        """A residual less the efforts, in natural units, of the equations of the problem."""
        arrays = self._robot.arrays
        residual[arrays.motor_index :] -= efforts
        residual *= arrays.unit / arrays.energy_unit
        return residual[self._equations]

    def _scaled_tangent(self, rotation: Floats) -> Floats:
        """Dimensionless matrix of the problem, legs first, (M, M)."""
        tangent, inner = self._tangent, self._robot.arrays.platform_index
        if self._angles:
            turns = self._robot.platform_indices[ANGULAR]
            tangent = tangent.copy()
            tangent[:, turns] = tangent[:, turns] @ angle_motions(rotation)
        # The legs, most of it, are copied as they are: picking entry by entry takes five times longer.
        scaled = np.empty_like(self._scales)
        scaled[:inner, :inner] = tangent[:inner, :inner]
        scaled[:inner, inner:] = tangent[:inner, self._columns]
        scaled[inner:, :inner] = tangent[self._rows, :inner]
        scaled[inner:, inner:] = tangent[self._rows[:, None], self._columns]
        scaled *= self._scales
        return scaled

    @staticmethod
    def _bordered(matrix: Floats, rate: Floats) -> Floats:
        """A matrix with the rate of the residual beside it, and a row below for the caller to fill."""
        size = len(rate)
        bordered = np.empty((size + 1, size + 1))
        bordered[:size, :size], bordered[:size, size] = matrix, rate
        return bordered

    def _linearised(self, point: Point) -> tuple[Floats, Floats]:
        """Matrix of the problem at a point and rate of its residual with the fraction."""
        state, rotation, position, _ = self._imposed(point.equilibrium, point.fraction)
        self._evaluate(state, rotation, position, point.equilibrium.load_arrays)
        matrix = self._scaled_tangent(rotation)
        return matrix, self._rate(state, rotation, position, point.fraction)

    def _rate(self, state: Floats, rotation: Floats, position: Floats, fraction: float) -> Floats:
        """Rate of the dimensionless residual with the fraction, the unknowns held.

        Needs the tangent there, along which what is imposed moves. Where loads change too, central
        differences: exact where it is linear in the residual (loads, efforts), good to 1e-9 elsewhere;
        only predictions and directions depend on it.
        """
        if not self._loads_change:
            whole, efforts = self._imposed_rates(state, rotation, position, fraction)
            return self._scaled(self._tangent @ whole, efforts)
        sides = []
        for change in (_RATE_STEP, -_RATE_STEP):
            parts = state.copy(), rotation.copy(), position.copy()
            imposed = self._impose(*parts, fraction + change)
            self._evaluate(*parts, self._loads_at(fraction + change))
            sides.append(self._scaled_residual(imposed))
        return (sides[0] - sides[1]) / (2.0 * _RATE_STEP)

    def _imposed_rates(
        self, state: Floats, rotation: Floats, position: Floats, fraction: float
    ) -> tuple[Floats, Floats]:
        """Rates of state and efforts with the fraction; only single angles do not change evenly."""
        if self._even_rates is not None:
            return self._even_rates
        step = _RATE_STEP if self._angles else _EVEN_STEP
        ends = []
        for change in (step, -step):
            parts = state.copy(), rotation.copy(), position.copy()
            ends.append((*parts, self._impose(*parts, fraction + change)))
        (state, rotation, position, efforts), before = ends
        twist = np.concatenate([rotation_log(rotation @ before[1].T), position - before[2]])
        whole = state - before[0]
        whole[self._robot.platform_indices] += twist[self._robot.platform_axes]
        rates = whole / (2.0 * step), (efforts - before[3]) / (2.0 * step)
        if not self._angles:
            self._even_rates = rates
        return rates

    def _move(self, state: Floats, rotation: Floats, position: Floats, change: Floats) -> None:
        """Add a dimensionless change of the unknowns, in place."""
        robot, inner = self._robot, self._robot.arrays.platform_index
        whole = np.zeros(len(state))
        whole[:inner] = change[:inner]
        whole[self._columns] = change[inner:]
        whole *= robot.arrays.unit
        if self._angles:
            turning = robot.platform_indices[ANGULAR]
            whole[turning] = angle_motions(rotation) @ whole[turning]
        state[:], rotation[:], position[:] = displaced(robot, state, rotation, position, whole)
