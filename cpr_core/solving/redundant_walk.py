# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Walks to a target, also to a pose with more motors than controlled coordinates.

On the way the motors move as little as possible, by the pseudoinverse of the Jacobian, in stages. At the
pose they go along the null space to where an objective is least.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.natural_units import LONGEST_STEP
from ..lie import rotation_log
from ..model.equilibrium import Equilibrium
from ..model.kinemato_statics import KinematoStatics, kinemato_statics
from .continuation import Walk, follow
from .crossings import SINGULAR
from .deadline import Deadline
from .descent import descend
from .events import PathEvent
from .held_walks import HeldWalks, self_motions
from .objectives import LeastMotion, Objective
from .targets import PoseTarget, Target, pose_between

__all__ = ["walk_to"]

Floats = NDArray[np.float64]

#: A walk is lost where a stage gains less of the way than this.
_SMALLEST_STAGE = 1e-6
#: Most stages of a walk.
_MOST_STAGES = 1000
#: What stops a stage, but not the walk: with other motors imposed it may go on.
_OF_THE_CHOICE = ("fold", "bifurcation", "lost")


def walk_to(
    start: Equilibrium,
    target: Target,
    loads: Loads,
    *,
    objective: Objective | None = None,
    stable_only: bool = False,
    singularities: bool = False,
    time_limit: float | None = None,
) -> Walk:
    """Follow the branch of an equilibrium to a target, as ``follow``, also where motors are redundant.

    The parameters after the loads are independent options, given by name.

    Args:
        start: Equilibrium to start from.
        target: What to impose.
        loads: Loads to arrive with; they change along the way as well.
        objective: What the freedom of redundant motors is used for; default least motion from the start.
        stable_only: Stop where the stability index grows above zero.
        singularities: Locate inverse singularities on the way of motors or efforts too.
        time_limit: Give up after this time [s].

    Raises:
        InvalidRequest: A time limit that is negative or no number.
    """
    if not isinstance(target, PoseTarget) or start.robot.redundancy == 0:
        return follow(
            start,
            target,
            loads,
            stable_only=stable_only,
            singularities=singularities,
            time_limit=time_limit,
        )
    aim = LeastMotion(start.motors) if objective is None else objective
    walks = HeldWalks(stable_only, Deadline(time_limit))
    return _Redundant(target, loads, aim, walks).walk(start)


@dataclass(eq=False)
class _Redundant:
    """One walk: where to, and what was passed so far."""

    target: PoseTarget
    loads: Loads
    objective: Objective
    walks: HeldWalks
    events: list[PathEvent] = field(default_factory=list)

    def walk(self, start: Equilibrium) -> Walk:
        """Go to the pose, then to where the objective is least."""
        walk, objective = self._arrive(start), self.objective
        if walk.arrived:
            walk = descend(
                self.walks, walk.last, pose_between(walk.last, self.target, 1.0), objective
            )
            self.events += walk.events
        last = replace(walk.last.with_iterations(self.walks.iterations), objective=objective.name)
        return replace(walk, last=last, events=tuple(self.events))

    def _arrive(self, start: Equilibrium) -> Walk:
        """Stages to the pose, straight in its coordinates, by least motion of the motors."""
        reached, last = 0.0, start
        for _ in range(_MOST_STAGES):
            model, pose = kinemato_statics(last), pose_between(last, self.target, 1.0)
            try:
                change = _least_change(model, pose)
            except InvalidRequest:
                return self._lost(reached, last)
            distance = max(pose.distance(last), float(np.abs(change).max()))
            part = 1.0 if distance <= LONGEST_STEP else LONGEST_STEP / distance
            loads = self.loads if part == 1.0 else last.loads.toward(self.loads, part)
            stage = pose_between(last, self.target, part)
            walk = self.walks.step(last, self_motions(model), stage, part * change, loads)
            whole, last = part * (1.0 - reached), walk.last
            of_the_choice = walk.stopped is not None and walk.stopped.kind in _OF_THE_CHOICE
            for event in walk.events[:-1] if of_the_choice else walk.events:
                self.events.append(replace(event, fraction=reached + whole * event.fraction))
            if walk.stopped is not None:
                gained = whole * walk.stopped.fraction
                if not of_the_choice:
                    return walk
                if gained < _SMALLEST_STAGE:
                    singular = kinemato_statics(last).singular_values("inverse")[0] < SINGULAR
                    if singular:
                        return self._lost(reached + gained, last)
                    return self._stopped(walk.stopped, reached + gained)
                whole = gained
            elif part == 1.0:
                return walk
            elif whole < _SMALLEST_STAGE:
                return self._lost(reached, last)
            reached += whole
        return self._lost(reached, last)

    def _lost(self, fraction: float, last: Equilibrium) -> Walk:
        text = "the motors cannot move the platform farther on this way (an inverse singularity)"
        index = last.index_locked
        return self._stopped(PathEvent("fold", fraction, last, index, index, text), fraction)

    def _stopped(self, event: PathEvent, fraction: float) -> Walk:
        self.events.append(replace(event, fraction=fraction))
        return Walk(event.equilibrium, tuple(self.events), arrived=False)


def _least_change(model: KinematoStatics, pose: PoseTarget) -> Floats:
    """Least change of the motors to a pose, to first order, dimensionless, (n,)."""
    last = model.equilibrium
    robot, rotation = last.robot, last.platform_rotation
    turn = rotation_log(pose.rotation @ rotation.T)
    twist = np.concatenate([turn @ rotation, (pose.position - last.platform_position) @ rotation])
    return model.predict_inverse(twist[robot.platform_axes]).motors / robot.motor_units
