# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What parameters do to the residual, and to an equilibrium: all of them in one call each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .border_kernel import factor_border
from .condensation_kernel import CONDENSED, NO_INVERSE
from .kept_factors import kept_status, recalled
from .kernel_decorators import inlined, kernel
from .kernel_records import read_pose, square_problem
from .model_kernel import evaluate, evaluate_residual
from .tangent_kernel import expand_legs, factor, reduce_legs

__all__ = ["Variations", "answer_rates", "vary_residual"]


class Variations(NamedTuple):
    """How P parameters are varied in the numbers of a robot and its loads."""

    starts: NDArray[np.int64]  # (P + 1,) where those of a parameter begin; the end of all
    places: NDArray[np.int64]  # (K,) among the numbers
    rates: NDArray[np.float64]  # (K,) change per change of the parameter
    steps: NDArray[np.float64]  # (P,) change of the parameter to try; 0: it changes nothing
    linear: NDArray[np.bool_]  # (P,) whether the residual is linear in it


@kernel
def vary_residual(prepared, loads, numbers, memory, variations, record, rates):
    """Derivatives of the residual by parameters, the state held.

    Central differences; where the residual is linear a single one, exact.

    Args:
        prepared: PreparedRobot.
        loads: LoadArrays.
        numbers: The memory in which arrays of both are, as numbers; on return it is as it was.
        memory: As many numbers.
        variations: Variations of them.
        record: The state and the platform's pose, see `record_layout`.
        rates: Result, (P, N), in the order of the state, SI units; motor rows are those of efforts.

    Returns:
        How many residuals it took.
    """
    robot, work = prepared.robot, prepared.work
    size, middle, behind = robot.unit.shape[0], work.correction, work.residual
    state, rotation, position = record[:size], work.rotation, work.position
    read_pose(robot, record, work)
    count, middle_known = 0, False
    for row in range(rates.shape[0]):
        ahead, step = rates[row], variations.steps[row]
        if step == 0.0:
            for i in range(size):
                ahead[i] = 0.0
            continue
        if variations.linear[row] and not middle_known:
            evaluate_residual(robot, loads, state, rotation, position, middle, work)
            count, middle_known = count + 1, True
        _change(numbers, variations, row, step, memory)
        evaluate_residual(robot, loads, state, rotation, position, ahead, work)
        _restore(numbers, variations, row, memory)
        count += 1
        if variations.linear[row]:
            for i in range(size):
                ahead[i] = (ahead[i] - middle[i]) / step
            continue
        _change(numbers, variations, row, -step, memory)
        evaluate_residual(robot, loads, state, rotation, position, behind, work)
        _restore(numbers, variations, row, memory)
        count += 1
        for i in range(size):
            ahead[i] = (ahead[i] - behind[i]) / (2.0 * step)
    return count


@inlined
def _change(numbers, variations, row, step, memory):
    """Add a step of a parameter; what was there goes to the memory."""
    for k in range(variations.starts[row], variations.starts[row + 1]):
        place = variations.places[k]
        memory[place] = numbers[place]
        numbers[place] += step * variations.rates[k]


@inlined
def _restore(numbers, variations, row, memory):
    """Undo it, to the last bit."""
    for k in range(variations.starts[row], variations.starts[row + 1]):
        place = variations.places[k]
        numbers[place] = memory[place]


@kernel
def answer_rates(prepared, loads, problem, kept, record, rates, states, efforts):
    """How an equilibrium answers to changes of the residual.

    Args:
        prepared: PreparedRobot.
        loads: LoadArrays.
        problem: Of Problem: what is held.
        kept: Factors of the tangent (``keep``); where they are not kept it is evaluated again.
        record: The solution, see `record_layout`.
        rates: Of the residual, (P, N), SI units.
        states: Result, rates of the state, (P, N), platform rows world twists.
        efforts: Result, rates of the efforts, (P, n).

    Returns:
        Whether there are any: the problem is not singular.
    """
    robot, work = prepared.robot, prepared.work
    factors, square = work.factors, square_problem(robot, problem)
    size, inner = robot.unit.shape[0], robot.platform_index
    read_pose(robot, record, work)
    if kept_status(kept) == CONDENSED:
        factors = recalled(robot, kept, factors)
        if not factor_border(robot, work.rotation, square, work, factors):
            return False
    else:
        evaluate(robot, loads, record[:size], work.rotation, work.position, work.residual, work)
        if factor(robot, work.rotation, square, work, factors) == NO_INVERSE:
            return False
    unit, border, vector, reduced = robot.unit, work.border, work.step, work.correction
    per_energy, count = 1.0 / robot.energy_unit, robot.border_indices.shape[0]
    motors = efforts.shape[1]
    for row in range(rates.shape[0]):
        for i in range(size):
            value = -rates[row, i] * unit[i] * per_energy
            if i < inner:
                vector[i] = value
            else:
                border[i - inner] = value
        reduce_legs(robot, vector, work, factors)
        for i in range(count):
            reduced[i] = border[i]
        expand_legs(robot, square, vector, work, factors)
        for i in range(size):
            states[row, i] = unit[i] * (vector[i] if i < inner else border[i - inner])
        for m in range(motors):
            i = count - motors + m
            effort = -reduced[i]
            for j in range(count + factors.delayed_count[0]):
                effort += factors.border[i, j] * border[j]
            efforts[row, m] = effort / (per_energy * unit[inner + i])
    return True
