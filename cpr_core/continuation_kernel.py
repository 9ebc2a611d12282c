# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one equilibrium to the next: predicted along the tangent, corrected, with its signs.

An equilibrium is a record: its state, N numbers, and behind it

    9 platform rotation | 3 position | energy | residual | Newton steps | 3 signs | n motor efforts
"""

from __future__ import annotations

import math

from .compiled import inlined, part
from .condensation_kernel import DENSE, keep, recall
from .inertia_kernel import SINGULAR_LEG, signs_of
from .newton_kernel import CONVERGED, EFFORTS, MOTORS, PLATFORM, learn_bend, newton, predict_state

__all__ = [
    "EFFORT",
    "ENERGY",
    "FREELY",
    "LONGEST_STEP",
    "POSITION",
    "RESIDUAL",
    "ROTATION",
    "SIGNS",
    "STEPS",
    "UNPREDICTED",
    "WATCHED",
    "continue_equilibria",
]

#: Where things are in a record, behind the state.
ROTATION, POSITION, ENERGY, RESIDUAL, STEPS, SIGNS, EFFORT = 0, 9, 12, 13, 14, 15, 18
#: How to go: near requests only, no sign changes; wherever corrections contract; the same without
#: prediction: where the loads are others than at the start the tangent alone does not tell the way.
WATCHED, FREELY, UNPREDICTED = 0, 1, 2
#: Longest step that is watched, in radians and rod lengths. A motor several turns away looks near to
#: Newton's method, yet the rod has to be wound there.
LONGEST_STEP = 0.5
#: Efforts that count as a motor turned by a radian, in E J / l or E J / l^2.
_EFFORT_UNIT = 4.0


@part
def continue_equilibria(
    robot, loads, problem, given, how, tolerance, iterations, contraction, before, factors, records,
    after, work,
):  # fmt: skip
    """From one equilibrium to the next, as long as Newton's method converges.

    Args:
        robot: RobotArrays.
        loads: LoadArrays at the ends of the steps.
        problem: MOTORS, EFFORTS or PLATFORM: what is imposed.
        given: Motors or efforts, (P, n); or platform rotation and position, (P, 12), those of the
            equilibrium where they are not imposed. One row a step.
        how: WATCHED, FREELY or UNPREDICTED.
        tolerance: See `newton`.
        iterations: See `newton`.
        contraction: See `newton`.
        before: Record of the first equilibrium.
        factors: Kept factors of the tangent there; not read where UNPREDICTED.
        records: Result, (P, .); behind the last step that was made, where Newton's method ended.
        after: Result where all steps were made, kept factors of the tangent at the last equilibrium.
        work: Workspace.

    Returns:
        Number of steps that were made.
    """
    border, platform = robot.border_indices, robot.slots.platform_count
    rows = border if problem == EFFORTS else border[:platform]
    columns = robot.inverse_unknowns if problem == PLATFORM else rows
    angles = problem == PLATFORM and robot.controls_angles == 1
    size = robot.unit.shape[0]
    work.bends[0] = 0
    if how == UNPREDICTED:
        work.factors.how[0] = DENSE
    else:
        recall(robot, factors, work.factors)
    for row in range(given.shape[0]):
        here = before if row == 0 else records[row - 1]
        if how == WATCHED and not _is_near(robot, problem, given[row], here):
            return row
        record = records[row]
        state = record[:size]
        for i in range(size):
            state[i] = here[i]
        _read_pose(robot, here, work)
        _impose(robot, problem, given[row], here, work)
        predicted = predict_state(
            robot, columns, rows, angles, work.given_motors, work.given_rotation,
            work.given_position, work.effort_change, state, work.rotation, work.position, work,
            work.factors,
        )  # fmt: skip
        if not _rods_exist(robot, state):
            return row
        status, steps, largest, energy = newton(
            robot, loads, state, work.rotation, work.position, columns, rows, angles,
            work.given_efforts, predicted, tolerance, iterations, contraction, work.residual, work,
            work.factors,
        )  # fmt: skip
        if status == CONVERGED:
            learn_bend(robot.platform_index + columns.shape[0], work)
            signs_of(robot, work.rotation, work.factors, work, work.signs)
        _complete(robot, energy, largest, steps, record, work)
        if status != CONVERGED or not _rods_exist(robot, state):
            return row
        if how == WATCHED and not _same_signs(robot, problem, here, record):
            return row
    keep(robot, work.factors, after)
    return given.shape[0]


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
def _is_near(robot, problem, given, before):
    """Whether a request is finite and not farther than a step may be, see ``Target.distance``."""
    longest = LONGEST_STEP
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
