# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The equilibrium at a request near by, in one call of a kernel: what a control loop asks for."""

from __future__ import annotations

from ..kernels.continuation_kernel import WATCHED
from ..model.equilibrium import Equilibrium, stepped
from .limits import grazes, margins, violated
from .targets import Target

__all__ = ["solve_near"]


def solve_near(start: Equilibrium, target: Target, stable_only: bool) -> Equilibrium | None:
    """What `continuation.follow` would find in a single step under the loads of the start.

    Returns:
        None where a walk has to tell: farther away, where Newton's method does not contract, a sign
        changes, or a limit may be passed; and where a pose leaves redundant motors free.
    """
    robot = start.robot
    if target.problem == "pose" and robot.redundancy > 0:
        return None
    if not start.loads.conservative(robot.planar):
        return None
    if stable_only and (start.index_free if target.problem == "efforts" else start.index_locked):
        return None
    found = stepped(
        start, robot, start.loads, start.load_arrays, target.problem, target.given(start), WATCHED
    )
    if found is None:
        return None
    return found if not robot.limited or _within_limits(start, found) else None


def _within_limits(start: Equilibrium, found: Equilibrium) -> bool:
    """Whether limits hold at the end of a step, and did all along."""
    after = margins(found)
    return not violated(found.robot, after) and not grazes(margins(start), after)
