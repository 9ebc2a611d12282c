# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From an equilibrium to a request: in one step where it is near, else by a walk along the branch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..description.doubted_requests import quaternion_order_doubt, request_doubt
from ..description.loads import Loads
from ..lie import quaternion_from_rotation
from ..model.equilibrium import Equilibrium
from ..validation import checked_time
from .continuation import Walk
from .events import PathEvent
from .limits import check_limits, limit_error
from .near_request import solve_near
from .not_reached import NotReached, refusal_of
from .objectives import objective_of
from .redundant_walk import walk_to
from .requests import target_of
from .targets import MotorTarget, PoseTarget, Target

__all__ = ["solve_from"]

#: Time that a single step never takes, once it is compiled [s].
_ONE_STEP = 0.01
#: Poses nearer to each other are one [1, m, rad].
_ROUNDING = 1e-14


def solve_from(
    start: Equilibrium,
    problem: str,
    values: ArrayLike,
    *,
    loads: Loads | None = None,
    stable_only: bool = False,
    time_limit: float | None = None,
    objective: str | None = None,
) -> Equilibrium:
    """The equilibrium at a request, on the branch of the start.

    Args:
        start: Equilibrium whose branch is followed.
        problem: ``motors``, ``pose`` or ``efforts``.
        values: Numbers of the request.
        loads: Loads; default those of the start.
        stable_only: Refuse to pass or reach an unstable equilibrium.
        time_limit: Give up after this time [s]; default never.
        objective: What the freedom of redundant motors is used for, see ``solve_inverse``.

    Raises:
        InvalidRequest: Wrong number of values, or loads that do not fit the robot.
        NotReached: As in ``solve_forward``.
    """
    target = target_of(start, problem, values)
    aim = None
    if objective is not None or (problem == "pose" and start.robot.redundancy > 0):
        aim = objective_of(start, problem, objective)
    near = aim is None and (loads is None or loads is start.loads)
    if near and (time_limit is None or checked_time(time_limit) > _ONE_STEP):
        equilibrium = solve_near(start, target, stable_only)
        if equilibrium is not None:
            return equilibrium
        if _is_there(start, target) and not (stable_only and start.index_locked):
            return start.with_iterations(0)
    walk = walk_to(
        start,
        target,
        start.loads if loads is None else loads,
        objective=aim,
        stable_only=stable_only,
        time_limit=time_limit,
    )
    if walk.stopped is not None:
        others = () if loads is None else start.loads.differences(loads)
        raise _not_reached(walk.stopped, walk, start, target, others, stable_only)
    check_limits(walk.last)
    return walk.last


def _is_there(start: Equilibrium, target: Target) -> bool:
    """Whether a pose is that of the start: at an inverse singularity rounding would lead anywhere."""
    if target.problem != "pose":
        return False
    own = [start.platform_rotation.ravel(), start.platform_position, start.motors]
    return bool(np.abs(target.given(start)[0] - np.concatenate(own)).max() <= _ROUNDING)


def _doubt(start: Equilibrium, target: Target) -> str:
    """What looks like another unit or order of numbers in a target, in words; empty: nothing."""
    description = start.robot.description
    if isinstance(target, MotorTarget):
        return request_doubt(description, target.motors, None)
    if isinstance(target, PoseTarget):
        return request_doubt(description, None, target.position) or quaternion_order_doubt(
            quaternion_from_rotation(target.rotation), start.platform_quaternion
        )
    return ""


def _not_reached(
    event: PathEvent,
    walk: Walk,
    start: Equilibrium,
    target: Target,
    others: Sequence[str],
    stable_only: bool,
) -> NotReached:
    """The error of a walk that was stopped; ``others``: which loads are not those of the start."""
    if walk.violation is not None:
        violation, beyond = walk.violation
        requested = target.motors if isinstance(target, MotorTarget) else None
        return limit_error(beyond, violation, event.fraction, event, requested)
    motors = ", ".join(f"{value:.4g}" for value in walk.last.motors)
    position = ", ".join(f"{value:.4g}" for value in walk.last.platform_position)
    under = f" under other loads ({', '.join(others)})" if others else ""
    text = (
        f"{target.problem}{under}: not reached from the start, {event.message}: its branch could be "
        f"followed over {100.0 * event.fraction:.2f} % of the way, to motors ({motors}) "
        f"and platform position ({position})"
    )
    doubt = _doubt(start, target)
    text += f"; {doubt}" if doubt else ""
    return refusal_of(event, text, walk.last, target.problem, stable_only)
