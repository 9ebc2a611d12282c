# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The equilibrium at a request near by, in one call of a kernel: what a control loop asks for."""

from __future__ import annotations

import numpy as np

from ..description.loads import Loads
from ..kernels.continuation_kernel import WATCHED
from ..kernels.natural_units import LONGEST_STEP
from ..model.equilibrium import Equilibrium, firm_margin
from ..model.equilibrium_steps import stepped, stepped_twice
from ..model.robot import Robot
from .hidden_changes import hidden_in_halves, may_hide_in_one_step
from .limits import limits_along, may_be_kept_again, undisturbed
from .targets import Target, apart
from .watching import Watching

__all__ = ["ALONE", "signs_tell", "solve_near"]

#: Longest step that is taken without a look halfway where something is watched that its ends may not
#: show, in longest steps of a walk. By effort it is the motors' way that counts, and longer ones are
#: walked.
ALONE = 0.1


def solve_near(start: Equilibrium, target: Target, stable_only: bool) -> Equilibrium | None:
    """What `continuation.follow` would find in a single step under the loads of the start.

    Returns:
        None where a walk has to tell: farther away, where Newton's method does not contract, a sign
        changes, or a limit, stability or an inverse singularity may be passed on the way; and where a
        pose leaves redundant motors free.
    """
    robot, pose, by_effort = start.robot, target.problem == "pose", target.problem == "efforts"
    if pose and robot.redundancy > 0:
        return None
    if not signs_tell(robot, start.loads, target.problem, stable_only):
        return None
    if stable_only and (start.index_free if by_effort else start.index_locked):
        return None
    watched = pose or may_be_kept_again(robot, target.problem)
    length = target.distance(start) / LONGEST_STEP if watched and not by_effort else 0.0
    if length > 1.0:
        return None
    if length > ALONE:
        return _looked_at_halfway(start, target, stable_only)
    end = _step(start, target)
    if end is None or (robot.limited and not _within_limits(start, end)):
        return None
    if watched and by_effort:  # near in what the motors do: a column hardly moves by large efforts
        length = float(apart(robot, "motors", start.motors, end.motors)) / LONGEST_STEP
        return end if length <= ALONE else None
    if stable_only and pose:
        before, after = firm_margin(start), firm_margin(end)
        if may_hide_in_one_step(before, after, length):
            return None
    return end


def signs_tell(robot: Robot, loads: Loads, problem: str, stable_only: bool) -> bool:
    """Whether the signs of a record tell what happens within a step.

    Those of stability are of the energy: under loads without a potential that of poses alone tells.
    """
    return robot.has_potential(loads) or (problem == "pose" and not stable_only)


def _step(start: Equilibrium, target: Target, fraction: float = 1.0) -> Equilibrium | None:
    """One step on the way from an equilibrium to a target, on which no sign changes."""
    given = target.given(start, fraction)
    return stepped(
        start, start.robot, start.loads, start.load_arrays, target.problem, given, WATCHED
    )


def _looked_at_halfway(start: Equilibrium, target: Target, stable_only: bool) -> Equilibrium | None:
    """Two steps, where nothing that is watched may change its sign in either of them."""
    robot, pose = start.robot, target.problem == "pose"
    if pose and not robot.platform_coordinates.poses_are_whole:
        reached = _one_after_the_other(start, target)
    else:
        given = np.concatenate((target.given(start, 0.5), target.given(start)))
        reached = stepped_twice(start, target.problem, given)
    if reached is None:
        return None
    way, end = (start, *reached), reached[1]
    watching = Watching(may_be_kept_again(robot, target.problem), pose and stable_only, pose)
    left = np.zeros((len(way), 0))
    if robot.limited:
        left = limits_along(robot, np.array([place.record for place in way]))
        if undisturbed(left) < len(way) - 1:
            return None
    watched = (
        watching.at(place, near, place.signs.inverse_sign)
        for place, near in zip(way, left, strict=True)
    )
    return None if hidden_in_halves(*watched) else end


def _one_after_the_other(
    start: Equilibrium, target: Target
) -> tuple[Equilibrium, Equilibrium] | None:
    """The same two steps where only the first one's end tells what the second one imposes."""
    middle = _step(start, target, 0.5)
    end = None if middle is None else _step(middle, target)
    if middle is None or end is None:
        return None
    return middle, end.with_iterations(middle.iterations + end.iterations)


def _within_limits(start: Equilibrium, end: Equilibrium) -> bool:
    """Whether limits hold at the end of a step, and did all along."""
    return undisturbed(limits_along(end.robot, np.array([start.record, end.record]))) == 1
