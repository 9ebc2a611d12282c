# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Closing the joints of a shape that is in no equilibrium, by the smallest motions."""

from __future__ import annotations

import math

from .kernel_decorators import inlined, kernel
from .kernel_records import square_problem
from .lu_kernel import lu_factor, lu_solve
from .model_kernel import evaluate, evaluate_residual, tangent_into
from .newton_kernel import move
from .problems import Problem
from .square_problem import Configuration

__all__ = ["close_joints"]

#: At most so many steps, none longer than one, to gaps below this (dimensionless).
_STEPS, _CLOSED = 30, 1e-3
#: A joint that nothing can move to (a straight rod is one, along itself) stays open: relative.
_DAMPING = 1e-12


@kernel
def close_joints(prepared, loads, forces, held, state, rotation, position):
    """Bring the platform between the tips, then pull the joints together, the motors held.

    With gaps Psi and their slopes J, both dimensionless, a step is ``-J^T (J J^T)^-1 Psi``: of all that
    close the linear gaps the one of the least norm.

    Args:
        prepared: PreparedRobot.
        loads: LoadArrays.
        forces: State indices of the multipliers of positions, leg by leg, (L, 2) or (L, 3).
        held: State indices of all multipliers, (m,).
        state: Shape (N,), with the motors; on return that of the closed shape.
        rotation: R_p in the world, (3, 3), as well.
        position: Result, p_p in the world, (3,).

    Returns:
        Whether they close.
    """
    robot, work = prepared.robot, prepared.work
    problem = square_problem(robot, Problem.MOTORS)
    configuration = Configuration(state, rotation, position)
    _between_tips(robot, loads, forces, configuration, work)
    tangent, size = work.symmetric, held.shape[0]
    for i in range(robot.unit.shape[0]):
        for j in range(robot.unit.shape[0]):
            tangent[i, j] = 0.0
    for _ in range(_STEPS):
        evaluate(robot, loads, state, rotation, position, work.residual, work)
        closed = True
        for row in range(size):
            i = held[row]
            gap = work.residual[i] * robot.unit[i] / robot.energy_unit
            closed = closed and abs(gap) < _CLOSED  # never so of a NaN
            work.part[row] = gap
        if closed:
            return True
        tangent_into(robot, work, tangent)
        _scale_slopes(robot, held, tangent)
        if not _shortest_step(robot, held, tangent, work):
            return False
        move(robot, problem, work.step, 1.0, configuration, work)
    return False


@inlined
def _between_tips(robot, loads, forces, configuration, work):
    """Platform position where its joints are on average at the tips."""
    state, rotation, position = configuration
    for axis in range(3):
        position[axis] = 0.0
    evaluate_residual(robot, loads, state, rotation, position, work.residual, work)
    legs = forces.shape[0]
    for leg in range(legs):
        for axis in range(forces.shape[1]):
            position[axis] -= work.residual[forces[leg, axis]] / legs


@inlined
def _scale_slopes(robot, held, tangent):
    """Make the rows of the constraints in a tangent dimensionless, but at the motors."""
    for row in range(held.shape[0]):
        i = held[row]
        unit, slope = robot.unit[i] / robot.energy_unit, tangent[i]
        for j in range(robot.motor_index):
            slope[j] *= unit * robot.unit[j]


@inlined
def _shortest_step(robot, held, slopes, work):
    """The step into ``work.step``, of gaps in ``work.part``; returns whether there is one.

    What is taken off is written, as Newton's method has it. Slopes by multipliers are zero.
    """
    size, last, stiffness, pull = held.shape[0], robot.motor_index, work.square, work.part
    trace = 0.0
    for row in range(size):
        slope = slopes[held[row]]
        for column in range(row + 1):
            other_slope, total = slopes[held[column]], 0.0
            for j in range(last):
                total += slope[j] * other_slope[j]
            stiffness[row, column] = stiffness[column, row] = total
        trace += stiffness[row, row]
    for row in range(size):
        stiffness[row, row] += _DAMPING * trace
    if not lu_factor(stiffness, size, work.pivots, 0.0):
        return False
    lu_solve(stiffness, size, work.pivots, pull)
    squared, step = 0.0, work.step
    for j in range(last):
        step[j] = 0.0
    for row in range(size):
        slope = slopes[held[row]]
        for j in range(last):
            step[j] += pull[row] * slope[j]
    for j in range(last):
        squared += step[j] * step[j]
    shorter = 1.0 / math.sqrt(max(1.0, squared))
    for j in range(last):
        step[j] *= shorter
    return True
