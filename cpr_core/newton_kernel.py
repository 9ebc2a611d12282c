"""Newton's method on the square problems cut out of the model, with exact tangents."""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .lie import multiply, rotation_exp_into
from .model_kernel import evaluate_model

__all__ = ["CONVERGED", "DIVERGED", "SINGULAR", "STALLED", "lu_factor", "lu_solve", "newton"]

CONVERGED = 0
DIVERGED = 1  # a correction did not contract: too far from the solution for a full step
SINGULAR = 2  # the tangent of the problem has no inverse
STALLED = 3  # out of iterations, or no damping reduces the correction


@compiled
def lu_factor(matrix, pivots):
    """Factor a square matrix in place, rows exchanged; False where a pivot vanishes.

    Zero multipliers are passed over: the tangent is block-arrow shaped and stays nearly so.
    """
    size = matrix.shape[0]
    for k in range(size):
        best, row = 0.0, k
        for i in range(k, size):
            value = abs(matrix[i, k])
            if value > best:
                best, row = value, i
        pivots[k] = row
        if not best > 1e-14:
            return False
        if row != k:
            for j in range(size):
                matrix[k, j], matrix[row, j] = matrix[row, j], matrix[k, j]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, size):
            factor = matrix[i, k]
            if factor != 0.0:
                factor *= inverse
                matrix[i, k] = factor
                for j in range(k + 1, size):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@compiled
def lu_solve(factors, pivots, vector):
    """Solve with the result of ``lu_factor``, in place."""
    size = factors.shape[0]
    for k in range(size):
        row = pivots[k]
        if row != k:
            vector[k], vector[row] = vector[row], vector[k]
    for i in range(size):
        total = vector[i]
        for j in range(i):
            total -= factors[i, j] * vector[j]
        vector[i] = total
    for i in range(size - 1, -1, -1):
        total = vector[i]
        for j in range(i + 1, size):
            total -= factors[i, j] * vector[j]
        vector[i] = total / factors[i, i]


@compiled
def _scaled_residual(robot, residual, given_effort, equations, result):
    """Dimensionless residual of the chosen equations; returns its largest entry."""
    largest = 0.0
    for row in range(equations.shape[0]):
        i = equations[row]
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
def _move(robot, unknowns, step, factor, state, rotation, position, work):
    """Add ``factor * step`` (dimensionless) to the unknowns."""
    increment, product, twist = work.matrices[0], work.matrices[1], work.vectors[:2].reshape(6)
    for i in range(6):
        twist[i] = 0.0
    last = robot.platform_index + robot.platform_axes.shape[0]
    for row in range(unknowns.shape[0]):
        i = unknowns[row]
        value = factor * step[row] * robot.unit[i]
        if robot.platform_index <= i < last:
            twist[robot.platform_axes[i - robot.platform_index]] = value
        else:
            state[i] += value
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
def newton(
    robot, loads, state, rotation, position, unknowns, equations, given_effort,
    tolerance, iterations, contraction, residual, tangent, work,
):  # fmt: skip
    """Solve a square problem from a given state, in place.

    Steps are judged by the simplified correction, the next step with the present factors: it does
    not depend on how equations are scaled (Deuflhard's natural monotonicity test).

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        state: Start (N,), overwritten; entries that are not unknown stay as imposed.
        rotation: Platform rotation, overwritten.
        position: Platform position, overwritten.
        unknowns: State indices to solve for.
        equations: As many state indices of equations to satisfy.
        given_effort: Motor efforts, used where motor rows are among the equations.
        tolerance: Largest dimensionless residual of a solution.
        iterations: At most so many steps.
        contraction: Below 1: take full steps only and give up (DIVERGED) as soon as a correction is
            not smaller than this times the one before; the solution then lies on the branch of the
            start. 1: damp the steps instead, for a start that may be far away.
        residual: Work space, on return the residual of the model at the result, (N,).
        tangent: Work space, on return the tangent at the result, (N, N).
        work: Workspace.

    Returns:
        Status, number of steps, largest dimensionless residual, potential energy.
    """
    size = unknowns.shape[0]
    matrix = np.empty((size, size))
    pivots = np.empty(size, np.int64)
    step = np.empty(size)
    correction = np.empty(size)
    simplified = np.empty(size)
    trial_state = np.empty_like(state)
    trial_rotation = np.empty((3, 3))
    trial_position = np.empty(3)

    energy = evaluate_model(robot, loads, state, rotation, position, residual, tangent, work)
    largest = _scaled_residual(robot, residual, given_effort, equations, step)
    for iteration in range(iterations):
        if largest < tolerance:
            return CONVERGED, iteration, largest, energy
        if not math.isfinite(largest):
            return DIVERGED, iteration, largest, energy
        for row in range(size):
            i = equations[row]
            scale = robot.unit[i] / robot.energy_unit
            for column in range(size):
                j = unknowns[column]
                matrix[row, column] = scale * tangent[i, j] * robot.unit[j]
        if not lu_factor(matrix, pivots):
            return SINGULAR, iteration, largest, energy
        length = 0.0
        lu_solve(matrix, pivots, step)
        for row in range(size):
            step[row] = -step[row]
            length += step[row] * step[row]
        length = math.sqrt(length)

        factor = 1.0
        while True:
            _copy(state, trial_state)
            _copy(rotation, trial_rotation)
            _copy(position, trial_position)
            _move(robot, unknowns, step, factor, trial_state, trial_rotation, trial_position, work)
            energy = evaluate_model(
                robot, loads, trial_state, trial_rotation, trial_position,
                residual, tangent, work,
            )  # fmt: skip
            largest = _scaled_residual(robot, residual, given_effort, equations, correction)
            if largest < tolerance:
                break
            if math.isfinite(largest):
                _copy(correction, simplified)
                lu_solve(matrix, pivots, simplified)
                remaining = 0.0
                for row in range(size):
                    remaining += simplified[row] * simplified[row]
                remaining = math.sqrt(remaining)
                if contraction < 1.0:
                    if remaining > contraction * length:
                        return DIVERGED, iteration + 1, largest, energy
                    break
                if remaining <= (1.0 - 0.25 * factor) * length:
                    break
            elif contraction < 1.0:
                return DIVERGED, iteration + 1, largest, energy
            factor *= 0.5
            if factor < 1e-4:
                return STALLED, iteration + 1, largest, energy
        _copy(trial_state, state)
        _copy(trial_rotation, rotation)
        _copy(trial_position, position)
        _copy(correction, step)
    if largest < tolerance:
        return CONVERGED, iterations, largest, energy
    return STALLED, iterations, largest, energy
