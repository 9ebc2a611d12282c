# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Along the null space of a pose to where an objective is least."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..model.equilibrium import Equilibrium
from ..model.kinemato_statics import kinemato_statics
from .continuation import Walk
from .events import PathEvent
from .held_walks import HeldWalks, self_motions
from .objectives import Objective
from .targets import PoseTarget

__all__ = ["descend"]

Floats = NDArray[np.float64]

#: Steps at most, and the longest of them, dimensionless.
_MOST_STEPS, _LONGEST_DESCENT = 200, 0.3


def descend(walks: HeldWalks, start: Equilibrium, pose: PoseTarget, objective: Objective) -> Walk:
    """Quasi-Newton steps (BFGS), each a walk to exactly the pose.

    They end where a limit, a fold or rounding is in the way.

    Args:
        walks: How walks are made.
        start: Equilibrium at the pose.
        pose: The pose.
        objective: What is made least.

    Returns:
        Walk to the best equilibrium, its events at fraction 1; stopped where the time is over.
    """
    way, last, events = _WayDown(walks, pose, objective), start, list[PathEvent]()
    directions = self_motions(kinemato_statics(last))
    slope = way.slope(last, directions)
    curvature = _whole(objective.curvature(last, directions), directions)
    for _ in range(_MOST_STEPS):
        change = -np.linalg.solve(directions.T @ curvature @ directions, slope)
        length = float(np.linalg.norm(change))
        if length < objective.tolerance:
            break
        shortened = np.asarray(change * min(1.0, _LONGEST_DESCENT / length))
        walk = way.step(last, directions, shortened, float(slope @ shortened))
        if walk is None:
            break
        events += [replace(event, fraction=1.0) for event in walk.events]
        if not walk.arrived:
            return replace(walk, events=tuple(events))
        moved = (walk.last.motors - last.motors) / last.robot.motor_units
        before = directions @ slope
        last, directions = walk.last, self_motions(kinemato_statics(walk.last))
        slope = way.slope(last, directions)
        curvature = _learnt(curvature, moved, directions @ slope - before)
    return Walk(last, tuple(events))


@dataclass(frozen=True, eq=False)
class _WayDown:
    """An objective at a pose, and how to walk along its null space, whose columns are (n, k)."""

    walks: HeldWalks
    pose: PoseTarget
    objective: Objective

    def slope(self, last: Equilibrium, directions: Floats) -> Floats:
        """Slope of the objective along the directions, (k,)."""

        def probe(change: Floats) -> Equilibrium | None:
            walk = self.walks.step(last, directions, self.pose, change)
            return walk.last if walk.arrived else None

        return self.objective.slope(last, directions, probe)

    def step(
        self, last: Equilibrium, directions: Floats, change: Floats, expected: float
    ) -> Walk | None:
        """A step by a change along the directions, as short as it takes to lower the objective.

        Args:
            last: Where it begins.
            directions: Of the null space there.
            change: The whole step, (k,).
            expected: What the whole step would change the objective by, to first order.

        Returns:
            None where none lowers it; a walk that was stopped where the time is over.
        """
        value, factor = self.objective.value(last), 1.0
        rounding = 1e-14 * (1.0 + abs(value))
        while factor * float(np.linalg.norm(change)) >= self.objective.tolerance:
            walk = self.walks.step(last, directions, self.pose, factor * directions @ change)
            if walk.stopped is None:
                if self.objective.value(walk.last) <= value + 0.1 * factor * expected + rounding:
                    return walk
            elif walk.stopped.kind == "time_limit":
                return walk
            factor *= 0.5
        return None


def _whole(curvature: Floats, directions: Floats) -> Floats:
    """A curvature along directions as one of all motors, positive definite, (n, n)."""
    across = np.eye(len(directions)) - directions @ directions.T
    mean = float(np.trace(curvature)) / len(curvature)
    return np.asarray(directions @ curvature @ directions.T + mean * across)


def _learnt(curvature: Floats, moved: Floats, changed: Floats) -> Floats:
    """BFGS: a curvature by which a motion changes the slope as it did; the same where it is negative."""
    product, pushed = float(moved @ changed), curvature @ moved
    if product <= 1e-8 * float(np.linalg.norm(moved) * np.linalg.norm(changed)):
        return curvature
    worn = np.outer(pushed, pushed) / float(moved @ pushed)
    return np.asarray(curvature - worn + np.outer(changed, changed) / product)
