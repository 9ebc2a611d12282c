# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The linear problems of Section V-C, and how near each is to losing its solution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from ..blas_threads import on_one_numpy_thread
from ..description.controlled_coordinates import no_inverse_problem
from ..errors import InvalidRequest
from ..kernels.twist_layout import ANGULAR
from ..lie import angle_motions
from ..validation import ReadOnlyArrays, cached_array, cached_property, checked_word, read_only
from .dense_response import body_tangent, platform_turn
from .equilibrium import Equilibrium
from .problem_units import ProblemUnits, problem_units
from .smallest_singular_value import smallest_singular_value
from .stability import null_space_of

__all__ = ["LinearMatrices", "LinearProblem", "LinearProblems", "Singularity", "coordinate_motions"]

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]

#: The linear problems of Section V-C.
#:
#: - ``forward``: motors and wrench given, [P E W_a] of Eq. (45);
#: - ``inverse``: controlled platform coordinates and wrench given, as the inverse geometrico-static
#:   problem has it: [A P_u E W_a] with P_u the uncontrolled coordinates; with redundant motors it has
#:   more columns than rows, and is singular where it loses rank;
#: - ``inverse_by_effort``: whole platform motion and efforts given, [A E W_p] of Eq. (46).
LinearProblem = Literal["forward", "inverse", "inverse_by_effort"]
_PROBLEMS: tuple[LinearProblem, ...] = get_args(LinearProblem)
_WITHOUT_INVERSE = tuple(problem for problem in _PROBLEMS if problem != "inverse")


@dataclass(frozen=True, eq=False)
class Singularity(ReadOnlyArrays):
    """How near a linear problem of Section V-C is to losing its solution.

    Attributes:
        problem: Which problem.
        singular_values: Of the dimensionless matrix, ascending.
        motors: Motor part of the null direction, (n,); zero where motors are given. Of a problem with
            more unknowns than equations, the direction of the smallest singular value.
        platform: Platform part of the null direction (body twist); zero where it is given.
        sign: Sign of the determinant: which side of the singularity this is; 0 where there is none.
    """

    problem: LinearProblem
    singular_values: Floats
    motors: Floats
    platform: Floats
    sign: int

    @property
    def smallest(self) -> float:
        """Smallest singular value, dimensionless."""
        return float(self.singular_values[0])

    @property
    def inverse_condition_number(self) -> float:
        """Smallest over largest singular value."""
        return float(self.singular_values[0] / self.singular_values[-1])


class LinearMatrices(NamedTuple):
    """``a dq_a + p dSigma_p + e dq_e = w [dtau_a; dw_p]``, Eqs. (42)-(43), dimensionless.

    As many rows as motors, leg coordinates and platform coordinates together.

    Attributes:
        a: By motor positions, (rows, n).
        p: By the body twist of the platform, (rows, platform).
        e: By leg coordinates: passive joints and strain, (rows, elastic).
        w: By efforts and platform wrench acting on the robot, (rows, n + platform).
    """

    a: Floats
    p: Floats
    e: Floats
    w: Floats


@dataclass(frozen=True, eq=False)
class LinearProblems:
    """The problems at one equilibrium, from the tangent the solver uses.

    Attributes:
        equilibrium: Where.
    """

    equilibrium: Equilibrium

    @cached_array
    def body_tangent(self) -> Floats:
        """Tangent of the model with the platform in body coordinates, in state order, (N, N)."""
        return body_tangent(self.equilibrium)

    def matrices(self, characteristic_length: float | None = None) -> LinearMatrices:
        """A, P, E, W of Eqs. (42)-(43), dimensionless, by the names a, p, e, w.

        Rotations count in radians, lengths in the characteristic length, energies in E J / length, and
        strains in the inverse of that length by their L2 norm along the rod: E is by coordinates that
        are orthonormal in it. Singular values then depend neither on the strain basis nor, once they
        converge, on the number of modes.

        Args:
            characteristic_length: [m]; default the mean rod length.
        """
        units = problem_units(self.equilibrium.robot, characteristic_length)
        if units.energy not in self._known_matrices:
            self._known_matrices[units.energy] = self._matrices(units)
        return self._known_matrices[units.energy]

    @cached_property
    def _known_matrices(self) -> dict[float, LinearMatrices]:
        """By the unit of energy, which tells the lengths apart: every problem takes the same."""
        return {}

    def _matrices(self, units: ProblemUnits) -> LinearMatrices:
        robot, motions = self.equilibrium.robot, units.motions
        moving = np.concatenate(
            [robot.motor_indices, robot.elastic_indices, robot.platform_indices]
        )
        scaled = motions.T @ self.body_tangent @ motions / units.energy
        jacobian = scaled[np.ix_(robot.multiplier_indices, moving)]
        null_space = null_space_of(jacobian)
        stacked = read_only(np.vstack([null_space.T @ scaled[np.ix_(moving, moving)], jacobian]))
        n, last = robot.motor_count, len(moving) - len(robot.platform_indices)
        loads = np.zeros((len(moving), n + len(robot.platform_indices)))
        loads[:n, :n] = np.eye(n)
        loads[last:, n:] = np.eye(len(robot.platform_indices))
        unloaded = np.zeros((len(jacobian), loads.shape[1]))
        right = read_only(np.vstack([null_space.T @ loads, unloaded]))
        return LinearMatrices(stacked[:, :n], stacked[:, last:], stacked[:, n:last], right)

    @property
    def problems(self) -> tuple[LinearProblem, ...]:
        """Linear problems of this robot: ``inverse`` where coordinates are controlled."""
        return _PROBLEMS if len(self.equilibrium.robot.controlled_axes) else _WITHOUT_INVERSE

    @on_one_numpy_thread
    def singularity(
        self, problem: LinearProblem, characteristic_length: float | None = None
    ) -> Singularity:
        """Distance of a linear problem from a singularity.

        Args:
            problem: Which problem.
            characteristic_length: Length that rotations are weighed with [m]; default the mean rod
                length.
        """
        robot, n = self.equilibrium.robot, self.equilibrium.robot.motor_count
        matrix, free = self._problem_matrix(problem, characteristic_length)
        unit = problem_units(robot, characteristic_length).states
        _, values, directions = np.linalg.svd(matrix, full_matrices=False)
        null, number = directions[-1], self._moved(problem)
        motors, moved = np.zeros(n), len(number)
        motors[number] = null[:moved] * unit[robot.motor_indices][number]
        lengths = unit[robot.platform_indices]
        return Singularity(
            problem=problem,
            singular_values=values[::-1],
            motors=motors,
            platform=lengths * (free @ null[moved : moved + free.shape[1]]),
            sign=self._sign(problem),
        )

    def smallest_singular_value(
        self, problem: LinearProblem, characteristic_length: float | None = None
    ) -> float:
        """``singularity(...).smallest``, to a millionth of it, in a fraction of the time.

        From the condensed legs; that of ``inverse_by_effort``, of an inverse problem with redundant
        motors and at a singularity itself is the last of ``singular_values``.
        """
        self._check_problem(problem)
        if problem != "inverse_by_effort":
            inverse = problem == "inverse"
            found = smallest_singular_value(self.equilibrium, inverse, characteristic_length)
            if found > 0.0:
                return found
        return float(self.singular_values(problem, characteristic_length)[0])

    @on_one_numpy_thread
    def singular_values(
        self, problem: LinearProblem, characteristic_length: float | None = None
    ) -> Floats:
        """``singularity(...).singular_values`` without the directions, at a third of the time."""
        matrix, _ = self._problem_matrix(problem, characteristic_length)
        return np.asarray(np.linalg.svd(matrix, compute_uv=False)[::-1], float)

    def _check_problem(self, problem: LinearProblem) -> None:
        """Whether this robot has such a problem.

        Raises:
            InvalidRequest: It has not.
        """
        if checked_word("problem", problem, _PROBLEMS) not in self.problems:
            name = self.equilibrium.robot.description.name
            raise InvalidRequest("problem", no_inverse_problem(name))

    def _problem_matrix(
        self, problem: LinearProblem, characteristic_length: float | None
    ) -> tuple[Floats, Floats]:
        """Dimensionless matrix of a problem, and platform motions it solves for."""
        self._check_problem(problem)
        robot, n = self.equilibrium.robot, self.equilibrium.robot.motor_count
        a, p, e, w = self.matrices(characteristic_length)
        unit = problem_units(robot, characteristic_length).states
        lengths = unit[robot.platform_indices]
        free = self._free_motions(problem, lengths) / lengths[:, None]
        efforts = w[:, n:] if problem == "inverse_by_effort" else w[:, :n]
        return np.hstack([a[:, self._moved(problem)], p @ free, e, -efforts]), free

    def _moved(self, problem: LinearProblem) -> Integers:
        """Numbers of the motors a problem solves for: in the inverse one not those that are held."""
        robot = self.equilibrium.robot
        every = np.arange(0 if problem == "forward" else robot.motor_count)
        return every if problem != "inverse" else np.setdiff1d(every, robot.held_motors)

    def _free_motions(self, problem: LinearProblem, lengths: Floats) -> Floats:
        """Platform motions a problem solves for, as body twists in columns.

        ``lengths`` are the units of the platform coordinates, (platform,).
        """
        robot = self.equilibrium.robot
        axes = robot.platform_axes
        if problem == "forward":
            return np.diag(lengths)
        if problem == "inverse_by_effort":
            return np.zeros((len(axes), 0))
        uncontrolled = ~np.isin(axes, robot.controlled_axes)
        return coordinate_motions(self.equilibrium)[:, uncontrolled] * lengths[uncontrolled]

    def _sign(self, problem: LinearProblem) -> int:
        """Sign of the determinant of the problem's own equations: free of the basis Z; 0: not square."""
        robot, unit = self.equilibrium.robot, self.equilibrium.robot.kernel_arrays.unit
        if problem == "inverse" and robot.redundancy:
            return 0
        inner, platform = robot.kernel_arrays.motor_index, robot.platform_indices
        legs = np.arange(robot.kernel_arrays.platform_index)
        rows, columns = np.arange(inner), [self.body_tangent[:, legs] * unit[legs]]
        columns.append(self.body_tangent[:, platform] @ self._free_motions(problem, unit[platform]))
        if problem != "forward":
            motors = robot.motor_indices[self._moved(problem)]
            columns.append(self.body_tangent[:, motors] * unit[motors])
        if problem == "inverse_by_effort":  # the wrench takes the place of the platform's balance
            rows = np.concatenate([legs, robot.motor_indices])
        matrix = np.hstack(columns)[rows] * unit[rows, None]
        return int(np.linalg.slogdet(matrix)[0])


def coordinate_motions(equilibrium: Equilibrium) -> Floats:
    """Body twists of the platform coordinates of the inverse problem, columns, (platform, platform)."""
    robot = equilibrium.robot
    motions = np.eye(len(robot.platform_axes))
    if robot.controls_angles:
        motions[ANGULAR, ANGULAR] = angle_motions(equilibrium.platform_rotation)
    return platform_turn(equilibrium).T @ motions
