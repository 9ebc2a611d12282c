# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Walks to a pose with more motors than controlled coordinates.

On the way the motors move as little as possible: as many of them as are too many are imposed beside the
pose, by what the pseudoinverse of the Jacobian says, chosen anew for every stage so that the others find
the pose as surely as possible. What is left is a square problem and one of the usual walks. At the pose
the motors then go along the null space to where an objective is least, by quasi-Newton steps, each of
them such a walk.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.natural_units import LONGEST_STEP
from ..kernels.record_layout import INVERSE_SIGN, SIGNS
from ..lie import rotation_log
from ..model.equilibrium import Equilibrium, described
from ..model.kinemato_statics import KinematoStatics, kinemato_statics
from ..model.robot import Robot
from ..validation import checked_time
from .continuation import SINGULAR, Walk, follow
from .events import PathEvent
from .near_request import solve_near
from .objectives import LeastMotion, Objective, Probe
from .targets import PoseTarget, Target, pose_between

__all__ = ["walk_to"]

Floats = NDArray[np.float64]

#: A stage that gains less of the way is none.
_SMALLEST_STAGE = 1e-6
#: Stages, and steps along the null space, at most; the longest of these, dimensionless.
_MOST_STAGES, _MOST_DESCENTS, _LONGEST_DESCENT = 1000, 200, 0.3
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
    progress: Callable[[float], None] | None = None,
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
        progress: Called with the fraction reached.

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
            progress=progress,
        )
    deadline = time.perf_counter() + checked_time(time_limit)
    aim = LeastMotion(start.motors) if objective is None else objective
    return _Redundant(target, loads, aim, stable_only, deadline, progress).walk(start)


@dataclass(eq=False)
class _Redundant:
    """One walk: where to, and what was passed so far."""

    target: PoseTarget
    loads: Loads
    objective: Objective
    stable_only: bool
    deadline: float
    progress: Callable[[float], None] | None
    events: list[PathEvent] = field(default_factory=list)
    iterations: int = 0

    def walk(self, start: Equilibrium) -> Walk:
        """Go to the pose, then to where the objective is least."""
        arrived = self._arrive(start)
        if arrived.stopped is None:
            arrived = self._descend(arrived.last)
        last = replace(arrived.last.with_iterations(self.iterations), objective=self.objective.name)
        return replace(arrived, last=last, events=tuple(self.events))

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
            walk = self._step(last, _directions(model), stage, part * change, loads)
            whole, last = part * (1.0 - reached), walk.last
            of_the_choice = walk.stopped is not None and walk.stopped.kind in _OF_THE_CHOICE
            for event in walk.events[:-1] if of_the_choice else walk.events:
                self.events.append(replace(event, fraction=reached + whole * event.fraction))
            if walk.stopped is not None:
                gained = whole * walk.stopped.fraction
                if not of_the_choice:
                    return replace(walk, stopped=self.events[-1])
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
            if self.progress is not None:
                self.progress(reached)
        return self._lost(reached, last)

    def _lost(self, fraction: float, last: Equilibrium) -> Walk:
        text = "the motors cannot move the platform farther on this way (an inverse singularity)"
        index = last.index_locked
        return self._stopped(PathEvent("fold", fraction, last, index, index, text), fraction)

    def _stopped(self, event: PathEvent, fraction: float) -> Walk:
        self.events.append(replace(event, fraction=fraction))
        return Walk(event.equilibrium, (), self.events[-1], None, ())

    def _descend(self, start: Equilibrium) -> Walk:
        """Quasi-Newton steps (BFGS) along the null space to where the objective is least.

        They end where a limit, a fold or rounding is in the way.
        """
        objective, last = self.objective, start
        self.target = pose_between(start, self.target, 1.0)
        directions = _directions(kinemato_statics(last))
        slope = objective.slope(last, directions, self._probe(last, directions))
        curvature = _whole(objective.curvature(last, directions), directions)
        for _ in range(_MOST_DESCENTS):
            change = -np.linalg.solve(directions.T @ curvature @ directions, slope)
            length = float(np.linalg.norm(change))
            if length < objective.tolerance:
                break
            shortened = np.asarray(change * min(1.0, _LONGEST_DESCENT / length))
            found = self._lower(last, directions, shortened, float(slope @ shortened))
            if found is None:
                break
            if found.stopped is not None:
                self.events.append(replace(found.stopped, fraction=1.0))
                return replace(found, stopped=self.events[-1])
            moved = (found.last.motors - last.motors) / last.robot.motor_units
            before = directions @ slope
            last, directions = found.last, _directions(kinemato_statics(found.last))
            slope = objective.slope(last, directions, self._probe(last, directions))
            curvature = _learnt(curvature, moved, directions @ slope - before)
        return Walk(last, (), None, None, ())

    def _lower(
        self, last: Equilibrium, directions: Floats, change: Floats, expected: float
    ) -> Walk | None:
        """A step along the null space, as short as it takes to lower the objective.

        Returns:
            None where none does; a walk that was stopped where the time is over.
        """
        objective, factor = self.objective, 1.0
        value = objective.value(last)
        rounding = 1e-14 * (1.0 + abs(value))
        while factor * float(np.linalg.norm(change)) >= objective.tolerance:
            walk = self._step(last, directions, self.target, factor * directions @ change)
            if walk.stopped is None:
                if objective.value(walk.last) <= value + 0.1 * factor * expected + rounding:
                    return walk
            elif walk.stopped.kind == "time_limit":
                return walk
            factor *= 0.5
        return None

    def _probe(self, last: Equilibrium, directions: Floats) -> Probe:
        def probe(change: Floats) -> Equilibrium | None:
            walk = self._step(last, directions, self.target, change)
            return walk.last if walk.stopped is None else None

        return probe

    def _step(
        self,
        start: Equilibrium,
        directions: Floats,
        pose: PoseTarget,
        change: Floats,
        loads: Loads | None = None,
    ) -> Walk:
        """To a pose, with a rough change of the motors (dimensionless, (n,)): exact in some of them."""
        robot, loads = start.robot, start.loads if loads is None else loads
        begin = _of(start, robot.holding(_imposed_motors(directions)))
        target = replace(pose, motors=start.motors + change * robot.motor_units)
        if loads is start.loads and target.distance(begin) <= LONGEST_STEP:
            near = solve_near(begin, target, self.stable_only)
            if near is not None:
                self.iterations += near.iterations
                return Walk(_of_base(near, robot), (), None, None, ())
        walk = follow(
            begin,
            target,
            loads,
            stable_only=self.stable_only,
            time_limit=max(0.0, self.deadline - time.perf_counter()),
        )
        self.iterations += walk.last.iterations
        return _walk_of_base(walk, robot)


def _least_change(model: KinematoStatics, pose: PoseTarget) -> Floats:
    """Least change of the motors to a pose, to first order, dimensionless, (n,)."""
    last = model.equilibrium
    robot, rotation = last.robot, last.platform_rotation
    turn = rotation_log(pose.rotation @ rotation.T)
    twist = np.concatenate([turn @ rotation, (pose.position - last.platform_position) @ rotation])
    return model.predict_inverse(twist[robot.platform_axes]).motors / robot.motor_units


def _directions(model: KinematoStatics) -> Floats:
    """Self-motions, dimensionless, orthonormal columns, (n, r)."""
    return np.asarray(model.self_motions / model.equilibrium.robot.motor_units[:, None])


def _imposed_motors(directions: Floats) -> tuple[int, ...]:
    """Numbers of the motors to impose, so that the others find the pose as surely as possible.

    Those that move most in self-motions, (n, r), one after the other: what is left of the Jacobian is
    farthest from singular then.
    """
    left, chosen = directions.copy(), list[int]()
    for _ in range(directions.shape[1]):
        motor = int(np.argmax(np.sum(left**2, axis=1)))
        chosen.append(motor)
        row = left[motor] / np.linalg.norm(left[motor])
        left -= np.outer(left @ row, row)
    return tuple(sorted(chosen))


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


def _of(equilibrium: Equilibrium, robot: Robot) -> Equilibrium:
    """An equilibrium as one of a robot that holds some motors."""
    found = equilibrium
    return described(
        robot,
        found.loads,
        found.load_arrays,
        found.state,
        found.platform_rotation,
        found.platform_position,
    )


def _of_base(equilibrium: Equilibrium, robot: Robot) -> Equilibrium:
    """An equilibrium as one of the robot that holds none: its inverse problem has no determinant."""
    record = equilibrium.record.copy()
    record[robot.state_size + SIGNS + INVERSE_SIGN] = 0.0
    return replace(equilibrium, robot=robot, record=record)


def _walk_of_base(walk: Walk, robot: Robot) -> Walk:
    """A walk as one of the robot that holds no motors."""
    events = tuple(
        replace(event, equilibrium=_of_base(event.equilibrium, robot)) for event in walk.events
    )
    violation = walk.violation
    return replace(
        walk,
        last=_of_base(walk.last, robot),
        events=events,
        stopped=None if walk.stopped is None else events[-1],
        violation=None if violation is None else (violation[0], _of_base(violation[1], robot)),
    )
