# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What kernels read from the record of an equilibrium, and write behind the state of the next."""

from __future__ import annotations

from .kernel_decorators import inlined
from .lanes import get
from .problems import Problem
from .record_layout import EFFORT, ENERGY, POSITION, RESIDUAL, ROTATION, SIGNS, STEPS
from .square_problem import SquareProblem

__all__ = ["complete", "fed_length", "read_pose", "rods_exist", "square_problem"]


@inlined
def square_problem(robot, problem):
    """What is unknown and what holds in a problem beside what is of the legs."""
    border = robot.border_indices
    equations = border if problem == Problem.EFFORTS else border[: robot.slots.platform_count]
    unknowns = robot.inverse_unknowns if problem == Problem.POSE else equations
    angles = problem == Problem.POSE and robot.controls_angles == 1
    return SquareProblem(equations, unknowns, angles)


@inlined
def read_pose(robot, record, work):
    """Platform pose of a record, into the workspace."""
    size = robot.unit.shape[0]
    for i in range(3):
        work.position[i] = record[size + POSITION + i]
        for j in range(3):
            work.rotation[i, j] = record[size + ROTATION + 3 * i + j]


@inlined
def fed_length(robot, number, r, lane, state):
    """Length of a rod that a motor feeds [m], of one leg."""
    rod = robot.rods[number, r]
    slot = rod.length_slot - robot.slots.first_motor
    ratio = get(robot.motor_ratio, (number, slot), lane)
    return rod.fed_zero[lane] + ratio * state[rod.length_index[lane]]


@inlined
def rods_exist(robot, state):
    """Whether all rods have a length."""
    if robot.extensible:
        for number in range(robot.groups.shape[0]):
            for r in range(robot.rods.shape[1]):
                index = robot.rods[number, r].length_index
                for lane in range(index.shape[0]):
                    if index[lane] >= 0 and not fed_length(robot, number, r, lane, state) > 0.0:
                        return False
    return True


@inlined
def complete(robot, energy, largest, steps, record, work):
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
