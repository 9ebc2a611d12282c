# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The paper's procedure taken literally: Mod. #0, the baseline of the timings.

For every leg the differential equation (11) (quaternion, position and J_3) is integrated by an
adaptive Runge-Kutta 4(5) with the tolerances of ode45, then Eq. (32) is assembled and solved for
q_e, tau_a, lambda and the platform by the Levenberg-Marquardt method with initial damping 0.1 and
the analytic Jacobian. That needs dJ_3/dq_e, integrated together with (11):

    (J_3)_a' = Ad_g B Phi_a,   d(J_3)_a'/dq_b = ad_(J_3)_b Ad_g B Phi_a

because the columns of J_3 are the twists, in the world, of the variations of g. Loads are left out:
the case studies have none, and so are the rows of (11) that would integrate them.

Twists and wrenches of rods and platform are body vectors as in the paper; multipliers are forces in
the frame of the rod's tip.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg
from scipy.integrate import solve_ivp

from ..description.joints import RevoluteJoint, Spherical
from ..description.leg_description import LegDescription
from ..kernels.square_problem import RESIDUAL_TOLERANCE
from ..lie import quaternion_from_rotation, rotation_exp, skew
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.not_reached import NoForwardSolution
from ..validation import checked_vector
from .shooting_robot import check_leg, check_unloaded

__all__ = ["LiteralEquilibrium", "follow_literally", "solve_literally"]

Floats = NDArray[np.float64]

#: Tolerances of ode45 by default.
RELATIVE, ABSOLUTE = 1e-3, 1e-6
#: Damping of Levenberg and Marquardt at the start, and its factor from step to step.
DAMPING, DAMPING_FACTOR = 0.1, 10.0
ITERATIONS = 200


def _structure() -> Floats:
    """Structure constants of ad: ``ad_x = sum_k x_k [k]``, (6, 6, 6)."""
    constants = np.zeros((6, 6, 6))
    for k in range(3):
        turn = skew(np.eye(3)[k])
        constants[k, :3, :3] = constants[k, 3:, 3:] = turn
        constants[3 + k, 3:, :3] = turn
    return constants


_AD = _structure().reshape(6, 36)


def _rotation(h: Floats) -> Floats:
    w, x, y, z = h.tolist()
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def _ad(twists: Floats) -> Floats:
    """Operator ad of every column, (m, 6, 6)."""
    return (twists.T @ _AD).reshape(-1, 6, 6)


@dataclass(frozen=True, eq=False)
class _Tip:
    """End of a leg: pose, twists by motor and strain in the tip frame, and their derivatives."""

    rotation: Floats
    position: Floats
    by_motor: Floats  # J_1 J_a, (6,)
    by_strain: Floats  # J_2, (6, m)
    motor_change: Floats  # d(J_1 J_a)/dq_e, (m, 6)
    strain_change: Floats  # d(J_2)_a/dq_b, (m by b, 6, m by a)


def _integrate(leg: LegDescription, motor: float, strain: Floats) -> _Tip:
    """Eq. (11) from base to tip."""
    count = leg.modes.total
    directions = leg.modes.directions
    base = leg.base_at(motor)
    length = leg.rod.length
    first_j3, first_change = 7, 7 + 6 * count
    phi = np.zeros((3, count))
    each = np.arange(count)
    twists = np.zeros((6, count))
    place = -1.0

    def rates(s: float, y: Floats) -> Floats:
        nonlocal place
        if s != place:  # the last two stages of a step are at the same place
            phi[directions, each] = leg.modes.values(np.array([s / length]))[0]
            place = s
        kx, ky, kz = (phi @ strain).tolist()
        w, x, y_, z = y[:4].tolist()
        rotation = _rotation(y[:4])
        p = y[4:7].tolist()
        turns = rotation @ phi
        twists[:3] = turns  # Ad_g B Phi
        twists[3] = p[1] * turns[2] - p[2] * turns[1]
        twists[4] = p[2] * turns[0] - p[0] * turns[2]
        twists[5] = p[0] * turns[1] - p[1] * turns[0]
        rate = np.empty_like(y)
        rate[:4] = (
            -0.5 * (x * kx + y_ * ky + z * kz),
            0.5 * (w * kx + y_ * kz - z * ky),
            0.5 * (w * ky + z * kx - x * kz),
            0.5 * (w * kz + x * ky - y_ * kx),
        )
        rate[4:7] = rotation[:, 0]
        rate[first_j3:first_change] = twists.ravel()
        j3 = y[first_j3:first_change].reshape(6, count)
        rate[first_change:] = (_ad(j3).reshape(-1, 6) @ twists).ravel()  # one product, not m
        return rate

    start = np.zeros(7 + 6 * count + 6 * count * count)
    start[:4], start[4:7] = quaternion_from_rotation(base.rotation), base.position
    y = solve_ivp(rates, (0.0, length), start, "RK45", rtol=RELATIVE, atol=ABSOLUTE).y[:, -1]
    rotation, position = _rotation(y[:4]), y[4:7]
    j3 = y[first_j3:first_change].reshape(6, count)
    change = y[first_change:].reshape(count, 6, count)
    inverse = np.zeros((6, 6))  # Ad_g^-1
    inverse[:3, :3] = inverse[3:, 3:] = rotation.T
    inverse[3:, :3] = -rotation.T @ skew(position)
    axis: Floats = np.array(leg.motor.axis, np.float64)  # type: ignore[attr-defined]
    motor_twist = np.concatenate([axis, np.cross(leg.base_position, axis)])  # Ad_g0 J_a
    turned = _ad(j3)
    return _Tip(
        rotation=rotation,
        position=position,
        by_motor=inverse @ motor_twist,
        by_strain=inverse @ j3,
        motor_change=-(turned @ motor_twist) @ inverse.T,
        # d(Ad_g^-1) = -Ad_g^-1 ad of the variation
        strain_change=inverse @ (change - turned @ j3),
    )


@dataclass(frozen=True, eq=False)
class LiteralEquilibrium:
    """An equilibrium of the paper's procedure.

    Attributes:
        robot: The robot.
        motors: Motor positions q_a, (n,) [rad].
        strain: Strain coordinates q_e leg by leg, (n_e,) [1/m].
        efforts: Motor efforts tau_a, with the paper's sign, (n,) [N m].
        multipliers: Forces lambda in the tip frames leg by leg, (n_Psi,) [N].
        platform_rotation: R_p, (3, 3).
        platform_position: p_p, (3,) [m].
        residual: Largest dimensionless residual.
        iterations: Levenberg-Marquardt steps tried.
        jacobian: Of all K equations by (q_e, tau_a, lambda, Sigma_p), (K, K).
        by_motors: Of all equations by q_a, (K, n).
    """

    robot: Robot
    motors: Floats
    strain: Floats
    efforts: Floats
    multipliers: Floats
    platform_rotation: Floats
    platform_position: Floats
    residual: float = np.inf
    iterations: int = 0
    jacobian: Floats = field(repr=False, default_factory=lambda: np.zeros((0, 0)))
    by_motors: Floats = field(repr=False, default_factory=lambda: np.zeros((0, 0)))


def _evaluate(at: LiteralEquilibrium) -> tuple[Floats, Floats, Floats]:
    """Eq. (32): residual, derivative by the unknowns, derivative by the motors."""
    robot, legs = at.robot, at.robot.description.legs
    axes = robot.kernel_arrays.position_axes
    n, held = len(legs), len(axes)
    elastic, free = len(at.strain), robot.platform_axes
    # Rows: motors, elastic, platform, constraints. Columns: q_e, tau_a, lambda, Sigma_p.
    rows_e, rows_p, rows_c = n, n + elastic, n + elastic + len(free)
    size = rows_c + n * held
    residual, jacobian, by_motors = np.zeros(size), np.zeros((size, size)), np.zeros((size, n))
    column_l, column_p = elastic + n, elastic + n + n * held
    platform, by_platform = np.zeros(6), np.zeros((6, 6))
    first = 0
    for i, leg in enumerate(legs):
        count = leg.modes.total
        strain, span = at.strain[first : first + count], slice(first, first + count)
        tip = _integrate(leg, float(at.motors[i]), strain)
        # Constraints in the frame of the tip; in the plane its d1 and d2 span x and y.
        multiplier = np.zeros(3)
        multiplier[:held] = at.multipliers[held * i : held * i + held]
        columns = slice(column_l + held * i, column_l + held * i + held)
        rows = slice(rows_c + held * i, rows_c + held * i + held)
        linear, angular = tip.by_strain[3:], tip.by_strain[:3]

        residual[i] = at.efforts[i] + tip.by_motor[3:] @ multiplier  # Eq. (33)
        jacobian[i, elastic + i] = 1.0
        jacobian[i, span] = tip.motor_change[:, 3:] @ multiplier
        jacobian[i, columns] = tip.by_motor[3 : 3 + held]

        stiffness = leg.rod.stiffness(leg.modes, robot.grid)
        own = slice(rows_e + first, rows_e + first + count)
        residual[own] = stiffness @ strain + linear.T @ multiplier  # Eq. (34)
        jacobian[own, span] = stiffness + (multiplier @ tip.strain_change[:, 3:]).T
        jacobian[own, columns] = linear.T[:, :held]

        rotation = at.platform_rotation.T @ tip.rotation
        joint = np.array(leg.joint.position, float)
        arm, force = skew(joint), rotation @ multiplier
        lever = np.vstack([arm, np.eye(3)])  # force at B_i to wrench at P
        platform -= lever @ force  # Eq. (30)
        by_platform[:, :3] -= lever @ skew(force)
        jacobian[rows_p:rows_c, columns] = -(lever @ rotation)[free][:, :held]
        turned = rotation @ skew(multiplier)
        jacobian[rows_p:rows_c, span] = (lever @ turned @ angular)[free]
        by_motors[rows_p:rows_c, i] = (lever @ turned @ tip.by_motor[:3])[free]

        gap = at.platform_position + at.platform_rotation @ joint - tip.position  # Eq. (15)
        residual[rows] = gap[axes]
        moved = at.platform_rotation @ np.hstack([-arm, np.eye(3)])
        jacobian[rows, column_p:] = moved[np.ix_(axes, free)]
        jacobian[rows, span] = -(tip.rotation @ linear)[axes]
        by_motors[rows, i] = -(tip.rotation @ tip.by_motor[3:])[axes]
        first += count
    residual[rows_p:rows_c] = platform[free]
    jacobian[rows_p:rows_c, column_p:] = by_platform[np.ix_(free, free)]
    return residual, jacobian, by_motors


def _moved(at: LiteralEquilibrium, step: Floats) -> LiteralEquilibrium:
    ends = np.cumsum([len(at.strain), len(at.efforts), len(at.multipliers)])
    strain, efforts, multipliers, platform = np.split(step, ends)
    twist = np.zeros(6)
    twist[at.robot.platform_axes] = platform
    return replace(
        at,
        strain=at.strain + strain,
        efforts=at.efforts + efforts,
        multipliers=at.multipliers + multipliers,
        platform_rotation=at.platform_rotation @ rotation_exp(twist[:3]),
        platform_position=at.platform_position + at.platform_rotation @ twist[3:],
    )


def _levenberg_marquardt(at: LiteralEquilibrium) -> LiteralEquilibrium:
    """The damping falls after a step that reduces the residual and rises after one that does not."""
    length = at.robot.mean_length
    energy = float(np.mean([leg.rod.rigidities[2] for leg in at.robot.description.legs])) / length
    unit = np.full(len(at.strain) + len(at.efforts) + len(at.multipliers), energy)
    unit[len(at.efforts) : len(at.efforts) + len(at.strain)] = energy * length
    rows_p = len(at.efforts) + len(at.strain)
    platform = [energy if axis < 3 else energy / length for axis in at.robot.platform_axes]
    unit = np.concatenate([unit[:rows_p], platform, np.full(len(at.multipliers), length)])

    damping = DAMPING
    residual, jacobian, by_motors = _evaluate(at)
    for iteration in range(ITERATIONS):
        largest = float(np.abs(residual / unit).max())
        if largest < RESIDUAL_TOLERANCE:
            solved = replace(at, residual=largest, iterations=iteration)
            return replace(solved, jacobian=jacobian, by_motors=by_motors)
        normal = jacobian.T @ jacobian
        normal[np.diag_indices_from(normal)] += damping
        trial = _moved(at, -linalg.solve(normal, jacobian.T @ residual, assume_a="pos"))
        ahead = _evaluate(trial)
        if np.linalg.norm(ahead[0]) < np.linalg.norm(residual):
            at, (residual, jacobian, by_motors) = trial, ahead
            damping /= DAMPING_FACTOR
        else:
            damping *= DAMPING_FACTOR
    raise NoForwardSolution(
        f"literal procedure: residual {largest:.1e} after {ITERATIONS} steps", 0.0, None
    )


def solve_literally(equilibrium: Equilibrium) -> LiteralEquilibrium:
    """Solve Eq. (32) by the paper's procedure at the motor positions of an equilibrium.

    Args:
        equilibrium: The initial guess.

    Raises:
        InvalidRequest: A robot or a load this procedure is not written out for.
        NoForwardSolution: The method of Levenberg and Marquardt does not reach the tolerance.
    """
    robot, loads = equilibrium.robot, equilibrium.loads
    legs = robot.description.legs
    for leg in legs:
        check_leg(leg, RevoluteJoint if robot.planar else Spherical)
    check_unloaded(robot, loads)
    axes = robot.kernel_arrays.position_axes
    forces = np.zeros((len(legs), 3))
    forces[:, axes] = equilibrium.multipliers.reshape(-1, len(axes))
    strain = equilibrium.leg_coordinates
    first, multipliers = 0, []
    for leg, angle, force in zip(legs, equilibrium.motors, forces, strict=True):
        tip = _integrate(leg, float(angle), strain[first : first + leg.modes.total])
        first += leg.modes.total
        # What acts on the rod there is the opposite of the paper's reaction.
        multipliers.append(-(tip.rotation.T @ force)[: len(axes)])
    return _levenberg_marquardt(
        LiteralEquilibrium(
            robot=robot,
            motors=equilibrium.motors,
            strain=strain,
            efforts=-equilibrium.efforts,
            multipliers=np.concatenate(multipliers),
            platform_rotation=equilibrium.platform_rotation,
            platform_position=equilibrium.platform_position,
        )
    )


def follow_literally(
    start: LiteralEquilibrium, motors: ArrayLike
) -> tuple[LiteralEquilibrium, ...]:
    """Forward problem along a path of motor positions, predicted by the Jacobian.

    Args:
        start: Equilibrium to start from.
        motors: Motor positions one after the other, (K, n) [rad].

    Raises:
        InvalidRequest: Wrong number of motors.
        NonFiniteInput: A NaN or an infinity.
        NoForwardSolution: The method of Levenberg and Marquardt does not reach the tolerance.
    """
    last, points = start, []
    for target in np.asarray(motors):
        goal = checked_vector("motors", target, len(start.motors))
        step = -linalg.solve(last.jacobian, last.by_motors @ (goal - last.motors))
        last = _levenberg_marquardt(replace(_moved(last, step), motors=goal))
        points.append(last)
    return tuple(points)
