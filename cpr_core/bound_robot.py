# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Entries from Python into the kernels, with a robot and its memory handed over once.

Taking a hundred arrays apart costs more than a small robot's solve. They are taken apart when a robot is
first used in a thread; from then on one object stands for all of them.
"""

from __future__ import annotations

from typing import Any

from .first_order_kernel import first_order_into
from .kernel_decorators import compiled
from .model_kernel import assemble, evaluate
from .numba_fence.typing_extension import structref, types
from .step_kernel import go_on

__all__ = [
    "BoundRobot",
    "bind",
    "evaluate_bound",
    "first_order_bound",
    "go_on_bound",
]


@structref.register
class _BoundRobotType(types.StructRef):
    """Numba's type of a BoundRobot."""

    def preprocess_fields(self, fields: Any) -> Any:
        """Field types as they are stored."""
        return tuple((name, types.unliteral(kind)) for name, kind in fields)


class BoundRobot(structref.StructRefProxy):
    """RobotArrays, a Workspace and a Pencil, for one thread; made by ``bind``."""


structref.define_proxy(BoundRobot, _BoundRobotType, ["robot", "work", "pencil"])


@compiled
def bind(robot, work, pencil):
    """Take RobotArrays, a Workspace and a Pencil apart."""
    return BoundRobot(robot, work, pencil)


@compiled
def evaluate_bound(bound, loads, state, rotation, position, residual, tangent):
    """``evaluate``, and ``assemble``; returns the energy."""
    energy = evaluate(bound.robot, loads, state, rotation, position, residual, bound.work)
    assemble(bound.robot, bound.work, tangent)
    return energy


@compiled
def go_on_bound(
    bound, loads, problem, given, how, tolerance, iterations, contraction, before, factors, records,
    after,
):  # fmt: skip
    """``go_on``."""
    return go_on(
        bound.robot, loads, problem, given, how, tolerance, iterations, contraction, before, factors,
        records, after, bound.work,
    )  # fmt: skip


@compiled
def first_order_bound(bound, kept, record, eigenvalues, response):
    """``first_order_into``."""
    return first_order_into(bound.robot, kept, record, eigenvalues, response, bound.pencil)
