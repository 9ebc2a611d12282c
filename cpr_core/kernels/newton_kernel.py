# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Newton's method on the square problems cut out of the model, with exact tangents."""

from __future__ import annotations

import math

from .border_kernel import factor_border
from .condensation_kernel import UNKNOWN, condense
from .kernel_decorators import inlined, part
from .model_kernel import evaluate_inlined
from .rotation_matrices import (
    multiply,
    multiply_transposed,
    roll_pitch_yaw_into,
    rotation_exp_into,
    rotation_from_angles_into,
    rotation_log_into,
)
from .square_problem import Configuration
from .tangent_kernel import predict, solve, solve_inlined
from .twist_layout import FIRST_LINEAR

__all__ = [
    "CONVERGED",
    "DIVERGED",
    "SINGULAR",
    "STALLED",
    "copy_configuration",
    "learn_bend",
    "move",
    "newton",
    "predict_state",
    "scaled_residual",
]

CONVERGED = 0
DIVERGED = 1  # a correction did not contract: too far from the solution for a full step
SINGULAR = 2  # the tangent of the problem has no inverse
STALLED = 3  # out of iterations, or no damping reduces the correction

#: Corrections below this, dimensionless, need not contract: they may be rounding, divided by what is
#: nearly singular.
_SMALLEST_CORRECTION = 1e-6
#: A prediction this many times as long as what is imposed is rounding, divided by what is singular.
_LARGEST_GAIN = 1e10
#: Cosine above which a step goes on as the one before, and by how much longer it may be.
_SAME_DIRECTION, _LONGEST_RATIO = 0.9, 1.5
#: Differences are used as long as the square of each is below this times that of the one before.
_FALLING = 0.25
#: A damped step is good enough if the next correction is shorter by this part of what it would be.
_SUFFICIENT = 0.25
#: Steps damped by more than this lead nowhere.
_SMALLEST_FRACTION = 1e-4


@inlined
def scaled_residual(robot, residual, given_effort, equations, result):
    """Dimensionless residual of the legs and of a problem's equations; returns its largest entry."""
    largest = 0.0
    inner = robot.platform_index
    per_energy = 1.0 / robot.energy_unit
    for row in range(inner + equations.shape[0]):
        i = row if row < inner else equations[row - inner]
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
def move(robot, problem, step, factor, configuration, work):
    """Subtract ``factor * step`` (dimensionless) from the unknowns."""
    twist, rotation_step, rotated = work.platform_step, work.rotation_step, work.rotated
    state, rotation, position = configuration
    unknowns = problem.unknowns
    inner = robot.platform_index
    last = robot.motor_index
    for i in range(6):
        twist[i] = 0.0
    for i in range(inner):
        state[i] -= factor * step[i] * robot.unit[i]
    for row in range(unknowns.shape[0]):
        i = unknowns[row]
        value = factor * step[inner + row] * robot.unit[i]
        if i < last:
            twist[robot.platform_axes[i - inner]] = -value
        else:
            state[i] -= value
    if problem.angles:
        angles = work.angles
        roll_pitch_yaw_into(rotation, angles)
        rotation_from_angles_into(
            angles[0] + twist[0], angles[1] + twist[1], angles[2] + twist[2], rotation
        )
    else:
        rotation_exp_into(twist[0], twist[1], twist[2], rotation_step)
        multiply(rotation_step, rotation, rotated)
        for i in range(3):
            for j in range(3):
                rotation[i, j] = rotated[i, j]
    for i in range(3):
        position[i] += twist[3 + i]


@inlined
def copy_configuration(source, target):
    """Copy a configuration."""
    for i in range(source.state.shape[0]):
        target.state[i] = source.state[i]
    for i in range(3):
        target.platform_position[i] = source.platform_position[i]
        for j in range(3):
            target.platform_rotation[i, j] = source.platform_rotation[i, j]


@inlined
def _norm(vector, size):
    total = 0.0
    for i in range(size):
        total += vector[i] * vector[i]
    return math.sqrt(total)


@inlined
def predict_state(robot, problem, configuration, factors, work):
    """Impose, and move the unknowns along the tangent to it, in place.

    Args:
        robot: RobotArrays.
        problem: SquareProblem.
        configuration: A solution, overwritten.
        factors: Of the tangent there; where they are UNKNOWN nothing is predicted.
        work: Workspace, with what is imposed, as it is where nothing is: ``given_motors``,
            ``given_rotation``, ``given_position`` and ``effort_change``.

    ``work.bend_count`` counts the steps before of which the missing part is known; 0: only the tangent
    tells; -1: nothing is predicted, nothing can be learnt.

    Returns:
        Dimensionless length of the predicted change; 0 where nothing is predicted.
    """
    state, rotation, position = configuration
    inner, known, efforts = robot.platform_index, work.known, work.efforts
    motors, to_position = work.given_motors, work.given_position
    turn, rotation_step = work.turn, work.rotation_step
    multiply_transposed(work.given_rotation, rotation, rotation_step)
    rotation_log_into(rotation_step, turn)
    for row in range(robot.slots.platform_count):
        axis = robot.platform_axes[row]
        if axis < FIRST_LINEAR:
            change = turn[axis]
        else:
            change = to_position[axis - FIRST_LINEAR] - position[axis - FIRST_LINEAR]
        known[row] = change / robot.unit[inner + row]
    for i in range(motors.shape[0]):
        at = robot.motor_index + i
        known[at - inner] = (motors[i] - state[at]) / robot.unit[at]
        efforts[i] = work.effort_change[i] * robot.unit[at] / robot.energy_unit
        state[at] = motors[i]
    predicted = factors.status[0] != UNKNOWN and predict(
        robot, rotation, problem, known, efforts, work.step, work, factors
    )
    for i in range(3):
        position[i] = to_position[i]
        for j in range(3):
            rotation[i, j] = work.given_rotation[i, j]
    if predicted:
        size, imposed = inner + problem.unknowns.shape[0], 0.0
        for i in range(known.shape[0]):
            imposed += known[i] * known[i]
        for i in range(efforts.shape[0]):
            imposed += efforts[i] * efforts[i]
        if _norm(work.step, size) <= _LARGEST_GAIN * math.sqrt(imposed):
            _add_bend(size, work)
            move(robot, problem, work.step, -1.0, configuration, work)
            return _norm(work.step, size)
    work.bend_count[0] = -1
    return 0.0


@inlined
def _add_bend(size, work):
    """Add to a prediction what the last ones had missed, if steps go on as before.

    What the tangent misses grows with the square of the step. From step to step it changes smoothly:
    it is extrapolated by its backward differences, as many as fall.
    """
    along, last, now = 0.0, 0.0, 0.0
    for change, last_change in ((work.known, work.last_known), (work.efforts, work.last_efforts)):
        for i in range(change.shape[0]):
            along += change[i] * last_change[i]
            last += last_change[i] * last_change[i]
            now += change[i] * change[i]
            last_change[i] = change[i]
    count, differences = max(work.bend_count[0], 0), work.differences
    if count > 0 and not along > _SAME_DIRECTION * math.sqrt(last * now):
        count = 0
    ratio = along / last if count > 0 else 0.0
    if not ratio < _LONGEST_RATIO:
        count = 0
    work.bend_count[0] = count
    order = work.bend_order[0] if ratio * _LONGEST_RATIO > 1.0 else 1
    for i in range(size):
        work.bend[i] = 0.0
    for k in range(count):
        for i in range(size):
            value = ratio * ratio * differences[k, i]
            differences[k, i] = value
            if k < order:
                work.bend[i] += value
    for i in range(size):
        work.step[i] += work.bend[i]


@inlined
def learn_bend(size, work):
    """Remember what a prediction has missed: what was added to it and what Newton's method added."""
    known, differences, now = work.bend_count[0], work.differences, work.bend
    if known < 0:
        work.bend_count[0] = 0
        return
    for i in range(size):
        now[i] += work.total[i]
    count = min(known + 1, differences.shape[0])
    order, falling, before = 1, True, 0.0
    for k in range(count):
        squared = 0.0
        for i in range(size):
            value = now[i]
            squared += value * value
            now[i] = value - differences[k, i]
            differences[k, i] = value
        falling = falling and (k == 0 or squared < _FALLING * before)
        if falling:
            order = k + 1
        before = squared
    work.bend_count[0], work.bend_order[0] = count, order


@part
def newton(robot, loads, configuration, problem, given_effort, predicted, tolerances, work):
    """Solve a square problem from a given configuration, in place.

    The leg coordinates and multipliers are always unknown, their equations always hold. One function:
    every call copies the several hundred words of a robot and a workspace.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        configuration: Start, overwritten; what is not unknown stays as imposed.
        problem: SquareProblem; angles in spatial robots only.
        given_effort: Motor efforts, used where motor rows are among the equations.
        predicted: Dimensionless length of the prediction that led from a solution to the start, which
            counts as the first correction; 0: none did.
        tolerances: Tolerances. Damped steps are judged by the simplified correction, the next one with
            the present factors, which does not depend on how equations are scaled (Deuflhard's natural
            monotonicity test).
        work: Workspace; on return it has the tangent at the result, its factors where CONVERGED, the
            residual of the model, and in ``total`` the dimensionless sum of all corrections.

    Returns:
        Status, number of steps, largest dimensionless residual, potential energy.
    """
    size, equations = robot.platform_index + problem.equations.shape[0], problem.equations
    step, correction, total = work.step, work.correction, work.total
    trial = Configuration(work.trial_state, work.trial_rotation, work.trial_position)
    damped = tolerances.contraction >= 1.0
    for i in range(size):
        step[i], total[i] = 0.0, 0.0
    length, fraction, count, started = predicted, 1.0, 0, False
    while True:
        # The trial: the start itself, or a step from the last configuration.
        copy_configuration(configuration, trial)
        if started:
            move(robot, problem, step, fraction, trial, work)
        state, rotation, position = trial
        energy = evaluate_inlined(
            robot, loads, state, rotation, position, work.residual, work, True
        )
        largest = scaled_residual(robot, work.residual, given_effort, equations, correction)
        accepted = math.isfinite(largest)
        if not accepted and not (damped and started):
            return DIVERGED, count, largest, energy
        if damped and started and accepted and not largest < tolerances.residual:
            for i in range(size):
                work.simplified[i] = correction[i]
            solve(robot, problem, work.simplified, work, work.factors)
            accepted = _norm(work.simplified, size) <= (1.0 - _SUFFICIENT * fraction) * length
        if not accepted:
            fraction *= 0.5
            if fraction < _SMALLEST_FRACTION:
                return STALLED, count, largest, energy
            continue

        copy_configuration(trial, configuration)
        for i in range(size):
            total[i] -= fraction * step[i]
            step[i] = correction[i]
        condense(robot, work, work.factors)
        if largest < tolerances.residual:
            return CONVERGED, count, largest, energy
        if not factor_border(robot, configuration.platform_rotation, problem, work, work.factors):
            return SINGULAR, count, largest, energy
        if count == tolerances.iterations:
            return STALLED, count, largest, energy
        solve_inlined(robot, problem, step, work, work.factors)
        before, length = length, _norm(step, size)
        compared = not damped and before > 0.0
        if compared and length > max(tolerances.contraction * before, _SMALLEST_CORRECTION):
            return DIVERGED, count, largest, energy
        count, fraction, started = count + 1, 1.0, True
