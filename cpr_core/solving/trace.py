# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A whole path of equilibria as arrays, with what happened on it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.bending_strain import bending_strains
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..validation import ReadOnlyArrays, cached_array, checked_count
from .continuation import Walk, follow
from .deadline import Deadline
from .events import PathEvent
from .geometrico_statics import checked_start
from .objectives import objective_of
from .redundant_walk import walk_to
from .requests import target_of
from .targets import PoseTarget, pose_between

__all__ = ["Trace", "trace"]

Floats = NDArray[np.float64]


#: Equilibria kept of a path at most.
_MOST_POINTS = 1_000_000


@dataclass(frozen=True, eq=False, repr=False)
class Trace(ReadOnlyArrays):
    """Equilibria along a path.

    Attributes:
        robot: The robot.
        fractions: Fractions of the way, (P,); not monotonic where folds were passed.
        equilibria: The equilibria there.
        events: What happened, in order; those located between the points as well.
        stopped: The event that ended the path short of its target, if one did.
    """

    robot: Robot
    fractions: Floats
    equilibria: Sequence[Equilibrium]
    events: tuple[PathEvent, ...]
    stopped: PathEvent | None

    def __repr__(self) -> str:
        end = "reached" if self.stopped is None else f"stopped, {self.stopped.message}"
        return (
            f"<Trace of {self.robot.description.name}: {len(self.equilibria)} equilibria, "
            f"{len(self.events)} events, {end}>"
        )

    @property
    def reached(self) -> bool:
        """Whether the target was reached."""
        return self.stopped is None

    @property
    def last(self) -> Equilibrium:
        """The last equilibrium; that of the event that stopped the path."""
        return self.stopped.equilibrium if self.stopped is not None else self.equilibria[-1]

    @cached_array
    def motors(self) -> Floats:
        """Motor positions, (P, n) [rad or m]."""
        return self._rows(
            [equilibrium.motors for equilibrium in self.equilibria], self.robot.motor_count
        )

    @cached_array
    def efforts(self) -> Floats:
        """Motor efforts, (P, n) [N m or N]."""
        return self._rows(
            [equilibrium.efforts for equilibrium in self.equilibria], self.robot.motor_count
        )

    @cached_array
    def platform_positions(self) -> Floats:
        """Platform positions, (P, 3) [m]."""
        return self._rows([equilibrium.platform_position for equilibrium in self.equilibria], 3)

    @cached_array
    def platform_quaternions(self) -> Floats:
        """Platform orientations w x y z, (P, 4), without jumps of sign."""
        found = self._rows([equilibrium.platform_quaternion for equilibrium in self.equilibria], 4)
        turns = np.sign(np.sum(found[1:] * found[:-1], axis=1))
        found[1:] *= np.cumprod(np.where(turns == 0.0, 1.0, turns))[:, None]
        return found

    @cached_array
    def energies(self) -> Floats:
        """Potential energies, (P,) [J]."""
        return np.array([equilibrium.energy for equilibrium in self.equilibria])

    @cached_array
    def eigenvalues_locked(self) -> Floats:
        """Up to six smallest eigenvalues of H_r with the motors held, ascending, (P, k) [J]."""
        found = [equilibrium.spectrum_locked.eigenvalues[:6] for equilibrium in self.equilibria]
        return self._rows(found, len(found[0]) if found else 0)

    @cached_array
    def indices_locked(self) -> NDArray[np.int64]:
        """Stability indices with the motors held, (P,)."""
        return np.array([equilibrium.index_locked for equilibrium in self.equilibria])

    @cached_array
    def indices_free(self) -> NDArray[np.int64]:
        """Stability indices with the motors at constant effort, (P,)."""
        return np.array([equilibrium.index_free for equilibrium in self.equilibria])

    @cached_array
    def bending_strains(self) -> Floats:
        """Largest bending strain of every rod, (P, R), see `bending_strains`."""
        return self._rows(
            [bending_strains(equilibrium) for equilibrium in self.equilibria],
            len(self.robot.description.rods),
        )

    def _rows(self, found: list[Floats], width: int) -> Floats:
        """What every equilibrium has, (P, width), also where none was reached."""
        return np.array(found, np.float64).reshape(len(found), width)


def trace(
    robot: Robot,
    *,
    motors: ArrayLike | None = None,
    pose: ArrayLike | None = None,
    efforts: ArrayLike | None = None,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    points: int = 51,
    stable_only: bool = False,
    past_folds: bool = False,
    singularities: bool = True,
    time_limit: float | None = None,
    progress: Callable[[float], None] | None = None,
    objective: str | None = None,
) -> Trace:
    """Follow the branch of an equilibrium along a straight path, and keep what is on the way.

    Exactly one of ``motors``, ``pose`` and ``efforts`` says where to; with none of them the motors stay
    and the loads change. All parameters but the robot are independent options, given by name.

    Args:
        robot: The robot.
        motors: Motor positions at the end, (n,) [rad or m].
        pose: Controlled platform coordinates at the end, as in ``solve_inverse``.
        efforts: Motor efforts at the end, (n,) [N m or N].
        start: Equilibrium to start from; default the robot's home.
        loads: Loads at the end; default those of the start. They change along the way.
        points: Number of equilibria kept, equally spaced, both ends included.
        stable_only: Stop where stability is lost.
        past_folds: Follow the branch around folds (pseudo-arclength), until it leaves the way at one of
            its ends; then the points are those of the steps.
        singularities: Locate inverse singularities on the way of motors or efforts too.
        time_limit: Stop after this time [s].
        progress: Called with the fraction reached.
        objective: For redundant robots and poses, as in ``solve_inverse``: what the freedom is used for,
            from one of the equilibria kept to the next.

    Returns:
        The path up to its end, or up to the event that stopped it. Nothing is raised for that.

    Raises:
        InvalidRequest: Not one target, a target of the wrong length, fewer than two points or more
            than a million, or a way past folds of a redundant robot.
        NonFiniteInput: A NaN or an infinity.
    """
    # Long, for more than half of it is what the parameters mean.
    start = checked_start(robot, start)
    choices = (("motors", motors), ("pose", pose), ("efforts", efforts))
    given = [(name, value) for name, value in choices if value is not None]
    if len(given) > 1 or (not given and loads is None):
        named = " and ".join(name for name, _ in given) or "none"
        raise InvalidRequest(
            "target", f"expected one of motors, pose and efforts, or loads, got {named}"
        )
    points = checked_count("points", points, 2, _MOST_POINTS)
    problem, values = given[0] if given else ("motors", start.motors)
    fractions, target = np.linspace(0.0, 1.0, points), target_of(start, problem, values)
    loads = start.loads if loads is None else loads
    aim = objective_of(start, problem, objective)
    if isinstance(target, PoseTarget) and aim is not None:
        if past_folds:
            raise InvalidRequest(
                "past_folds",
                "expected none: equilibria of a redundant robot at a pose are more than a curve",
            )
        deadline = Deadline(time_limit)

        def walk_on(last: Equilibrium, fraction: float) -> Walk:
            return walk_to(
                last,
                pose_between(start, target, fraction),
                loads if fraction == 1.0 else start.loads.toward(loads, fraction),
                objective=objective_of(last, "pose", objective),
                stable_only=stable_only,
                time_limit=deadline.left,
            )

        return _trace_of_walks(start, fractions, walk_on, progress)
    walk = follow(
        start,
        target,
        loads,
        stable_only=stable_only,
        past_folds=past_folds,
        singularities=singularities,
        keep=tuple(fractions.tolist()),
        time_limit=time_limit,
        progress=progress,
    )
    return _trace_of(robot, walk)


def _trace_of_walks(
    start: Equilibrium,
    fractions: Floats,
    walk_on: Callable[[Equilibrium, float], Walk],
    progress: Callable[[float], None] | None,
) -> Trace:
    """Walks from one equilibrium kept to the next: ``walk_on`` goes from the last to a fraction."""
    found, events = [start], list[PathEvent]()
    stopped = None
    for before, fraction in itertools.pairwise(fractions.tolist()):
        walk = walk_on(found[-1], fraction)
        way = fraction - before
        events += [replace(event, fraction=before + way * event.fraction) for event in walk.events]
        if walk.stopped is not None:
            stopped = events[-1]
            break
        found.append(walk.last)
        if progress is not None:
            progress(fraction)
    kept = fractions[: len(found)]
    return Trace(start.robot, kept, tuple(found), tuple(events), stopped)


def _trace_of(robot: Robot, walk: Walk) -> Trace:
    return Trace(
        robot=robot,
        fractions=np.array([point.fraction for point in walk.points]),
        equilibria=tuple(point.equilibrium for point in walk.points),
        events=walk.events,
        stopped=walk.stopped,
    )
