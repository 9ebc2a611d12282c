"""Newton's method on the square problems cut out of the model, with exact tangents."""

from __future__ import annotations

import math

from .compiled import inlined, kernel
from .condensation_kernel import (
    CONDENSED,
    DENSE,
    NO_INVERSE,
    condense,
    factor,
    keep,
    predict,
    recall,
    rotation_unknowns,
    solve,
)
from .inertia_kernel import signs_of
from .lie import (
    multiply,
    multiply_transposed,
    roll_pitch_yaw_into,
    rotation_exp_into,
    rotation_from_angles_into,
    rotation_log_into,
)
from .model_kernel import evaluate

__all__ = [
    "CONVERGED",
    "DIVERGED",
    "EFFORTS",
    "MOTORS",
    "PLATFORM",
    "SINGULAR",
    "STALLED",
    "factors_at",
    "newton",
    "step_to",
]

#: What a problem imposes.
MOTORS, EFFORTS, PLATFORM = 0, 1, 2

CONVERGED = 0
DIVERGED = 1  # a correction did not contract: too far from the solution for a full step
SINGULAR = 2  # the tangent of the problem has no inverse
STALLED = 3  # out of iterations, or no damping reduces the correction

#: First corrections below this, dimensionless, are rounding as much as they are error of a prediction.
_SMALLEST_PREDICTION = 1e-6


@inlined
def _scaled_residual(robot, residual, given_effort, rows, result):
    """Dimensionless residual of the legs and of the given rows; returns its largest entry."""
    largest = 0.0
    inner = robot.platform_index
    per_energy = 1.0 / robot.energy_unit
    for row in range(inner + rows.shape[0]):
        i = row if row < inner else rows[row - inner]
        value = residual[i]
        if i >= robot.motor_index:
            value -= given_effort[i - robot.motor_index]
        value *= robot.unit[i] * per_energy
        if not math.isfinite(value):
            return math.inf
        result[row] = value
        largest = max(largest, abs(value))
    return largest


@inlined
def _move(robot, columns, angles, step, factor, state, rotation, position, work):
    """Subtract ``factor * step`` (dimensionless) from the unknowns."""
    increment, product, twist = work.rotations[0], work.rotations[1], work.platform_residual
    inner = robot.platform_index
    last = inner + robot.platform_axes.shape[0]
    for i in range(6):
        twist[i] = 0.0
    for i in range(inner):
        state[i] -= factor * step[i] * robot.unit[i]
    for row in range(columns.shape[0]):
        i = columns[row]
        value = factor * step[inner + row] * robot.unit[i]
        if i < last:
            twist[robot.platform_axes[i - inner]] = -value
        else:
            state[i] -= value
    if angles:
        turned = work.rotations[1, 0]
        roll_pitch_yaw_into(rotation, turned)
        rotation_from_angles_into(
            turned[0] + twist[0], turned[1] + twist[1], turned[2] + twist[2], rotation
        )
    else:
        rotation_exp_into(twist[0], twist[1], twist[2], increment)
        multiply(increment, rotation, product)
        for i in range(3):
            for j in range(3):
                rotation[i, j] = product[i, j]
    for i in range(3):
        position[i] += twist[3 + i]


@inlined
def _copy(rotation, position, to_rotation, to_position):
    """Copy a pose."""
    for i in range(3):
        to_position[i] = position[i]
        for j in range(3):
            to_rotation[i, j] = rotation[i, j]


@inlined
def _norm(vector, size):
    total = 0.0
    for i in range(size):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@inlined
def predict_state(
    robot, columns, rows, angles, motors, to_rotation, to_position, effort_change,
    state, rotation, position, work, factors,
):  # fmt: skip
    """Impose, and move the unknowns along the tangent to it, in place.

    Args:
        robot: RobotArrays.
        columns: State indices of the unknowns among platform and motors.
        rows: State indices of the equations among platform and motors.
        angles: Whether the rotation unknowns are roll, pitch and yaw.
        motors: Motors, where they are imposed, as they are elsewhere, (motors,).
        to_rotation: The same for the platform's rotation.
        to_position: The same for its position.
        effort_change: Change of the imposed efforts, (motors,).
        state: A solution, overwritten.
        rotation: The same for the platform's rotation.
        position: The same for its position.
        work: Workspace.
        factors: Of the tangent there; where legs were not condensed nothing is predicted.

    Returns:
        Dimensionless length of the predicted change; 0 where nothing is predicted.
    """
    inner, known, efforts = robot.platform_index, work.known, work.efforts
    turn = work.rotations[2, 0]
    multiply_transposed(to_rotation, rotation, work.rotations[0])
    rotation_log_into(work.rotations[0], turn)
    for row in range(robot.platform_axes.shape[0]):
        axis = robot.platform_axes[row]
        change = turn[axis] if axis < 3 else to_position[axis - 3] - position[axis - 3]
        known[row] = change / robot.unit[inner + row]
    for i in range(motors.shape[0]):
        at = robot.motor_index + i
        known[at - inner] = (motors[i] - state[at]) / robot.unit[at]
        efforts[i] = effort_change[i] * robot.unit[at] / robot.energy_unit
        state[at] = motors[i]
    rotation_unknowns(rotation, angles, work.motions)
    _copy(to_rotation, to_position, rotation, position)
    if factors.how[0] == CONDENSED and predict(
        robot, rows, columns, angles, known, efforts, work.step, work, factors
    ):
        _move(robot, columns, angles, work.step, -1.0, state, rotation, position, work)
        return _norm(work.step, inner + columns.shape[0])
    return 0.0


@kernel
def newton(
    robot, loads, state, rotation, position, columns, rows, angles, given_effort, predicted,
    tolerance, iterations, contraction, residual, work, factors,
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
        predicted: Dimensionless length of the prediction that led from a solution to the start, which
            counts as the first correction; 0: none did.
        tolerance: Largest dimensionless residual of a solution.
        iterations: At most so many steps.
        contraction: Below 1: take full steps only and give up (DIVERGED) as soon as a correction is
            not smaller than this times the one before; the solution then lies on the branch of the
            start. 1: damp the steps instead, for a start that may be far away.
        residual: On return the residual of the model at the result, (N,).
        work: Workspace; on return it has the tangent at the result.
        factors: On return those of the tangent at the result, where CONVERGED.

    Returns:
        Status, number of steps, largest dimensionless residual, potential energy.
    """
    size = robot.platform_index + rows.shape[0]
    step, correction, simplified = work.step, work.correction, work.simplified
    trial_state, trial_rotation = work.trial_state, work.rotations[3]
    trial_position = work.rotations[4, 0]

    energy = evaluate(robot, loads, state, rotation, position, residual, work)
    largest = _scaled_residual(robot, residual, given_effort, rows, step)
    for iteration in range(iterations):
        if not math.isfinite(largest):
            return DIVERGED, iteration, largest, energy
        how = factor(robot, rotation, rows, columns, angles, work, factors)
        if largest < tolerance:
            return CONVERGED, iteration, largest, energy
        if how == NO_INVERSE:
            return SINGULAR, iteration, largest, energy
        solve(robot, rows, columns, angles, step, work, factors)
        length = _norm(step, size)
        if iteration == 0 and contraction < 1.0 and predicted > 0.0:
            if length > max(contraction * predicted, _SMALLEST_PREDICTION):
                return DIVERGED, iteration, largest, energy
        fraction = 1.0
        while True:
            for i in range(state.shape[0]):
                trial_state[i] = state[i]
            _copy(rotation, position, trial_rotation, trial_position)
            _move(
                robot, columns, angles, step, fraction, trial_state, trial_rotation,
                trial_position, work,
            )  # fmt: skip
            energy = evaluate(
                robot, loads, trial_state, trial_rotation, trial_position, residual, work
            )
            largest = _scaled_residual(robot, residual, given_effort, rows, correction)
            if largest < tolerance:
                break
            if math.isfinite(largest):
                for i in range(size):
                    simplified[i] = correction[i]
                solve(robot, rows, columns, angles, simplified, work, factors)
                remaining = _norm(simplified, size)
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
        for i in range(state.shape[0]):
            state[i] = trial_state[i]
        _copy(trial_rotation, trial_position, rotation, position)
        for i in range(size):
            step[i] = correction[i]
    if largest < tolerance:
        factor(robot, rotation, rows, columns, angles, work, factors)
        return CONVERGED, iterations, largest, energy
    return STALLED, iterations, largest, energy


@kernel
def step_to(
    robot, loads, problem, motors, to_rotation, to_position, first_efforts, efforts, before, predicts,
    tolerance, iterations, contraction, state, rotation, position, residual, signs, after, work,
):  # fmt: skip
    """From one solution to a neighbour: predicted along the tangent, corrected, with its signs.

    Args:
        robot: RobotArrays.
        loads: LoadArrays at the neighbour.
        problem: MOTORS, EFFORTS or PLATFORM: what is imposed.
        motors: Motors, where they are imposed, as they are elsewhere, (motors,).
        to_rotation: The same for the platform's rotation.
        to_position: The same for its position.
        first_efforts: Efforts of the solution, (motors,).
        efforts: Imposed efforts, where they are imposed, (motors,).
        before: Kept factors of the tangent at the solution.
        predicts: Whether to predict: where the loads are others than at the solution the tangent alone
            does not tell where the neighbour is.
        tolerance: See ``newton``.
        iterations: See ``newton``.
        contraction: See ``newton``.
        state: The solution, overwritten by its neighbour.
        rotation: The same for the platform's rotation.
        position: The same for its position.
        residual: See ``newton``.
        signs: Result, (3,), see ``signs_of``.
        after: Result, kept factors of the tangent at the neighbour.
        work: Workspace.

    Returns:
        Status, number of steps, largest dimensionless residual, potential energy.
    """
    border, platform = robot.border_indices, robot.platform_axes.shape[0]
    rows = border if problem == EFFORTS else border[:platform]
    columns = robot.inverse_unknowns if problem == PLATFORM else rows
    angles = problem == PLATFORM and robot.controls_angles == 1
    change = work.effort_change
    for i in range(change.shape[0]):
        change[i] = efforts[i] - first_efforts[i] if problem == EFFORTS else 0.0
    if predicts:
        recall(robot, before, work.before)
    else:
        work.before.how[0] = DENSE
    predicted = predict_state(
        robot, columns, rows, angles, motors, to_rotation, to_position, change,
        state, rotation, position, work, work.before,
    )  # fmt: skip
    status, steps, largest, energy = newton(
        robot, loads, state, rotation, position, columns, rows, angles, efforts, predicted,
        tolerance, iterations, contraction, residual, work, work.factors,
    )  # fmt: skip
    if status == CONVERGED:
        signs_of(robot, rotation, work.factors, work, signs)
        keep(robot, work.factors, after)
    return status, steps, largest, energy


@kernel
def factors_at(robot, loads, state, rotation, position, residual, signs, after, work):
    """Residual, signs and kept factors of the tangent at any state; returns the energy [J]."""
    energy = evaluate(robot, loads, state, rotation, position, residual, work)
    work.factors.how[0] = CONDENSED if condense(robot, work, work.factors) else DENSE
    signs_of(robot, rotation, work.factors, work, signs)
    keep(robot, work.factors, after)
    return energy
