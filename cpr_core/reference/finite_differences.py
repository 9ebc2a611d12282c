# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Planar robots by finite differences of first order: the paper's Mod. #3.

A rod is N elements of constant curvature, integrated by Euler's explicit rule with h = l / N,

    theta_{k+1} = theta_k + h kappa_k,   p_{k+1} = p_k + h t(theta_k),   t = (cos, sin).

Equilibria are stationary points of

    sum E J h kappa_k^2 / 2 + lambda . (p_N - P) - f . P

leg by leg. In the angles theta_k, which are the curvatures summed up, the tangent is sparse: three
diagonals and the rows of the multipliers. Newton's method does not depend on this choice.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from ..errors import InvalidRequest
from ..kernels.natural_units import LONGEST_STEP
from ..kernels.square_problem import RESIDUAL_TOLERANCE
from ..model.robot import Robot
from ..solving.not_reached import NoForwardSolution
from ..validation import checked_vector
from .continuous_equilibrium import ContinuousEquilibrium
from .rod_integration import frame
from .shooting_robot import check_unloaded

__all__ = [
    "FiniteDifferenceEquilibrium",
    "follow_finite_differences",
    "solve_finite_differences",
]

Floats = NDArray[np.float64]

#: Newton corrections of a step; each must be smaller than this times the one before.
CORRECTIONS = 12
CONTRACTION = 0.5
#: Smallest part of a longest step before giving up.
SMALLEST_STEP = 1e-3


@dataclass(frozen=True, eq=False)
class FiniteDifferenceEquilibrium:
    """An equilibrium of rods cut into elements.

    Attributes:
        model: The robot and its elements.
        motors: Motor positions, (n,) [rad].
        unknowns: Angles theta_1..theta_N leg by leg, multipliers leg by leg, P; dimensionless.
        residual: Largest dimensionless residual.
        iterations: Newton steps.
    """

    model: FiniteDifferences
    motors: Floats
    unknowns: Floats = field(repr=False)
    residual: float
    iterations: int

    @property
    def platform_position(self) -> Floats:
        """P in the world, (3,) [m]."""
        return self.model.length * np.append(self.unknowns[-2:], 0.0)

    @property
    def curvatures(self) -> Floats:
        """Curvature of every element, (L, N) [1/m]."""
        count, elements = len(self.motors), self.model.elements
        angles = self.unknowns[: count * elements].reshape(count, elements)
        base = self.model.base_angles + self.model.turns * self.motors
        steps = np.diff(np.column_stack([base, angles]), axis=1)
        return steps / self.model.steps[:, None] / self.model.length


class FiniteDifferences:
    """A planar robot of elements; lengths in rod lengths, forces in E J / l^2.

    Attributes:
        robot: The robot.
        elements: Elements N of every leg.
        length: Unit of length [m].
        base_angles: Angles of the base tangents with the motors at zero, (L,) [rad].
        steps: Lengths h of an element, (L,).
    """

    def __init__(self, robot: Robot, elements: int) -> None:
        """Lay out the tangent."""
        if not (robot.planar and robot.description.point_platform):
            raise InvalidRequest("robot", "expected a planar robot whose rods meet in a point")
        if elements < 2:
            raise InvalidRequest("elements", f"expected at least 2, got {elements}")
        legs = robot.description.legs
        self.robot, self.elements, self.length = robot, elements, robot.mean_length
        stiffness = np.array([leg.rod.rigidities[2] for leg in legs])
        tangents = np.array([leg.base_at(0.0).rotation[:2, 0] for leg in legs])
        self.base_angles = np.arctan2(tangents[:, 1], tangents[:, 0])
        self.bases = np.array([leg.base_position[:2] for leg in legs]) / self.length
        self.steps = np.array([leg.rod.length for leg in legs]) / self.length / elements
        self.turns = np.array([leg.motor.axis[2] for leg in legs])  # type: ignore[attr-defined]
        self.stiffness = stiffness / stiffness.mean() / self.steps  # E J / h
        self._lay_out()

    def _lay_out(self) -> None:
        """Pattern of the tangent, compressed by columns, and where its varying entries are."""
        count, n = len(self.bases), self.elements
        angles = np.arange(count * n).reshape(count, n)
        forces = count * n + np.arange(2 * count).reshape(count, 2)
        place = forces.max() + 1 + np.arange(2)
        inner = angles[:, :-1]  # the tip turns with theta_1..theta_{N-1} only
        columns_of = [np.broadcast_to(forces[:, None, axis], inner.shape) for axis in range(2)]
        along = np.broadcast_to(place, forces.shape)
        rows = [angles, angles[:, 1:], inner, inner, inner, *columns_of, forces, along]
        columns = [angles, inner, angles[:, 1:], *columns_of, inner, inner, along, forces]
        row = np.concatenate([part.ravel() for part in rows])
        column = np.concatenate([part.ravel() for part in columns])
        size = int(place.max()) + 1
        order = sparse.csc_matrix((np.arange(1.0, len(row) + 1.0), (row, column)), (size, size))
        self._order = order.data.astype(np.int64) - 1
        self._pattern = (order.indices, order.indptr)
        self._size = size
        diagonal = np.full((count, n), 2.0)
        diagonal[:, -1] = 1.0
        self._elastic = self.stiffness[:, None] * diagonal
        beside = -np.repeat(self.stiffness, n - 1)
        self._constant = (np.concatenate([beside, beside]), np.full(4 * count, -1.0))

    def evaluate(self, motors: Floats, unknowns: Floats) -> tuple[Floats, sparse.csc_matrix]:
        """Residual and its exact tangent."""
        count, n = len(self.bases), self.elements
        angles = unknowns[: count * n].reshape(count, n)
        forces = unknowns[count * n : -2].reshape(count, 2)
        base = (self.base_angles + self.turns * motors)[:, None]
        step, stiffness = self.steps[:, None], self.stiffness[:, None]
        bends = stiffness * np.diff(np.hstack([base, angles]), axis=1)
        cosine, sine = np.cos(angles[:, :-1]), np.sin(angles[:, :-1])
        fx, fy = forces[:, :1], forces[:, 1:]

        elastic = bends.copy()
        elastic[:, :-1] += step * (fy * cosine - fx * sine) - bends[:, 1:]
        along = np.column_stack([cosine.sum(axis=1), sine.sum(axis=1)])
        along += np.hstack([np.cos(base), np.sin(base)])
        gaps = self.bases + step * along - unknowns[-2:]
        residual = np.concatenate([elastic.ravel(), gaps.ravel(), -forces.sum(axis=0)])

        diagonal = self._elastic.copy()
        diagonal[:, :-1] -= step * (fx * cosine + fy * sine)
        by_x, by_y = (-step * sine).ravel(), (step * cosine).ravel()
        beside, ones = self._constant
        data = np.concatenate([diagonal.ravel(), beside, by_x, by_y, by_x, by_y, ones])
        tangent = sparse.csc_matrix((data[self._order], *self._pattern), (self._size, self._size))
        return residual, tangent

    def correction(self, tangent: sparse.csc_matrix, residual: Floats) -> Floats:
        """Newton correction. Multipliers and P come last: in this order the factors stay sparse."""
        return splu(tangent, permc_spec="NATURAL").solve(residual)

    def newton(
        self, motors: Floats, unknowns: Floats, contraction: float
    ) -> tuple[Floats, float, int]:
        """Solve from near; the residual stays large where corrections do not contract."""
        length = np.inf
        for iteration in range(CORRECTIONS + 1):
            residual, tangent = self.evaluate(motors, unknowns)
            largest = float(np.abs(residual).max())
            if largest < RESIDUAL_TOLERANCE or iteration == CORRECTIONS:
                break
            change = self.correction(tangent, residual)
            correction = float(np.linalg.norm(change))
            if not correction < contraction * length:
                break
            unknowns, length = unknowns - change, correction
        return unknowns, largest, iteration


def solve_finite_differences(
    start: ContinuousEquilibrium, elements: int
) -> FiniteDifferenceEquilibrium:
    """Refine an equilibrium of continuous rods into one of elements, motors held.

    Args:
        start: Where Newton's method starts.
        elements: Elements of every leg.

    Raises:
        InvalidRequest: Not a planar robot of rods that meet in a point, or a load.
        NoForwardSolution: Newton's method does not reach the tolerance.
    """
    model = FiniteDifferences(start.robot, elements)
    check_unloaded(start.robot, start.loads)
    parts: list[Floats] = []
    for (rod,), base in zip(
        start.rods, model.base_angles + model.turns * start.motors, strict=True
    ):
        tangents = np.array([frame(rod.at((k + 1) / elements))[:2, 0] for k in range(elements)])
        angles = np.unwrap(np.append(base, np.arctan2(tangents[:, 1], tangents[:, 0])))
        parts.append(angles[1:])
    unit = start.robot.description.legs[0].rod.rigidities[2] / model.length**2
    parts += [-start.base_wrenches[:, 3:5].ravel() / unit]
    unknowns = np.concatenate([*parts, start.platform_position[:2] / model.length])
    found, largest, iterations = model.newton(start.motors, unknowns, np.inf)
    if not largest < RESIDUAL_TOLERANCE:
        raise NoForwardSolution(f"finite differences: residual {largest:.1e}", 0.0, None)
    return FiniteDifferenceEquilibrium(model, start.motors, found, largest, iterations)


def follow_finite_differences(
    start: FiniteDifferenceEquilibrium, motors: ArrayLike
) -> tuple[FiniteDifferenceEquilibrium, ...]:
    """Forward problem along a path of motor positions.

    Args:
        start: Equilibrium whose branch is followed.
        motors: Motor positions one after the other, (K, n) [rad].

    Raises:
        InvalidRequest: Wrong number of motors.
        NonFiniteInput: A NaN or an infinity.
        NoForwardSolution: The branch does not reach that far.
    """
    model, last, points = start.model, start, []
    for target in np.asarray(motors):
        goal = checked_vector("motors", target, len(start.motors))
        change = goal - last.motors
        longest = 1.0 / max(1.0, float(np.abs(change).max()) / LONGEST_STEP)
        first, reached, step, total = last.motors, 0.0, longest, 0
        while reached < 1.0:
            ahead = min(1.0, reached + step)
            imposed = (1.0 - ahead) * first + ahead * goal
            found, largest, used = model.newton(imposed, last.unknowns, CONTRACTION)
            total += used
            if largest < RESIDUAL_TOLERANCE:
                last = FiniteDifferenceEquilibrium(model, imposed, found, largest, total)
                step, reached = min(longest, 2.0 * (ahead - reached)), ahead
                continue
            step = 0.5 * (ahead - reached)
            if step < SMALLEST_STEP * longest:
                raise NoForwardSolution("finite differences: no equilibrium near", reached, None)
        points.append(last)
    return tuple(points)
