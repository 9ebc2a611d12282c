# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The kinemato-static model of Section V: how a robot moves and pushes to first order.

Everything comes from the tangent the solver uses. Platform increments ``dSigma_p`` and wrench
increments are body vectors at the platform origin (rotation and moment first); in the plane only
their planar components exist.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..blas_threads import on_one_numpy_thread
from ..errors import InvalidRequest
from ..kernels.twist_layout import ANGULAR
from ..lie import angle_motions
from ..validation import ReadOnlyArrays, cached_array, checked_vector, read_only
from .dense_response import body_tangent, platform_turn
from .equilibrium import Equilibrium, check_equilibrium
from .problem_units import ProblemUnits, problem_units
from .smallest_singular_value import smallest_singular_value
from .stability import null_space_of

__all__ = ["Increments", "KinematoStatics", "LinearProblem", "Singularity", "kinemato_statics"]

Floats = NDArray[np.float64]

#: Part of the largest compliance, in radians and rod lengths, below which there is none: rounding is.
_RIGID = 1e-12

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


@dataclass(frozen=True, eq=False)
class Increments(ReadOnlyArrays):
    """Small changes that belong together.

    Attributes:
        motors: dq_a, (n,) [rad or m].
        efforts: dtau_a, (n,) [N m or N].
        platform: dSigma_p, body twist, (platform,) [rad, m].
        wrench: dw_p, body wrench, (platform,) [N m, N].
    """

    motors: Floats
    efforts: Floats
    platform: Floats
    wrench: Floats


@dataclass(frozen=True, eq=False)
class KinematoStatics:
    """First-order behaviour at one equilibrium.

    Attributes:
        equilibrium: Where.
    """

    equilibrium: Equilibrium

    @cached_array
    def tangent(self) -> Floats:
        """Tangent of the model with the platform in body coordinates, in state order, (N, N)."""
        return body_tangent(self.equilibrium)

    @property
    def jacobian(self) -> Floats:
        """Platform Jacobian ``dSigma_p/dq_a``, (platform, n): that of the equilibrium."""
        return self.equilibrium.jacobian

    @property
    def platform_by_wrench(self) -> Floats:
        """Compliance ``dSigma_p/dw_p`` with the motors held, (platform, platform)."""
        return self.equilibrium.response.platform_by_wrench

    @property
    def legs_by_motors(self) -> Floats:
        """Leg coordinates per motor increment, ``dq_e/dq_a``, (n_e, n)."""
        robot = self.equilibrium.robot
        return self.equilibrium.dense_response.moved[robot.elastic_indices, : robot.motor_count]

    @property
    def multipliers_by_motors(self) -> Floats:
        """Multipliers per motor increment, Eq. (41), (n_Psi, n)."""
        robot = self.equilibrium.robot
        return self.equilibrium.dense_response.moved[robot.multiplier_indices, : robot.motor_count]

    @property
    def efforts_by_motors(self) -> Floats:
        """Effort sensitivity ``dtau_a/dq_a`` at constant loads, (n, n)."""
        return self.equilibrium.response.efforts_by_motors

    @property
    def efforts_by_wrench(self) -> Floats:
        """Effort sensitivity ``dtau_a/dw_p`` with the motors held, (n, platform)."""
        return self.equilibrium.response.efforts_by_wrench

    def predict_forward(self, motors: ArrayLike, wrench: ArrayLike | None = None) -> Increments:
        """Eq. (45): motor and wrench increments given.

        Args:
            motors: dq_a, (n,).
            wrench: dw_p, body wrench, (platform,); default none.

        Raises:
            InvalidRequest: A vector of the wrong length.
        """
        given, load = self._given_motors(motors), self._given_platform("wrench", wrench)
        return Increments(
            motors=given,
            efforts=self.efforts_by_motors @ given + self.efforts_by_wrench @ load,
            platform=self.jacobian @ given + self.platform_by_wrench @ load,
            wrench=load,
        )

    def predict_inverse(self, platform: ArrayLike, wrench: ArrayLike | None = None) -> Increments:
        """Controlled platform and wrench increments given; the motors follow, as little as possible.

        With more motors than controlled coordinates the sum of squares of the motor increments, in
        radians and rod lengths, is least; ``self_motions`` may be added.

        Args:
            platform: dSigma_p, body twist, (platform,); only the controlled coordinates are read.
            wrench: dw_p, body wrench, (platform,); default none.

        Raises:
            InvalidRequest: A vector of the wrong length, or an inverse singularity.
        """
        wanted = self._given_platform("platform", platform)
        load = self._given_platform("wrench", wrench)
        rest = self._controlled @ (wanted - self.platform_by_wrench @ load)
        return self.predict_forward(self.motors_by_pose @ rest, load)

    @cached_array
    def motors_by_pose(self) -> Floats:
        """``dq_a`` by the controlled coordinates, wrench held, (n, controlled).

        Coordinates in the order of ``robot.platform_axes``, whatever that of the description: turns
        about the axes of the world, or single angles roll, pitch and yaw; then positions in the world.
        With more motors than coordinates the sum of squares of the motor increments, in radians and rod
        lengths, is least.

        Raises:
            InvalidRequest: An inverse singularity, or a robot that controls no coordinates.
        """
        scale = self.equilibrium.robot.motor_units
        jacobian = self._controlled @ self.jacobian * scale
        rows, columns = jacobian.shape
        if not 0 < rows <= columns or np.linalg.cond(jacobian) > 1e12:
            raise InvalidRequest(
                "platform", "expected a regular inverse problem, this is an inverse singularity"
            )
        return np.asarray(scale[:, None] * np.linalg.pinv(jacobian))

    @cached_array
    def self_motions(self) -> Floats:
        """Motor motions that leave the controlled coordinates where they are, (n, redundancy).

        Columns in rad and m, orthonormal in radians and rod lengths behind gears; none where there are
        no more motors than controlled coordinates.
        """
        robot = self.equilibrium.robot
        if robot.redundancy == 0:
            return np.zeros((robot.motor_count, 0))
        scale = robot.motor_units
        _, _, directions = np.linalg.svd(self._controlled @ self.jacobian * scale)
        return np.asarray(scale[:, None] * directions[len(robot.controlled_axes) :].T)

    @cached_property
    def _controlled(self) -> Floats:
        """Rates of the controlled coordinates by the body twist, (controlled, platform)."""
        robot = self.equilibrium.robot
        held = np.isin(robot.platform_axes, robot.controlled_axes)
        return np.asarray(np.linalg.inv(self._coordinate_motions())[held])

    def solve(
        self,
        *,
        motors: ArrayLike | None = None,
        platform: ArrayLike | None = None,
        efforts: ArrayLike | None = None,
        wrench: ArrayLike | None = None,
    ) -> Increments:
        """Eq. (42) for any admissible choice of given increments.

        Args:
            motors: dq_a, (n,).
            platform: dSigma_p, body twist, (platform,).
            efforts: dtau_a, (n,).
            wrench: dw_p, body wrench, (platform,).

        In each, NaN stands for a number to be found; so does a vector that is not given. As many
        numbers have to be given as there are motors and platform coordinates.

        Raises:
            InvalidRequest: Wrong lengths, too many or too few numbers, or a singular choice.
        """
        robot = self.equilibrium.robot
        n, size = robot.motor_count, len(robot.platform_axes)
        own = problem_units(robot, None)
        unit, energy_unit = own.states, own.energy
        units = np.concatenate([unit[robot.motor_indices], unit[robot.platform_indices]])
        units = np.concatenate([units, energy_unit / units])
        parts = []
        for name, values, length in (
            ("motors", motors, n),
            ("platform", platform, size),
            ("efforts", efforts, n),
            ("wrench", wrench, size),
        ):
            try:
                part = np.full(length, np.nan) if values is None else np.array(values, dtype=float)
            except (TypeError, ValueError):
                part = np.full(0, np.nan)
            if part.shape != (length,) or np.any(np.isinf(part)):
                raise InvalidRequest(name, f"expected {length} numbers or NaN, got {values!r:.200}")
            parts.append(part)
        given = np.concatenate(parts) / units
        unknown = np.isnan(given)
        if unknown.sum() != n + size:
            raise InvalidRequest(
                "increments",
                f"expected {n + size} given numbers, one per motor and platform coordinate, "
                f"got {int((~unknown).sum())}",
            )
        a, p, e, w = self.matrices()
        columns = np.hstack([a, p, -w])
        matrix = np.hstack([columns[:, unknown], e])
        if np.linalg.cond(matrix) > 1e12:
            raise InvalidRequest("increments", "these do not determine the others (a singularity)")
        found = scipy.linalg.solve(matrix, -columns[:, ~unknown] @ given[~unknown])
        given[unknown] = found[: n + size]
        ends = np.cumsum([n, size, n])
        moved, turned, pushed, loaded = np.split(given * units, ends)
        return Increments(motors=moved, platform=turned, efforts=pushed, wrench=loaded)

    def _given_motors(self, values: ArrayLike) -> Floats:
        names = self.equilibrium.robot.motor_names
        return checked_vector("motors", values, len(names), " ".join(names))

    def _given_platform(self, name: str, values: ArrayLike | None) -> Floats:
        size = len(self.equilibrium.robot.platform_axes)
        return np.zeros(size) if values is None else checked_vector(name, values, size)

    def compliance(self, motor_stiffness: ArrayLike | None = None) -> Floats:
        """Compliance ``dSigma_p/dw_p`` of the platform, (platform, platform).

        Args:
            motor_stiffness: Stiffness of the motors' position loops, ``dtau_a = -k dq_a``, (n,)
                [N m/rad or N/m]; None: motors held; zeros: motors at constant effort.
        """
        if motor_stiffness is None:
            return self.platform_by_wrench
        robot = self.equilibrium.robot
        stiffness = checked_vector("motor_stiffness", motor_stiffness, robot.motor_count)
        if np.any(stiffness < 0.0):
            raise InvalidRequest(
                "motor_stiffness", f"expected numbers of at least 0, got {stiffness.tolist()}"
            )
        yielding = self.efforts_by_motors + np.diag(stiffness)
        # Some motors may be ever so stiff and others soft: each in a unit of its own.
        unit = 1.0 / np.sqrt(np.maximum(np.abs(yielding).max(axis=1), np.finfo(float).tiny))
        moved = np.linalg.solve(
            yielding * unit[:, None] * unit, unit[:, None] * self.efforts_by_wrench
        )
        return self.platform_by_wrench - self.jacobian @ (unit[:, None] * moved)

    def stiffness(self, motor_stiffness: ArrayLike | None = None) -> Floats:
        """Stiffness ``dw_p/dSigma_p``, the inverse of :meth:`compliance`.

        Args:
            motor_stiffness: As for :meth:`compliance`.

        Raises:
            InvalidRequest: The platform cannot move in some direction, as a rigid leg holds it or rods
                that are straight: there is no stiffness. Or no stiffness of motors.
        """
        robot, compliance = self.equilibrium.robot, self.compliance(motor_stiffness)
        unit = robot.arrays.unit[robot.platform_indices]
        scaled = compliance / unit[:, None] / unit
        directions, values, _ = np.linalg.svd(scaled)
        if values[-1] <= _RIGID * values[0]:
            way = ", ".join(f"{part:.3g}" for part in unit * directions[:, -1])
            raise InvalidRequest(
                "stiffness",
                f"expected a platform that can move, this one cannot along its twist [{way}] "
                "(turn, then shift, in its frame): the compliance is singular",
            )
        return np.asarray(np.linalg.inv(scaled) / unit[:, None] / unit, float)

    def matrices(
        self, characteristic_length: float | None = None
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """A, P, E, W of Eqs. (42)-(43), dimensionless.

        ``A dq_a + P dSigma_p + E dq_e = W [dtau_a; dw_p]``: the sign of W is that of efforts and
        wrenches acting on the robot. Rotations count in radians, lengths in the characteristic
        length, energies in E J / length, and strains in the inverse of that length by their L2 norm
        along the rod: E is by coordinates that are orthonormal so. Singular values then depend neither
        on the strain basis nor, once they converge, on the number of modes.

        Args:
            characteristic_length: [m]; default the mean rod length.
        """
        units = problem_units(self.equilibrium.robot, characteristic_length)
        if units.energy not in self._known_matrices:
            self._known_matrices[units.energy] = self._matrices(units)
        return self._known_matrices[units.energy]

    @cached_property
    def _known_matrices(self) -> dict[float, tuple[Floats, Floats, Floats, Floats]]:
        """By the unit of energy, which tells the lengths apart: every problem takes the same."""
        return {}

    def _matrices(self, units: ProblemUnits) -> tuple[Floats, Floats, Floats, Floats]:
        robot, motions = self.equilibrium.robot, units.motions
        moving = np.concatenate(
            [robot.motor_indices, robot.elastic_indices, robot.platform_indices]
        )
        scaled = motions.T @ self.tangent @ motions / units.energy
        jacobian = scaled[np.ix_(robot.multiplier_indices, moving)]
        null_space = null_space_of(jacobian)
        stacked = read_only(np.vstack([null_space.T @ scaled[np.ix_(moving, moving)], jacobian]))
        n, last = robot.motor_count, len(moving) - len(robot.platform_indices)
        loads = np.zeros((len(moving), n + len(robot.platform_indices)))
        loads[:n, :n] = np.eye(n)
        loads[last:, n:] = np.eye(len(robot.platform_indices))
        unloaded = np.zeros((len(jacobian), loads.shape[1]))
        right = read_only(np.vstack([null_space.T @ loads, unloaded]))
        return stacked[:, :n], stacked[:, last:], stacked[:, n:last], right

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
        matrix, free, moved = self._problem_matrix(problem, characteristic_length)
        unit = problem_units(robot, characteristic_length).states
        _, values, directions = np.linalg.svd(matrix, full_matrices=False)
        null = directions[-1]
        motors = np.zeros(n)
        motors[:moved] = null[:moved] * unit[robot.motor_indices][:moved]
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
        matrix, _, _ = self._problem_matrix(problem, characteristic_length)
        return np.asarray(np.linalg.svd(matrix, compute_uv=False)[::-1], float)

    def _check_problem(self, problem: LinearProblem) -> None:
        """Whether this robot has such a problem.

        Raises:
            InvalidRequest: It has not.
        """
        if not isinstance(problem, str) or problem not in _PROBLEMS:
            raise InvalidRequest(
                "problem", f"expected {', '.join(_PROBLEMS)}, got {problem!r:.200}"
            )
        if problem not in self.problems:
            raise InvalidRequest(
                "problem",
                f"{self.equilibrium.robot.description.name} has no inverse problem: it controls no "
                "platform coordinates",
            )

    def _problem_matrix(
        self, problem: LinearProblem, characteristic_length: float | None
    ) -> tuple[Floats, Floats, int]:
        """Dimensionless matrix of a problem, platform motions it solves for, motors it solves for."""
        self._check_problem(problem)
        robot, n = self.equilibrium.robot, self.equilibrium.robot.motor_count
        a, p, e, w = self.matrices(characteristic_length)
        unit = problem_units(robot, characteristic_length).states
        lengths = unit[robot.platform_indices]
        free = self._free_motions(problem, lengths) / lengths[:, None]
        moved = 0 if problem == "forward" else n
        efforts = w[:, n:] if problem == "inverse_by_effort" else w[:, :n]
        return np.hstack([a[:, :moved], p @ free, e, -efforts]), free, moved

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
        return self._coordinate_motions()[:, uncontrolled] * lengths[uncontrolled]

    def _coordinate_motions(self) -> Floats:
        """Body twists of the platform coordinates of the inverse problem, as columns."""
        equilibrium, robot = self.equilibrium, self.equilibrium.robot
        motions = np.eye(len(robot.platform_axes))
        if robot.controls_angles:
            motions[ANGULAR, ANGULAR] = angle_motions(equilibrium.platform_rotation)
        return platform_turn(equilibrium).T @ motions

    def _sign(self, problem: LinearProblem) -> int:
        """Sign of the determinant of the problem's own equations: free of the basis Z; 0: not square."""
        robot, unit = self.equilibrium.robot, self.equilibrium.robot.arrays.unit
        if problem == "inverse" and robot.redundancy:
            return 0
        inner, platform = robot.arrays.motor_index, robot.platform_indices
        legs = np.arange(robot.arrays.platform_index)
        rows, columns = np.arange(inner), [self.tangent[:, legs] * unit[legs]]
        columns.append(self.tangent[:, platform] @ self._free_motions(problem, unit[platform]))
        if problem != "forward":
            motors = robot.motor_indices
            columns.append(self.tangent[:, motors] * unit[motors])
        if problem == "inverse_by_effort":  # the wrench takes the place of the platform's balance
            rows = np.concatenate([legs, robot.motor_indices])
        matrix = np.hstack(columns)[rows] * unit[rows, None]
        return int(np.linalg.slogdet(matrix)[0])


def kinemato_statics(equilibrium: Equilibrium) -> KinematoStatics:
    """The kinemato-static model at an equilibrium, Eqs. (35)-(46).

    Raises:
        InvalidRequest: No equilibrium.
    """
    check_equilibrium(equilibrium)
    return KinematoStatics(equilibrium)
