# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Entries from Python into the kernels, with a robot and its memory handed over once.

Taking a hundred arrays apart costs more than a small robot's solve. They are taken apart when a robot is
first used in a thread; from then on one object stands for all of them.
"""

from __future__ import annotations

from typing import Any

from ..numba_fence.typing_extension import structref, types
from .continuation_kernel import Requests, Start, continue_equilibria
from .kernel_decorators import compiled
from .linearisation_kernel import linearise
from .model_kernel import evaluate, tangent_into
from .square_problem import Tolerances

__all__ = [
    "PreparedRobot",
    "continue_prepared",
    "evaluate_prepared",
    "linearise_prepared",
    "prepare",
]


@structref.register
class _PreparedRobotType(types.StructRef):
    """Numba's type of a PreparedRobot."""

    def preprocess_fields(self, fields: Any) -> Any:
        """Field types as they are stored."""
        return tuple((name, types.unliteral(kind)) for name, kind in fields)


class PreparedRobot(structref.StructRefProxy):
    """RobotArrays, a Workspace and a Pencil, for one thread; made by ``prepare``."""


structref.define_proxy(PreparedRobot, _PreparedRobotType, ["robot", "work", "pencil"])


@compiled
def prepare(robot, work, pencil):
    """Take RobotArrays, a Workspace and a Pencil apart."""
    return PreparedRobot(robot, work, pencil)


@compiled
def evaluate_prepared(prepared, loads, state, rotation, position, residual, tangent):
    """``evaluate``, and ``tangent_into``; returns the energy."""
    energy = evaluate(prepared.robot, loads, state, rotation, position, residual, prepared.work)
    tangent_into(prepared.robot, prepared.work, tangent)
    return energy


@compiled
def continue_prepared(
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
    """``continue_equilibria``, given number by number: taking tuples apart costs a microsecond."""
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


@compiled
def linearise_prepared(prepared, kept, record, eigenvalues, response):
    """``linearise``."""
    return linearise(prepared.robot, kept, record, eigenvalues, response, prepared.pencil)
