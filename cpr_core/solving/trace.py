# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A whole path of equilibria as arrays, with what happened on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.bending_strain import bending_strains
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..validation import checked_count
from .continuation import Walk, follow
from .events import PathEvent
from .geometrico_statics import checked_start
from .requests import target_of

__all__ = ["Trace", "trace"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Trace:
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

    @cached_property
    def motors(self) -> Floats:
        """Motor positions, (P, n) [rad or m]."""
        return np.array([equilibrium.motors for equilibrium in self.equilibria])

    @cached_property
    def efforts(self) -> Floats:
        """Motor efforts, (P, n) [N m or N]."""
        return np.array([equilibrium.efforts for equilibrium in self.equilibria])

    @cached_property
    def platform_positions(self) -> Floats:
        """Platform positions, (P, 3) [m]."""
        return np.array([equilibrium.platform_position for equilibrium in self.equilibria])

    @cached_property
    def platform_quaternions(self) -> Floats:
        """Platform orientations w x y z, (P, 4), without jumps of sign."""
        found = np.array([equilibrium.platform_quaternion for equilibrium in self.equilibria])
        turns = np.sign(np.sum(found[1:] * found[:-1], axis=1))
        found[1:] *= np.cumprod(np.where(turns == 0.0, 1.0, turns))[:, None]
        return found

    @cached_property
    def energies(self) -> Floats:
        """Potential energies, (P,) [J]."""
        return np.array([equilibrium.energy for equilibrium in self.equilibria])

    @cached_property
    def eigenvalues_locked(self) -> Floats:
        """Up to six smallest eigenvalues of H_r with the motors held, ascending, (P, k) [J]."""
        return np.array(
            [equilibrium.spectrum_locked.eigenvalues[:6] for equilibrium in self.equilibria]
        )

    @cached_property
    def indices_locked(self) -> NDArray[np.int64]:
        """Stability indices with the motors held, (P,)."""
        return np.array([equilibrium.index_locked for equilibrium in self.equilibria])

    @cached_property
    def indices_free(self) -> NDArray[np.int64]:
        """Stability indices with the motors at constant effort, (P,)."""
        return np.array([equilibrium.index_free for equilibrium in self.equilibria])

    @cached_property
    def bending_strains(self) -> Floats:
        """Largest bending strain of every rod, (P, R)."""
        return np.array([bending_strains(equilibrium) for equilibrium in self.equilibria])


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

    Returns:
        The path up to its end, or up to the event that stopped it. Nothing is raised for that.

    Raises:
        InvalidRequest: Not one target, a target of the wrong length, or fewer than two points.
        NonFiniteInput: A NaN or an infinity.
    """
    start = checked_start(robot, start)
    choices = (("motors", motors), ("pose", pose), ("efforts", efforts))
    given = [(name, value) for name, value in choices if value is not None]
    if len(given) > 1 or (not given and loads is None):
        named = " and ".join(name for name, _ in given) or "none"
        raise InvalidRequest(
            "target", f"expected one of motors, pose and efforts, or loads, got {named}"
        )
    points = checked_count("points", points, 2)
    problem, values = given[0] if given else ("motors", start.motors)
    walk = follow(
        start,
        target_of(start, problem, values),
        start.loads if loads is None else loads,
        stable_only=stable_only,
        past_folds=past_folds,
        singularities=singularities,
        keep=tuple(np.linspace(0.0, 1.0, points).tolist()),
        time_limit=time_limit,
        progress=progress,
    )
    return _trace_of(robot, walk)


def _trace_of(robot: Robot, walk: Walk) -> Trace:
    return Trace(
        robot=robot,
        fractions=np.array([point.fraction for point in walk.points]),
        equilibria=tuple(point.equilibrium for point in walk.points),
        events=walk.events,
        stopped=walk.stopped,
    )
