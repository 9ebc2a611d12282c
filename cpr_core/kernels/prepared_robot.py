# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Entries from Python into the kernels, with a robot and its memory handed over once.

Taking a hundred arrays apart, and finding out which kernel fits their types, costs more than a small
robot's solve. Both is done when a robot is first used in a thread; then an address stands for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..numba_fence import entry_point
from ..numba_fence.borrowed_values import Borrowed, size_of, store
from .condensation_kernel import CONDENSED
from .continuation_kernel import continue_equilibria
from .kept_factors import kept_status, recalled
from .kernel_arrays import RobotArrays
from .kernel_decorators import kernel
from .kernel_records import read_pose, square_problem
from .linearisation_kernel import linearise
from .model_kernel import evaluate, tangent_into
from .newton_step_kernel import newton_step
from .pencil import Pencil
from .singularity_kernel import smallest_singular_value
from .workspace_arrays import Workspace

__all__ = [
    "PreparedRobot",
    "continue_prepared",
    "evaluate_prepared",
    "evaluate_record",
    "linearise_prepared",
    "newton_step_prepared",
    "singular_value_prepared",
]


#: Machine code by types of robots and kernels.
_machine_code: dict[int, dict[Any, Callable[..., Any]]] = {}
#: Bytes that are enough for the parts, as a rule.
_SIZE = 1 << 15


class _Parts(NamedTuple):
    """What kernels need of a robot."""

    robot: RobotArrays
    work: Workspace
    pencil: Pencil


class PreparedRobot(Borrowed):
    """RobotArrays, a Workspace and a Pencil, for one thread."""

    def __init__(self, robot: RobotArrays, work: Workspace, pencil: Pencil) -> None:
        """Take them apart."""
        parts = _Parts(robot, work, pencil)
        memory = np.empty(_SIZE, np.uint8)
        if (size := _write(memory, parts)) > len(memory):
            memory = np.empty(size, np.uint8)
            _write(memory, parts)
        super().__init__(parts, memory)
        self._machine_code = _machine_code.setdefault(self.kind, {})

    def code_of(self, kernel: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
        """Machine code of a kernel, whose types are looked at once for robots of the same types.

        Args:
            kernel: The kernel; it takes this robot first.
            arguments: What it takes behind it.
        """
        code = self._machine_code.get(kernel)
        if code is None:
            code = self._machine_code[kernel] = entry_point(kernel, self, *arguments)
        return code


@kernel
def _write(memory, parts):
    """Write parts to memory, if it is large enough; returns how many bytes they take."""
    size = size_of(parts)
    if memory.shape[0] >= size:
        store(memory, parts)
    return size


def evaluate_prepared(prepared: PreparedRobot, *arguments: Any) -> float:
    """``evaluate``, and ``tangent_into``; returns the energy."""
    return prepared.code_of(_evaluate, arguments)(prepared, *arguments)


@kernel
def _evaluate(prepared, loads, state, rotation, position, residual, tangent):
    energy = evaluate(prepared.robot, loads, state, rotation, position, residual, prepared.work)
    tangent_into(prepared.robot, prepared.work, tangent)
    return energy


def evaluate_record(prepared: PreparedRobot, *arguments: Any) -> None:
    """``evaluate`` at an equilibrium: its tangent is in the workspace afterwards."""
    prepared.code_of(_evaluate_record, arguments)(prepared, *arguments)


@kernel
def _evaluate_record(prepared, loads, record):
    robot, work = prepared.robot, prepared.work
    read_pose(robot, record, work)
    evaluate(robot, loads, record, work.rotation, work.position, work.residual, work)


def continue_prepared(
    prepared: PreparedRobot, loads: Any, problem: int, given: Any, *others: Any
) -> int:
    """``continue_equilibria``; what is given need not be in one piece."""
    arguments = (loads, problem, np.ascontiguousarray(given, float), *others)
    return prepared.code_of(continue_equilibria, arguments)(prepared, *arguments)


def newton_step_prepared(prepared: PreparedRobot, *arguments: Any) -> bool:
    """``newton_step``."""
    return prepared.code_of(newton_step, arguments)(prepared, *arguments)


def linearise_prepared(prepared: PreparedRobot, *arguments: Any) -> tuple[bool, bool]:
    """``linearise``."""
    return prepared.code_of(linearise, arguments)(prepared, *arguments)


def singular_value_prepared(prepared: PreparedRobot, *arguments: Any) -> float:
    """``smallest_singular_value`` at an equilibrium; nothing is evaluated again.

    Args:
        prepared: The robot.
        arguments: Of Problem; ProblemScales; the record of the equilibrium; its kept factors; whether
            these are in the workspace already.

    Returns:
        The value; NaN where slots were delayed: such factors are not kept.
    """
    return prepared.code_of(_singular_value, arguments)(prepared, *arguments)


@kernel
def _singular_value(prepared, problem, scales, record, kept, evaluated):
    robot, work, factors = prepared.robot, prepared.work, prepared.work.factors
    if not evaluated:
        if kept_status(kept) != CONDENSED:
            return math.nan
        factors = recalled(robot, kept, work.factors)
    read_pose(robot, record, work)
    square = square_problem(robot, problem)
    return smallest_singular_value(robot, square, scales, work.rotation, work, factors)
