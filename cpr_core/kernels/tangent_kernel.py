# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Linear solves with the tangent: first the legs, `condensation_kernel`, then the border, and back."""

from __future__ import annotations

from .border_kernel import factor_border, solve_border
from .condensation_kernel import NO_INVERSE, condense
from .delayed_kernel import gather_delayed, scatter_delayed
from .kernel_decorators import inlined, part
from .lanes import broadcast, get, load, put, store, total

__all__ = [
    "expand_legs",
    "factor",
    "predict",
    "reduce_legs",
    "solve",
    "solve_inlined",
    "substitute_border",
]


@part
def factor(robot, rotation, problem, work, factors):
    """Factor the tangent of a square problem, from the slots in the workspace.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation, (3, 3).
        problem: SquareProblem.
        work: Workspace.
        factors: Result.

    Returns:
        CONDENSED or DELAYED, how it was done, or NO_INVERSE.
    """
    condense(robot, work, factors)
    regular = factor_border(robot, rotation, problem, work, factors)
    return factors.status[0] if regular else NO_INVERSE


@part
def solve(robot, problem, vector, work, factors):
    """Solve in place: legs first, border last, in the order of the equations and the unknowns."""
    solve_inlined(robot, problem, vector, work, factors)


@inlined
def solve_inlined(robot, problem, vector, work, factors):
    """``solve`` as a part of what calls it."""
    border, count = work.border, robot.border_indices.shape[0]
    for i in range(count):
        border[i] = 0.0
    for i in range(problem.equations.shape[0]):
        border[problem.equations[i] - robot.platform_index] = vector[robot.platform_index + i]
    reduce_legs(robot, vector, work, factors)
    expand_legs(robot, problem, vector, work, factors)


@inlined
def reduce_legs(robot, vector, work, factors):
    """First half of a solve: the right side of the border, in the workspace, gets that of the legs."""
    for number in range(robot.groups.shape[0]):
        _forward(robot, number, vector, work, factors)
    gather_delayed(robot.slots, robot.border_indices.shape[0], work.solution, work.border, factors)


@inlined
def expand_legs(robot, problem, vector, work, factors):
    """Second half: the unknowns into the vector; twist, motors and delayed slots into the workspace."""
    solve_border(robot, problem, vector, work, factors)
    substitute_border(robot, vector, work, factors)


@inlined
def substitute_border(robot, vector, work, factors):
    """Unknowns of the legs into the vector, from those of border and delayed slots in the workspace."""
    scatter_delayed(robot.slots, robot.border_indices.shape[0], work.solution, work.border, factors)
    for number in range(robot.groups.shape[0]):
        _backward(robot, number, vector, work, factors)


@part
def predict(robot, rotation, problem, known, efforts, vector, work, factors):
    """Change of the unknowns, to first order, with what is imposed.

    Args:
        robot: RobotArrays.
        rotation: Platform rotation at the start of the change, (3, 3).
        problem: SquareProblem.
        known: Imposed change of the border, world twist and motors, dimensionless; zero where unknown.
        efforts: Imposed change of the efforts, dimensionless, (motors,).
        vector: Result, legs first.
        work: Workspace.
        factors: Of the tangent at the start of the change.

    Returns:
        Whether the problem has an inverse there.
    """
    if not factor_border(robot, rotation, problem, work, factors):
        return False
    border, count = work.border, robot.border_indices.shape[0]
    first_effort = count - efforts.shape[0]
    for i in range(count + factors.delayed_count[0]):
        value = efforts[i - first_effort] if first_effort <= i < count else 0.0
        for j in range(count):
            value -= factors.border[i, j] * known[j]
        border[i] = value
    zero = broadcast(work.solution, 0.0)
    for number in range(robot.groups.shape[0]):
        for slot in range(robot.slots.inner_count):
            store(work.solution, (number, slot), zero)
    solve_border(robot, problem, vector, work, factors)
    for i in range(count):
        border[i] += known[i]
    substitute_border(robot, vector, work, factors)
    return True


@inlined
def _forward(robot, number, vector, work, factors):
    """``L^-1 r`` of a group into the workspace, and what it does to the border."""
    index, upper, solution = robot.slot_index[number], factors.upper, work.solution
    slots = robot.slots
    inner, first, first_motor = slots.inner_count, slots.first_coupled, slots.first_motor
    motors = robot.motor_slot_index[number]
    for slot in range(inner):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            put(solution, (number, slot), lane, vector[i] if i >= 0 else 0.0)
    for i in range(1, inner):
        value = load(solution, (number, i))
        for k in range(i):
            value -= load(upper, (number, k, i)) * load(solution, (number, k))
        store(solution, (number, i), value)
    for j in range(inner, robot.slots.total):
        value = broadcast(solution, 0.0)
        for k in range(first if j < first_motor else 0, inner):
            value -= load(upper, (number, k, j)) * load(solution, (number, k))
        if j < first_motor:
            work.border[j - inner] += total(value)
        else:
            m = j - first_motor
            store(work.motor_values, m, value)
            for lane in range(motors.shape[1]):
                if motors[m, lane] >= 0:
                    at = motors[m, lane] - robot.platform_index
                    work.border[at] += get(work.motor_values, m, lane)


@inlined
def _backward(robot, number, vector, work, factors):
    """``L^-T (D^-1 y - ...)`` of a group, into the vector."""
    index, upper, solution = robot.slot_index[number], factors.upper, work.solution
    slots = robot.slots
    inner, first, first_motor = slots.inner_count, slots.first_coupled, slots.first_motor
    motors = robot.motor_slot_index[number]
    for m in range(motors.shape[0]):
        for lane in range(motors.shape[1]):
            at = motors[m, lane] - robot.platform_index
            put(work.motor_values, m, lane, work.border[at] if motors[m, lane] >= 0 else 0.0)
    for i in range(inner - 1, -1, -1):
        value = load(factors.inverse, (number, i)) * load(solution, (number, i))
        for m in range(motors.shape[0]):
            value -= load(upper, (number, i, first_motor + m)) * load(work.motor_values, m)
        for j in range(i + 1, inner):
            value -= load(upper, (number, i, j)) * load(solution, (number, j))
        if i >= first:
            for j in range(inner, first_motor):
                value -= load(upper, (number, i, j)) * work.border[j - inner]
        store(solution, (number, i), value)
    for slot in range(inner):
        for lane in range(index.shape[1]):
            i = index[slot, lane]
            if i >= 0:
                vector[i] = get(solution, (number, slot), lane)
