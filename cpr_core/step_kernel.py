"""From one equilibrium to the next: predicted along the tangent, corrected, with its signs.

An equilibrium is a record: its state, N numbers, and behind it

    9 platform rotation | 3 position | energy | residual | Newton steps | 3 signs | n motor efforts
"""

from __future__ import annotations

import math

from .compiled import inlined, kernel
from .condensation_kernel import CONDENSED, DENSE, condense, keep, recall
from .inertia_kernel import SINGULAR_LEG, signs_of
from .model_kernel import evaluate
from .newton_kernel import (
    CONTRACTION,
    CONVERGED,
    EFFORTS,
    ITERATIONS,
    MOTORS,
    PLATFORM,
    TOLERANCE,
    learn_bend,
    newton,
    predict_state,
)

__all__ = [
    "EFFORT",
    "ENERGY",
    "POSITION",
    "RESIDUAL",
    "ROTATION",
    "SIGNS",
    "STEPS",
    "describe",
    "go_on",
    "step_to",
]

#: Where things are in a record, behind the state.
ROTATION, POSITION, ENERGY, RESIDUAL, STEPS, SIGNS, EFFORT = 0, 9, 12, 13, 14, 15, 18
#: Efforts that count as a motor turned by a radian, in E J / l or E J / l^2.
_EFFORT_UNIT = 4.0


@kernel
def step_to(robot, loads, problem, given, before, factors, predicts, record, after, work):
    """From one equilibrium to a neighbour, whatever the signs there.

    Args:
        robot: RobotArrays.
        loads: LoadArrays at the neighbour.
        problem: MOTORS, EFFORTS or PLATFORM: what is imposed.
        given: Motors or efforts, (n,); or platform rotation and position, (12,), those of the
            equilibrium where they are not imposed.
        before: Record of the equilibrium.
        factors: Kept factors of the tangent there.
        predicts: Whether to predict: where the loads are others than at the equilibrium the tangent
            alone does not tell where the neighbour is.
        record: Result.
        after: Result, kept factors of the tangent at the neighbour.
        work: Workspace.

    Returns:
        Whether every correction contracted, and rods have lengths.
    """
    work.bends[0] = 0
    if predicts:
        recall(robot, factors, work.before)
    else:
        work.before.how[0] = DENSE
    solved = _step(robot, loads, problem, given, before, work.before, record, work)
    if solved:
        keep(robot, work.factors, after)
    return solved


@kernel
def go_on(robot, loads, problem, given, longest, before, factors, records, after, work):
    """From one equilibrium to the next, as long as steps are short, contract, and keep the signs.

    Args:
        robot: RobotArrays.
        loads: LoadArrays.
        problem: See ``step_to``.
        given: The same, one row a step.
        longest: Longest step, see ``Target.distance``.
        before: Record of the first equilibrium, under the same loads.
        factors: Kept factors of the tangent there.
        records: Result, one row a step.
        after: Result, kept factors of the tangent at the last equilibrium.
        work: Workspace.

    Returns:
        Number of steps that were made.
    """
    work.bends[0] = 0
    recall(robot, factors, work.before)
    count = given.shape[0]
    for row in range(count):
        here, there = before if row == 0 else records[row - 1], records[row]
        known = work.before if row == 0 else work.factors
        if not _is_near(robot, problem, given[row], here, longest):
            return row
        if not _step(robot, loads, problem, given[row], here, known, there, work):
            return row
        if not _same_signs(robot, problem, here, there):
            return row
    keep(robot, work.factors, after)
    return count


@kernel
def describe(robot, loads, record, after, work):
    """Complete a record of which state and pose are known, and keep the factors of its tangent."""
    _read_pose(robot, record, work)
    size = robot.unit.shape[0]
    energy = evaluate(
        robot, loads, record[:size], work.rotation, work.position, work.residual, work
    )
    work.factors.how[0] = CONDENSED if condense(robot, work, work.factors) else DENSE
    signs_of(robot, work.rotation, work.factors, work, work.signs)
    keep(robot, work.factors, after)
    largest = 0.0
    for i in range(robot.motor_index):
        value = abs(work.residual[i] * robot.unit[i]) / robot.energy_unit
        largest = max(largest, value) if math.isfinite(value) else math.inf
    _complete(robot, energy, largest, 0, record, work)


@kernel
def _step(robot, loads, problem, given, before, factors, record, work):
    """Predict with the factors at the start and correct; those of the end are left in the workspace."""
    border, platform = robot.border_indices, robot.platform_axes.shape[0]
    rows = border if problem == EFFORTS else border[:platform]
    columns = robot.inverse_unknowns if problem == PLATFORM else rows
    angles = problem == PLATFORM and robot.controls_angles == 1
    size = robot.unit.shape[0]
    state = record[:size]
    for i in range(size):
        state[i] = before[i]
    _read_pose(robot, before, work)
    _impose(robot, problem, given, before, work)
    predicted = predict_state(
        robot, columns, rows, angles, work.given_motors, work.given_rotation, work.given_position,
        work.effort_change, state, work.rotation, work.position, work, factors,
    )  # fmt: skip
    if not _rods_exist(robot, state):
        return False
    status, steps, largest, energy = newton(
        robot, loads, state, work.rotation, work.position, columns, rows, angles,
        work.given_efforts, predicted, TOLERANCE, ITERATIONS, CONTRACTION, work.residual, work,
        work.factors,
    )  # fmt: skip
    if status != CONVERGED or not _rods_exist(robot, state):
        return False
    learn_bend(robot.platform_index + columns.shape[0], work)
    signs_of(robot, work.rotation, work.factors, work, work.signs)
    _complete(robot, energy, largest, steps, record, work)
    return True


@inlined
def _read_pose(robot, record, work):
    """Platform pose of a record, into the workspace."""
    size = robot.unit.shape[0]
    for i in range(3):
        work.position[i] = record[size + POSITION + i]
        for j in range(3):
            work.rotation[i, j] = record[size + ROTATION + 3 * i + j]


@inlined
def _impose(robot, problem, given, before, work):
    """What is imposed, and what stays as it is, into the workspace."""
    size, first = robot.unit.shape[0], robot.motor_index
    for i in range(size - first):
        work.given_motors[i] = given[i] if problem == MOTORS else before[first + i]
        work.given_efforts[i], work.effort_change[i] = 0.0, 0.0
        if problem == EFFORTS:
            work.given_efforts[i] = given[i]
            work.effort_change[i] = given[i] - before[size + EFFORT + i]
    for i in range(3):
        at = POSITION + i
        work.given_position[i] = given[at] if problem == PLATFORM else before[size + at]
        for j in range(3):
            at = ROTATION + 3 * i + j
            work.given_rotation[i, j] = given[at] if problem == PLATFORM else before[size + at]


@inlined
def _rods_exist(robot, state):
    """Whether all rods have a length."""
    if robot.extensible:
        for number in range(robot.groups.shape[0]):
            group = robot.groups[number]
            for lane in range(group.shift_index.shape[0]):
                if group.extensible[lane] == 1.0 and not state[group.shift_index[lane]] > 0.0:
                    return False
    return True


@inlined
def _complete(robot, energy, largest, steps, record, work):
    """Write what is behind the state in a record."""
    size = robot.unit.shape[0]
    for i in range(3):
        record[size + POSITION + i] = work.position[i]
        record[size + SIGNS + i] = work.signs[i]
        for j in range(3):
            record[size + ROTATION + 3 * i + j] = work.rotation[i, j]
    record[size + ENERGY], record[size + RESIDUAL] = energy, largest
    record[size + STEPS] = steps
    for i in range(size - robot.motor_index):
        record[size + EFFORT + i] = work.residual[robot.motor_index + i]


@inlined
def _is_near(robot, problem, given, before, longest):
    """Whether a request is not farther than ``longest``, see ``Target.distance``; numbers all finite."""
    size, first = robot.unit.shape[0], robot.motor_index
    if problem == PLATFORM:
        trace = 0.0
        for i in range(9):
            trace += given[ROTATION + i] * before[size + ROTATION + i]
        if not 0.5 * (trace - 1.0) >= math.cos(longest):
            return False
        length = robot.unit[robot.motor_index - 1]
        for i in range(3):
            change = given[POSITION + i] - before[size + POSITION + i]
            if not abs(change) <= longest * length:
                return False
        return True
    for i in range(size - first):
        if problem == MOTORS:
            change = (given[i] - before[first + i]) / robot.unit[first + i]
        else:
            change = (given[i] - before[size + EFFORT + i]) * robot.unit[first + i]
            change /= _EFFORT_UNIT * robot.energy_unit
        if not abs(change) <= longest:
            return False
    return True


@inlined
def _same_signs(robot, problem, here, there):
    """Whether nothing happens between two equilibria, as far as their signs tell."""
    first = robot.unit.shape[0] + SIGNS
    if here[first] == SINGULAR_LEG or there[first] == SINGULAR_LEG:
        return False
    if problem == EFFORTS:
        return here[first + 1] == there[first + 1]
    same = here[first] == there[first]
    return same and (problem == MOTORS or here[first + 2] == there[first + 2])
