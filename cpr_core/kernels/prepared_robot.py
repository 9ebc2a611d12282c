# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Entries from Python into the kernels, with a robot and its memory handed over once.

Taking a hundred arrays apart, and finding out which kernel fits their types, costs more than a small
robot's solve. Both is done when a robot is first used in a thread; then an address stands for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..numba_fence import entry_point
from ..numba_fence.borrowed_values import Borrowed, size_of, store
from .continuation_kernel import Requests, Start, continue_equilibria
from .kernel_arrays import RobotArrays, Workspace
from .kernel_decorators import kernel
from .linearisation_kernel import linearise
from .model_kernel import evaluate, tangent_into
from .pencil import Pencil
from .square_problem import Tolerances

__all__ = [
    "PreparedRobot",
    "continue_prepared",
    "evaluate_prepared",
    "linearise_prepared",
]


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
        memory = np.empty(_bytes_of(parts), np.uint8)
        _write(memory, parts)
        super().__init__(parts, memory)
        self.continued: Callable[..., int] | None = None


@kernel
def _bytes_of(parts):
    return size_of(parts)


@kernel
def _write(memory, parts):
    store(memory, parts)


@kernel
def evaluate_prepared(prepared, loads, state, rotation, position, residual, tangent):
    """``evaluate``, and ``tangent_into``; returns the energy."""
    energy = evaluate(prepared.robot, loads, state, rotation, position, residual, prepared.work)
    tangent_into(prepared.robot, prepared.work, tangent)
    return energy


def continue_prepared(
    prepared: PreparedRobot,
    loads: Any,
    problem: int,
    given: Any,
    mode: int,
    residual: float,
    iterations: int,
    contraction: float,
    *records: Any,
) -> int:
    """``continue_equilibria``, given number by number: taking tuples apart costs a microsecond.

    Args:
        prepared: PreparedRobot.
        loads: LoadArrays.
        problem: Of Requests.
        given: Of Requests.
        mode: Of Requests.
        residual: Of Tolerances.
        iterations: Of Tolerances.
        contraction: Of Tolerances.
        records: The record and the kept factors of the start; the records and kept factors to write.

    Returns:
        Number of steps that were made.
    """
    given = np.ascontiguousarray(given, float)
    arguments = (loads, problem, given, mode, residual, iterations, contraction, *records)
    continued = prepared.continued
    if continued is None:
        continued = prepared.continued = entry_point(_continue_prepared, prepared, *arguments)
    return continued(prepared, *arguments)


@kernel
def _continue_prepared(
    prepared,
    loads,
    problem,
    given,
    mode,
    residual,
    iterations,
    contraction,
    record,
    kept_before,
    records,
    kept,
):
    return continue_equilibria(
        prepared.robot,
        loads,
        Requests(problem, given, mode),
        Tolerances(residual, iterations, contraction),
        Start(record, kept_before),
        records,
        kept,
        prepared.work,
    )


@kernel
def linearise_prepared(prepared, kept, record, eigenvalues, response):
    """``linearise``."""
    return linearise(prepared.robot, kept, record, eigenvalues, response, prepared.pencil)
