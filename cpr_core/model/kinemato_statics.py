# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The kinemato-static model of Section V: how a robot moves and pushes to first order.

Everything comes from the tangent the solver uses. Platform increments ``dSigma_p`` and wrench
increments are body vectors at the platform origin (rotation and moment first); in the plane only
their planar components exist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..description.controlled_coordinates import no_inverse_problem
from ..errors import InvalidRequest
from ..validation import (
    ReadOnlyArrays,
    cached_array,
    cached_property,
    checked_floats,
    checked_vector,
)
from .equilibrium import Equilibrium, check_equilibrium
from .linear_problems import LinearProblems, coordinate_motions
from .problem_units import problem_units

__all__ = ["Increments", "KinematoStatics", "kinemato_statics"]

Floats = NDArray[np.float64]

#: Compliance below this part of the largest one, and of that of a rod across itself, is rounding: in
#: such a direction the platform is rigid [radians, rod lengths].
_RIGID = 1e-12
#: Condition number, in problem units, beyond which what is found is rounding.
_SINGULAR = 1e12
#: Stiffness of the motors, in problem units, above which they surely hold: no rounding is as large.
_HELD = 1e-6


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
class KinematoStatics(LinearProblems):
    """First-order behaviour at one equilibrium, and how near its linear problems are to singularities.

    Attributes:
        equilibrium: Where.
    """

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
        radians and rod lengths, is least; ``self_motions`` may be added. Motors that are held stay.

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
        lengths, is least; motors that are held stay.

        Raises:
            InvalidRequest: An inverse singularity, or a robot that controls no coordinates.
        """
        description = self.equilibrium.robot.description
        if not description.controlled:
            raise InvalidRequest("platform", no_inverse_problem(description.name))
        scale = self.equilibrium.robot.motor_units.copy()
        scale[list(self.equilibrium.robot.held_motors)] = 0.0
        jacobian = self._controlled @ self.jacobian * scale
        rows, columns = jacobian.shape
        if not 0 < rows <= columns or np.linalg.cond(jacobian) > _SINGULAR:
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
        return np.asarray(np.linalg.inv(coordinate_motions(self.equilibrium))[held])

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
            expected = f"expected {length} numbers or NaN"
            part = (
                np.full(length, np.nan)
                if values is None
                else checked_floats(name, values, expected)
            )
            if part.shape != (length,) or np.any(np.isinf(part)):
                raise InvalidRequest(name, f"{expected}, got {values!r:.200}")
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
        if np.linalg.cond(matrix) > _SINGULAR:
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

        Raises:
            InvalidRequest: No stiffness of motors, or they do not hold the robot, which then moves
                without any force.
        """
        if motor_stiffness is None:
            return self.platform_by_wrench
        robot = self.equilibrium.robot
        stiffness = checked_vector("motor_stiffness", motor_stiffness, robot.motor_count)
        if np.any(stiffness < 0.0):
            raise InvalidRequest(
                "motor_stiffness", f"expected numbers of at least 0, got {stiffness.tolist()}"
            )
        self._check_held(stiffness)
        yielding = self.efforts_by_motors + np.diag(stiffness)
        # Some motors may be ever so stiff and others soft: each in a unit of its own.
        unit = 1.0 / np.sqrt(np.maximum(np.abs(yielding).max(axis=1), np.finfo(float).tiny))
        moved = np.linalg.solve(
            yielding * unit[:, None] * unit, unit[:, None] * self.efforts_by_wrench
        )
        return self.platform_by_wrench - self.jacobian @ (unit[:, None] * moved)

    def _check_held(self, stiffness: Floats) -> None:
        """Whether motors whose position loops have a stiffness hold the robot, (n,) [N m/rad or N/m].

        Raises:
            InvalidRequest: They do not.
        """
        robot, n = self.equilibrium.robot, self.equilibrium.robot.motor_count
        own = problem_units(robot, None)
        unit = own.states[robot.motor_indices]
        loops = stiffness * unit / own.energy * unit
        yielding = self.efforts_by_motors * unit[:, None] / own.energy * unit
        if np.linalg.svd(yielding + np.diag(loops), compute_uv=False)[-1] > _HELD:
            return
        # The efforts are differences of what may be large: they do not tell rounding from what is soft.
        a, p, e, w = self.matrices()
        scale = 1.0 / np.maximum(loops, 1.0)
        matrix = np.hstack([a * scale + w[:, :n] * (loops * scale), p, e])
        _, values, directions = np.linalg.svd(matrix)
        if values[-1] * _SINGULAR > values[0]:
            return
        motors = _told(scale * unit * directions[-1, :n])
        twist = own.states[robot.platform_indices] * directions[-1, n : n + p.shape[1]]
        raise InvalidRequest(
            "motor_stiffness",
            f"expected motors that hold the robot: with these its motors move by [{motors}], and its "
            f"platform along its twist [{_told(twist)}] (turn, then shift, in its frame), without any "
            "force (a singularity)",
        )

    def stiffness(self, motor_stiffness: ArrayLike | None = None) -> Floats:
        """Stiffness ``dw_p/dSigma_p``, the inverse of :meth:`compliance`.

        Args:
            motor_stiffness: As for :meth:`compliance`.

        Raises:
            InvalidRequest: The platform cannot move in some direction, as a rigid leg holds it or rods
                that are straight: there is no stiffness. Or it moves without any force, or hardly any
                beside what it takes in other directions. Or no stiffness of motors.
        """
        robot, compliance = self.equilibrium.robot, self.compliance(motor_stiffness)
        unit = robot.kernel_arrays.unit[robot.platform_indices]
        scaled = compliance / unit[:, None] / unit
        of_rod = 1.0 / problem_units(robot, None).energy
        directions, values, _ = np.linalg.svd(scaled)
        if values[-1] <= _RIGID * max(values[0], of_rod):
            held = max(np.abs(self.platform_by_wrench / unit[:, None] / unit).max(), of_rod)
            problem, way = "a platform that can move, this one cannot", directions[:, -1]
            if values[-1] > _RIGID * held:
                problem, way = "motors that hold the platform, it moves freely", directions[:, 0]
            raise InvalidRequest(
                "stiffness",
                f"expected {problem} along its twist [{_told(unit * way)}] "
                "(turn, then shift, in its frame): the compliance is singular",
            )
        return np.asarray(np.linalg.inv(scaled) / unit[:, None] / unit, float)


def _told(direction: Floats) -> str:
    """A direction in few digits, its rounding as zeros."""
    rounding = 1e-9 * np.abs(direction).max(initial=0.0)
    return ", ".join(f"{part if abs(part) > rounding else 0.0:.3g}" for part in direction.tolist())


def kinemato_statics(equilibrium: Equilibrium) -> KinematoStatics:
    """The kinemato-static model at an equilibrium, Eqs. (35)-(46).

    Raises:
        InvalidRequest: No equilibrium.
    """
    check_equilibrium(equilibrium)
    return KinematoStatics(equilibrium)
