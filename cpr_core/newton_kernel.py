"""Newton's method on the square problems cut out of the model, with exact tangents."""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .condensation_kernel import NO_INVERSE, allocate, factor, solve
from .lie import (
    multiply,
    roll_pitch_yaw_into,
    rotation_exp_into,
    rotation_from_angles_into,
)
from .model_kernel import evaluate_model

__all__ = ["CONVERGED", "DIVERGED", "SINGULAR", "STALLED", "newton"]

CONVERGED = 0
DIVERGED = 1  # a correction did not contract: too far from the solution for a full step
SINGULAR = 2  # the tangent of the problem has no inverse
STALLED = 3  # out of iterations, or no damping reduces the correction


@compiled
def _scaled_residual(robot, residual, given_effort, rows, result):
    """Dimensionless residual of the legs and of the given rows; returns its largest entry."""
    largest = 0.0
    inner = robot.platform_index
    for row in range(result.shape[0]):
        i = row if row < inner else rows[row - inner]
        value = residual[i]
        if i >= robot.motor_index:
            value -= given_effort[i - robot.motor_index]
        value *= robot.unit[i] / robot.energy_unit
        if not math.isfinite(value):
            return math.inf
        result[row] = value
        largest = max(largest, abs(value))
    return largest


@compiled
def _use_angles(robot, rotation, tangent, work):
    """Turn the derivatives by world rotations into those by roll, pitch and yaw."""
    first = robot.platform_index
    angles = work.vectors[0]
    roll_pitch_yaw_into(rotation, angles)
    cosine, sine = math.cos(angles[2]), math.sin(angles[2])
    for i in range(tangent.shape[0]):
        x, y, z = tangent[i, first], tangent[i, first + 1], tangent[i, first + 2]
        tangent[i, first] = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
        tangent[i, first + 1] = cosine * y - sine * x
        tangent[i, first + 2] = z


@compiled
def _move(robot, columns, angles, step, factor, state, rotation, position, work):
    """Subtract ``factor * step`` (dimensionless) from the unknowns."""
    increment, product, twist = work.matrices[0], work.matrices[1], work.vectors[:2].reshape(6)
    inner = robot.platform_index
    last = inner + robot.platform_axes.shape[0]
    for i in range(6):
        twist[i] = 0.0
    for row in range(step.shape[0]):
        i = row if row < inner else columns[row - inner]
        value = factor * step[row] * robot.unit[i]
        if inner <= i < last:
            twist[robot.platform_axes[i - inner]] = -value
        else:
            state[i] -= value
    if angles:
        turned = work.vectors[2]
        roll_pitch_yaw_into(rotation, turned)
        rotation_from_angles_into(
            turned[0] + twist[0], turned[1] + twist[1], turned[2] + twist[2], rotation
        )
    else:
        rotation_exp_into(twist[0], twist[1], twist[2], increment)
        multiply(increment, rotation, product)
        _copy(product, rotation)
    for i in range(3):
        position[i] += twist[3 + i]


@compiled
def _copy(source, target):
    """Copy between arrays of the same shape (an assignment of slices compiles for seconds)."""
    flat_source, flat_target = source.ravel(), target.ravel()
    for i in range(flat_source.shape[0]):
        flat_target[i] = flat_source[i]


@compiled
def _norm(vector):
    total = 0.0
    for i in range(vector.shape[0]):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@compiled
def newton(
    robot, loads, state, rotation, position, columns, rows, angles, given_effort,
    tolerance, iterations, contraction, residual, tangent, work,
):  # fmt: skip
    """Solve a square problem from a given state, in place.

    The leg coordinates and multipliers are always unknown, their equations always hold. Steps are
    judged by the simplified correction, the next step with the present factors: it does not depend on
    how equations are scaled (Deuflhard's natural monotonicity test).

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        state: Start (N,), overwritten; entries that are not unknown stay as imposed.
        rotation: Platform rotation, overwritten.
        position: Platform position, overwritten.
        columns: State indices of the unknowns among platform and motors.
        rows: As many state indices of the equations among platform and motors.
        angles: Whether the platform's rotation coordinates are roll, pitch and yaw, of
            Rz(yaw) Ry(pitch) Rx(roll), in place of small world rotations; spatial robots only.
        given_effort: Motor efforts, used where motor rows are among the equations.
        tolerance: Largest dimensionless residual of a solution.
        iterations: At most so many steps.
        contraction: Below 1: take full steps only and give up (DIVERGED) as soon as a correction is
            not smaller than this times the one before; the solution then lies on the branch of the
            start. 1: damp the steps instead, for a start that may be far away.
        residual: On return the residual of the model at the result, (N,).
        tangent: Zero on entry, on return the tangent of the model at the result, (N, N).
        work: Workspace.

    Returns:
        Status, number of steps, largest dimensionless residual, potential energy.
    """
    size = robot.platform_index + rows.shape[0]
    factors = allocate(robot, rows.shape[0])
    step, correction, simplified = np.empty(size), np.empty(size), np.empty(size)
    trial_state, trial_rotation, trial_position = state.copy(), rotation.copy(), position.copy()

    energy = evaluate_model(robot, loads, state, rotation, position, residual, tangent, work)
    largest = _scaled_residual(robot, residual, given_effort, rows, step)
    for iteration in range(iterations):
        if largest < tolerance:
            return CONVERGED, iteration, largest, energy
        if not math.isfinite(largest):
            return DIVERGED, iteration, largest, energy
        if angles:
            _use_angles(robot, rotation, tangent, work)
        how = factor(robot, tangent, rows, columns, factors)
        if how == NO_INVERSE:
            return SINGULAR, iteration, largest, energy
        solve(factors, how, step)
        length = _norm(step)
        fraction = 1.0
        while True:
            _copy(state, trial_state)
            _copy(rotation, trial_rotation)
            _copy(position, trial_position)
            _move(
                robot,
                columns,
                angles,
                step,
                fraction,
                trial_state,
                trial_rotation,
                trial_position,
                work,
            )
            energy = evaluate_model(
                robot, loads, trial_state, trial_rotation, trial_position, residual, tangent, work
            )
            largest = _scaled_residual(robot, residual, given_effort, rows, correction)
            if largest < tolerance:
                break
            if math.isfinite(largest):
                _copy(correction, simplified)
                solve(factors, how, simplified)
                remaining = _norm(simplified)
                if contraction < 1.0:
                    if remaining <= contraction * length:
                        break
                    return DIVERGED, iteration + 1, largest, energy
                if remaining <= (1.0 - 0.25 * fraction) * length:
                    break
            elif contraction < 1.0:
                return DIVERGED, iteration + 1, largest, energy
            fraction *= 0.5
            if fraction < 1e-4:
                return STALLED, iteration + 1, largest, energy
        _copy(trial_state, state)
        _copy(trial_rotation, rotation)
        _copy(trial_position, position)
        _copy(correction, step)
    if largest < tolerance:
        return CONVERGED, iterations, largest, energy
    return STALLED, iterations, largest, energy
