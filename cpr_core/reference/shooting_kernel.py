# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shooting along continuous rods, compiled from the integration to the path of a whole robot.

The legs are Kirchhoff rods as in ``rod_integration``, but of circular stiffness: with E J_2 = E J_3
the equation of the tangent, t' = m x t / E J, needs neither frames nor the torsion, which leaves
p, t, m (9 numbers, in the plane x, y, angle, m) to integrate. Their variations by the base moment,
the base force and the motor are integrated together with them, so the Jacobian is exact.

Every leg gives its base wrench in terms of platform and motor increments; what is left is a system
of the platform's size. All quantities are dimensionless: lengths in rod lengths l, moments in
E J / l, forces in E J / l^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.natural_units import LONGEST_STEP
from .reference_decorators import reference, reference_part

__all__ = ["Shooting", "ShootingState", "balance", "shoot_along", "shoot_at"]

Floats = NDArray[np.float64]

#: Smallest part of a longest step before giving up.
SMALLEST_STEP = 1e-4
#: Newton corrections of a step; each must be smaller than this times the one before.
CORRECTIONS = 12
CONTRACTION = 0.5
#: Columns of the variations: three by the base moment, three by the base force, the motor, a filler;
#: in the plane by moment, force and motor. Before them are p, t and m, or x, y, angle and m.
COLUMNS, FIRST = 8, 9
PLANAR_COLUMNS, PLANAR_FIRST = 4, 4


class Shooting(NamedTuple):
    """A robot as the shooting sees it, dimensionless.

    Attributes:
        planar: Whether everything stays in the plane z = 0.
        base_position: Bases in the world, (L, 3).
        base_tangent: Tangents at the bases with the motors at zero, (L, 3).
        motor_axis: Motor axes in the world, (L, 3).
        tip_position: Tip joints in the platform frame, (L, 3).
        length: Rod lengths, (L,).
        stiffness: E J, (L,).
        distributed: Force per length on the rods, in the world, (L, 3).
        platform_loads: Weight, centre of mass in the platform frame, moment and force fixed in
            space, moment and force fixed in the platform, (6, 3).
        axes: Components of the world twist the platform has, (P,).
        nodes, weights, abscissae: Explicit Runge-Kutta tableau.
        steps: Steps along every rod.
    """

    planar: bool
    base_position: Floats
    base_tangent: Floats
    motor_axis: Floats
    tip_position: Floats
    length: Floats
    stiffness: Floats
    distributed: Floats
    platform_loads: Floats
    axes: NDArray[np.int64]
    nodes: Floats
    weights: Floats
    abscissae: Floats
    steps: int


class ShootingState(NamedTuple):
    """What the shooting finds, written in place.

    Attributes:
        motors: Motor positions [rad], (L,).
        wrenches: Moment and force the rods exert on their bases, in the world, (L, 6).
        rotation: Platform rotation, (3, 3).
        position: Platform position, (3,).
    """

    motors: Floats
    wrenches: Floats
    rotation: Floats
    position: Floats


class _Linear(NamedTuple):
    """Linearisation at the last state.

    ``legs[i]`` holds the increments of the base wrench: that which closes the gap, then those that go
    with unit increments of the platform and of the motor. ``gap`` is the imbalance of the platform,
    ``motion`` its derivative by the platform, ``turns`` by the motors, legs eliminated.
    """

    legs: Floats
    gap: Floats
    motion: Floats
    turns: Floats


@reference
def _spatial_slope(y, compliance, nx, ny, nz, slope):
    """Slopes p' = t, t' = m x t / E J, m' = n x t, and their variations in columns."""
    tx, ty, tz, mx, my, mz = y[3], y[4], y[5], y[6], y[7], y[8]
    slope[0], slope[1], slope[2] = tx, ty, tz
    slope[3] = compliance * (my * tz - mz * ty)
    slope[4] = compliance * (mz * tx - mx * tz)
    slope[5] = compliance * (mx * ty - my * tx)
    slope[6] = ny * tz - nz * ty
    slope[7] = nz * tx - nx * tz
    slope[8] = nx * ty - ny * tx
    for c in range(FIRST, FIRST + COLUMNS):
        ax, ay, az = y[c + 3 * COLUMNS], y[c + 4 * COLUMNS], y[c + 5 * COLUMNS]  # dt
        bx, by, bz = y[c + 6 * COLUMNS], y[c + 7 * COLUMNS], y[c + 8 * COLUMNS]  # dm
        slope[c] = ax
        slope[c + COLUMNS] = ay
        slope[c + 2 * COLUMNS] = az
        slope[c + 3 * COLUMNS] = compliance * (by * tz - bz * ty + my * az - mz * ay)
        slope[c + 4 * COLUMNS] = compliance * (bz * tx - bx * tz + mz * ax - mx * az)
        slope[c + 5 * COLUMNS] = compliance * (bx * ty - by * tx + mx * ay - my * ax)
        slope[c + 6 * COLUMNS] = ny * az - nz * ay
        slope[c + 7 * COLUMNS] = nz * ax - nx * az
        slope[c + 8 * COLUMNS] = nx * ay - ny * ax
    x, y_row, z = FIRST + 6 * COLUMNS, FIRST + 7 * COLUMNS, FIRST + 8 * COLUMNS
    slope[y_row + 3] -= tz
    slope[z + 3] += ty
    slope[x + 4] += tz
    slope[z + 4] -= tx
    slope[x + 5] -= ty
    slope[y_row + 5] += tx


@reference
def _planar_slope(y, compliance, nx, ny, slope):
    """Slopes of x, y, angle and moment; columns by the moment, two of the force, the motor."""
    c, s = math.cos(y[2]), math.sin(y[2])
    slope[0], slope[1] = c, s
    slope[2] = compliance * y[3]
    slope[3] = nx * s - ny * c
    along = nx * c + ny * s
    for column in range(4, 8):
        turn = y[column + 8]
        slope[column] = -s * turn
        slope[column + 4] = c * turn
        slope[column + 8] = compliance * y[column + 12]
        slope[column + 12] = along * turn
    slope[17] += s
    slope[18] -= c


@reference_part
def _integrate(robot, number, force, state, inner, slopes):
    """One rod from base to tip, in place."""
    size = PLANAR_FIRST * (1 + PLANAR_COLUMNS) if robot.planar else FIRST * (1 + COLUMNS)
    stages = robot.weights.shape[0]
    step = robot.length[number] / robot.steps
    compliance = 1.0 / robot.stiffness[number]
    fx, fy, fz = robot.distributed[number]
    for k in range(robot.steps):
        for stage in range(stages):
            for i in range(size):
                inner[i] = state[i]
            for earlier in range(stage):
                factor = step * robot.nodes[stage, earlier]
                if factor != 0.0:
                    for i in range(size):
                        inner[i] += factor * slopes[earlier, i]
            s = step * (k + robot.abscissae[stage])
            nx, ny = force[0] - fx * s, force[1] - fy * s
            if robot.planar:
                _planar_slope(inner, compliance, nx, ny, slopes[stage])
            else:
                _spatial_slope(inner, compliance, nx, ny, force[2] - fz * s, slopes[stage])
        for stage in range(stages):
            factor = step * robot.weights[stage]
            if factor != 0.0:
                for i in range(size):
                    state[i] += factor * slopes[stage, i]


@reference
def _turn(vector, rotation, result):
    """``exp(vector^) rotation`` into another matrix (3, n)."""
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    sine, versine = 1.0, 0.5
    if angle > 1e-8:
        sine = math.sin(angle) / angle
        versine = 2.0 * (math.sin(0.5 * angle) / angle) ** 2
    for j in range(rotation.shape[1]):
        x, y, z = rotation[0, j], rotation[1, j], rotation[2, j]
        ax = vector[1] * z - vector[2] * y
        ay = vector[2] * x - vector[0] * z
        az = vector[0] * y - vector[1] * x
        result[0, j] = x + sine * ax + versine * (vector[1] * az - vector[2] * ay)
        result[1, j] = y + sine * ay + versine * (vector[2] * ax - vector[0] * az)
        result[2, j] = z + sine * az + versine * (vector[0] * ay - vector[1] * ax)


@reference
def _eliminate(matrix, right, size, columns):
    """Solve in place by Gauss with row pivoting: ``right[:size, :columns] = matrix^-1 right``."""
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, size):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for j in range(columns):
                right[k, j], right[pivot, j] = right[pivot, j], right[k, j]
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k + 1, size):
                matrix[i, j] -= factor * matrix[k, j]
            for j in range(columns):
                right[i, j] -= factor * right[k, j]
    for k in range(size - 1, -1, -1):
        for j in range(columns):
            value = right[k, j]
            for i in range(k + 1, size):
                value -= matrix[k, i] * right[i, j]
            right[k, j] = value / matrix[k, k]


@reference
def _add_cross(factor, a, b, result):
    """Add ``factor a x b``."""
    result[0] += factor * (a[1] * b[2] - a[2] * b[1])
    result[1] += factor * (a[2] * b[0] - a[0] * b[2])
    result[2] += factor * (a[0] * b[1] - a[1] * b[0])


@reference
def _add_product(factor, a, b, result):
    """Add ``factor a^ b^``, which is ``factor (b a^T - (a . b) 1)``."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    for i in range(3):
        for j in range(3):
            result[i, j] += factor * b[i] * a[j]
        result[i, i] -= factor * dot


@reference
def _add_skew(factor, a, result):
    """Add ``factor a^``."""
    result[0, 1] -= factor * a[2]
    result[0, 2] += factor * a[1]
    result[1, 0] += factor * a[2]
    result[1, 2] -= factor * a[0]
    result[2, 0] -= factor * a[1]
    result[2, 1] += factor * a[0]


@reference
def balance(loads, tips, rotation, forces, residual, rows):
    """Moment about P and force on the platform, and their derivatives.

    Args:
        loads: As ``Shooting.platform_loads``.
        tips: Tip joints in the platform frame, (L, 3).
        rotation: Platform rotation, (3, 3).
        forces: Forces on the rod tips, in the world, (L, 3).
        residual: Overwritten, (6,).
        rows: Overwritten; derivative by the world twist of the platform and the forces, (6, 6 + 3 L).
    """
    arm = np.empty(3)
    rows[:] = 0.0
    for i in range(3):
        residual[i], residual[3 + i] = loads[2, i], loads[3, i] + loads[0, i]
    for part in range(2):
        for i in range(3):
            arm[i] = 0.0
            for j in range(3):
                arm[i] += rotation[i, j] * loads[4 + part, j]
            residual[3 * part + i] += arm[i]
        _add_skew(-1.0, arm, rows[3 * part : 3 * part + 3, :3])
    for i in range(3):
        arm[i] = 0.0
        for j in range(3):
            arm[i] += rotation[i, j] * loads[1, j]
    _add_cross(1.0, arm, loads[0], residual[:3])
    _add_product(1.0, loads[0], arm, rows[:3, :3])  # d(r x f) = f^ r^ dtheta
    for number in range(len(forces)):
        for i in range(3):
            arm[i] = 0.0
            for j in range(3):
                arm[i] += rotation[i, j] * tips[number, j]
        force, first = forces[number], 6 + 3 * number
        _add_cross(-1.0, arm, force, residual[:3])
        _add_product(-1.0, force, arm, rows[:3, :3])
        _add_skew(-1.0, arm, rows[:3, first : first + 3])
        for i in range(3):
            residual[3 + i] -= force[i]
            rows[3 + i, first + i] = -1.0


@reference_part
def _start_rod(robot, number, motor, wrench, tangent, rod):
    """A rod at its base, and how that varies with the base wrench and the motor."""
    axis = robot.motor_axis[number]
    _turn(axis * motor, robot.base_tangent[number].copy().reshape(3, 1), tangent)
    rod[:] = 0.0
    if robot.planar:
        rod[0], rod[1] = robot.base_position[number, 0], robot.base_position[number, 1]
        rod[2] = math.atan2(tangent[1, 0], tangent[0, 0])
        rod[3] = wrench[2]
        rod[PLANAR_FIRST + 3 * PLANAR_COLUMNS] = 1.0
        rod[PLANAR_FIRST + 2 * PLANAR_COLUMNS + 3] = axis[2]
    else:
        for i in range(3):
            rod[i] = robot.base_position[number, i]
            rod[3 + i] = tangent[i, 0]
            rod[6 + i] = wrench[i]
            rod[FIRST + (6 + i) * COLUMNS + i] = 1.0
        _add_cross(1.0, axis, tangent[:, 0], rod[FIRST + 3 * COLUMNS + 6 :: COLUMNS][:3])


@reference_part
def _evaluate(robot, state, linear):
    """Linearise at a state; returns the largest gap or imbalance."""
    legs, free = len(robot.length), len(robot.axes)
    rod = np.empty(81)
    inner, slopes = np.empty(81), np.empty((len(robot.weights), 81))
    forces = np.empty((legs, 3))
    tangent, arm = np.empty((3, 1)), np.empty(3)
    largest, total = 0.0, 0.0  # a maximum passes over a NaN, a sum does not
    for number in range(legs):
        wrench = state.wrenches[number]
        _start_rod(robot, number, state.motors[number], wrench, tangent, rod)
        _integrate(robot, number, wrench[3:], rod, inner, slopes)
        for i in range(3):
            arm[i] = 0.0
            for j in range(3):
                arm[i] += state.rotation[i, j] * robot.tip_position[number, j]
            forces[number, i] = wrench[3 + i] - robot.length[number] * robot.distributed[number, i]
        gap, sum_of_gaps = _close_leg(robot, state.position, arm, rod, linear.legs[number])
        largest, total = max(largest, gap), total + sum_of_gaps

    residual, rows = np.empty(6), np.empty((6, 6 + 3 * legs))
    balance(robot.platform_loads, robot.tip_position, state.rotation, forces, residual, rows)
    for i in range(free):
        largest = max(largest, abs(residual[robot.axes[i]]))
        total += residual[robot.axes[i]]
    _condense(robot, residual, rows, linear)
    return largest if math.isfinite(total) else math.inf


@reference_part
def _close_leg(robot, position, arm, rod, right):
    """Increments of the base wrench (``_Linear.legs``); returns the largest gap and the sum of gaps."""
    planar, free = robot.planar, len(robot.axes)
    block = 3 if planar else 6
    stride = PLANAR_COLUMNS if planar else COLUMNS
    first = PLANAR_FIRST if planar else FIRST
    matrix = np.empty((6, 6))
    along = np.zeros((3, 6))  # derivative of the gap by the platform's twist
    _add_skew(1.0, arm, along[:, :3])
    for i in range(3):
        along[i, 3 + i] = -1.0
    right[:] = 0.0
    gaps = block - (1 if planar else 3)
    largest, total = 0.0, 0.0
    for row in range(block):
        if row < gaps:
            source = row
            gap = rod[row] - position[row] - arm[row]
            for column in range(free):
                right[row, 1 + column] = along[row, robot.axes[column]]
        else:
            source = 3 if planar else 6 + row - gaps
            gap = rod[source]
        for column in range(block):
            matrix[row, column] = rod[first + source * stride + column]
        right[row, 1 + free] = rod[first + source * stride + block]
        right[row, 0] = gap
        largest = max(largest, abs(gap))
        total += gap
    _eliminate(matrix, right, block, 2 + free)
    return largest, total


@reference_part
def _condense(robot, residual, rows, linear):
    """Balance of the platform with the legs eliminated, from what ``balance`` gives."""
    legs, free = len(robot.length), len(robot.axes)
    block, force_rows = (3, 2) if robot.planar else (6, 3)
    for i in range(free):
        row = robot.axes[i]
        linear.gap[i] = residual[row]
        for j in range(free):
            linear.motion[i, j] = rows[row, robot.axes[j]]
        for number in range(legs):
            linear.turns[i, number] = 0.0
            for k in range(force_rows):
                by_force = rows[row, 6 + 3 * number + k]
                leg = linear.legs[number, block - force_rows + k]
                linear.gap[i] -= by_force * leg[0]
                for j in range(free):
                    linear.motion[i, j] -= by_force * leg[1 + j]
                linear.turns[i, number] -= by_force * leg[1 + free]


@reference
def _move(robot, state, linear, motors_held, imposed, share, correct):
    """Move by the linearisation; returns the length of the step.

    ``share`` of the imposed change of motors or platform is made, and where ``correct`` is not zero
    that part of gaps and imbalance is removed.
    """
    planar, legs, free = robot.planar, len(robot.length), len(robot.axes)
    block = 3 if planar else 6
    turns, twist = np.zeros(legs), np.zeros(6)
    size = free if motors_held else legs
    matrix, right = np.empty((size, size)), np.empty((size, 1))
    for i in range(size):
        right[i, 0] = -correct * linear.gap[i]
        if motors_held:
            for j in range(size):
                matrix[i, j] = linear.motion[i, j]
            for number in range(legs):
                right[i, 0] -= share * linear.turns[i, number] * imposed[number]
        else:
            for j in range(size):
                matrix[i, j] = linear.turns[i, j]
                right[i, 0] -= share * linear.motion[i, j] * imposed[robot.axes[j]]
    _eliminate(matrix, right, size, 1)
    for i in range(free):
        axis = robot.axes[i]
        twist[axis] = right[i, 0] if motors_held else share * imposed[axis]
    for number in range(legs):
        turns[number] = share * imposed[number] if motors_held else right[number, 0]
    squared = 0.0
    for number in range(legs):
        for row in range(block):
            leg = linear.legs[number, row]
            change = -correct * leg[0] - leg[1 + free] * turns[number]
            for j in range(free):
                change -= leg[1 + j] * twist[robot.axes[j]]
            state.wrenches[number, 2 + row if planar else row] += change
            squared += change * change
        state.motors[number] += turns[number]
        squared += turns[number] ** 2
    turned = np.empty((3, 3))
    _turn(twist[:3], state.rotation, turned)
    state.rotation[:] = turned
    for i in range(3):
        state.position[i] += twist[3 + i]
    for i in range(6):
        squared += twist[i] ** 2
    return math.sqrt(squared)


@reference
def _workspace(robot):
    legs, free = len(robot.length), len(robot.axes)
    return _Linear(
        np.zeros((legs, 6, 2 + free)),
        np.zeros(6),
        np.zeros((6, 6)),
        np.zeros((6, legs)),
    )


@reference
def _copy(source, target):
    target.motors[:] = source.motors
    target.wrenches[:] = source.wrenches
    target.rotation[:] = source.rotation
    target.position[:] = source.position


@reference
def _duplicate(state):
    return ShootingState(
        state.motors.copy(), state.wrenches.copy(), state.rotation.copy(), state.position.copy()
    )


@reference
def shoot_at(robot, state, motors_held, tolerance, iterations):
    """Damped Newton from a rough state, in place.

    Returns:
        Largest gap or imbalance, and the number of steps.
    """
    linear, trial = _workspace(robot), _duplicate(state)
    nothing = np.zeros(max(6, len(robot.length)))
    largest = _evaluate(robot, state, linear)
    for iteration in range(iterations):
        if not largest >= tolerance:
            return largest, iteration
        share = 1.0
        while True:
            _copy(state, trial)
            _move(robot, trial, linear, motors_held, nothing, 0.0, share)
            other = _workspace(robot)
            ahead = _evaluate(robot, trial, other)
            if ahead < tolerance or ahead <= (1.0 - 0.25 * share) * largest or share < 1e-3:
                break
            share *= 0.5
        _copy(trial, state)
        linear, largest = other, ahead
    return largest, iterations


@reference
def shoot_along(robot, state, motors_held, changes, tolerance, states, residuals, iterations):
    """Follow a path from an equilibrium: Euler predictor, Newton corrector, halved steps.

    Args:
        robot: The robot.
        state: The equilibrium to start from; overwritten with the last one.
        motors_held: Whether motors are imposed, or the platform.
        changes: Imposed change from one point to the next: motors [rad] or world twist, (K, L or 6).
        tolerance: Largest gap or imbalance.
        states: Overwritten with the equilibria, arrays of ``ShootingState`` with a leading K.
        residuals: Overwritten, (K,).
        iterations: Overwritten with the Jacobians used, (K,).

    Returns:
        Number of points reached.
    """
    linear, before = _workspace(robot), _duplicate(state)
    nothing = np.zeros(max(6, len(robot.length)))
    largest = _evaluate(robot, state, linear)
    for k in range(len(changes)):
        far = 0.0
        for value in changes[k]:
            far = max(far, abs(value))
        longest = 1.0 / max(1.0, far / LONGEST_STEP)
        reached, step, used = 0.0, longest, 0
        while reached < 1.0:
            share = min(step, 1.0 - reached)
            _copy(state, before)
            length = _move(robot, state, linear, motors_held, changes[k], share, 1.0)
            good = False
            for _ in range(CORRECTIONS):
                used += 1
                largest = _evaluate(robot, state, linear)
                if largest < tolerance:
                    good = True
                    break
                if not math.isfinite(largest):
                    break
                correction = _move(robot, state, linear, motors_held, nothing, 0.0, 1.0)
                if not correction < CONTRACTION * length:
                    break
                length = correction
            if good:
                reached = 1.0 if share == 1.0 - reached else reached + share
                step = min(longest, 2.0 * share)
                continue
            _copy(before, state)
            _evaluate(robot, state, linear)
            step = 0.5 * share
            if step < SMALLEST_STEP * longest:
                return k
        states.motors[k], states.wrenches[k] = state.motors, state.wrenches
        states.rotation[k], states.position[k] = state.rotation, state.position
        residuals[k], iterations[k] = largest, used
    return len(changes)
