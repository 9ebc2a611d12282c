# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One step of Newton's method from where nothing is in equilibrium yet."""

from __future__ import annotations

import math

from .condensation_kernel import NO_INVERSE
from .kernel_decorators import kernel
from .kernel_records import complete, read_pose, rods_exist, square_problem
from .model_kernel import evaluate, evaluate_residual
from .newton_kernel import move, scaled_residual
from .record_layout import EFFORT
from .square_problem import Configuration
from .tangent_kernel import factor, solve

__all__ = ["newton_step"]


@kernel
def newton_step(prepared, loads, problem, start, result):
    """One full step of Newton's method; what the problem imposes stays as it is.

    The tangent at the result is not factored: that would be half of another step.

    Args:
        prepared: PreparedRobot.
        loads: LoadArrays.
        problem: Of Problem.
        start: Record of which the state, the pose of the platform and the efforts are known.
        result: Record; it has no signs.

    Returns:
        Whether the tangent has an inverse and the step leads somewhere.
    """
    robot, work = prepared.robot, prepared.work
    square, size = square_problem(robot, problem), robot.unit.shape[0]
    state = result[:size]
    for i in range(size):
        state[i] = start[i]
    read_pose(robot, start, work)
    for i in range(size - robot.motor_index):
        work.given_efforts[i] = start[size + EFFORT + i]
    for i in range(work.signs.shape[0]):
        work.signs[i] = 0.0
    configuration = Configuration(state, work.rotation, work.position)
    evaluate(robot, loads, state, work.rotation, work.position, work.residual, work)
    largest = scaled_residual(robot, work.residual, work.given_efforts, square.equations, work.step)
    if not math.isfinite(largest):
        return False
    if factor(robot, work.rotation, square, work, work.factors) == NO_INVERSE:
        return False
    solve(robot, square, work.step, work, work.factors)
    move(robot, square, work.step, 1.0, configuration, work)
    if not rods_exist(robot, state):
        return False
    energy = evaluate_residual(
        robot, loads, state, work.rotation, work.position, work.residual, work
    )
    largest = scaled_residual(robot, work.residual, work.given_efforts, square.equations, work.step)
    complete(robot, energy, largest, 1, result, work)
    return math.isfinite(largest)
