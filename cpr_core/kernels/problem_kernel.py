# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a problem is about in a robot, and where the platform is in a record."""

from __future__ import annotations

from .kernel_decorators import inlined
from .problems import Problem
from .record_layout import POSITION, ROTATION
from .square_problem import SquareProblem

__all__ = ["read_pose", "square_of"]


@inlined
def square_of(robot, problem):
    """The SquareProblem of one of Problem."""
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
