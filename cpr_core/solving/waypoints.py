# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria at many requests, one after the other, in compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.continuation_kernel import WATCHED
from ..kernels.kept_factors import kept_factors
from ..kernels.kernel_arrays import Lanes
from ..kernels.natural_units import LONGEST_STEP
from ..kernels.prepared_robot import continue_prepared
from ..kernels.problems import PROBLEMS, ProblemName
from ..kernels.record_layout import INVERSE_SIGN, SIGNS
from ..kernels.square_problem import Tolerances
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_records import new_record
from ..model.robot import Robot
from ..validation import checked_matrix
from .deadline import Deadline
from .events import PathEvent
from .geometrico_statics import checked_start
from .held_problem import held
from .limits import limits_along, may_be_kept_again, undisturbed
from .near_request import ALONE, signs_tell
from .objectives import objective_of
from .redundant_walk import walk_to
from .requests import pose_meaning, target_of
from .targets import apart, check_rod_lengths
from .trace import Trace

__all__ = ["trace_through"]

Floats = NDArray[np.float64]

#: Requests solved between two looks at the clock, where time is limited: some hundredths of a second.
_BETWEEN_LOOKS = 256
#: The same where it is not: compiled code hears no Ctrl-C.
_BETWEEN_SIGNALS = 2048

#: As `near_request.ALONE`, where stretches without stability must not be missed on the way of poses.
_STABLE_ALONE = 0.02

_PROBLEM: dict[str, ProblemName] = {"motors": "motors", "poses": "pose", "efforts": "efforts"}


def trace_through(
    robot: Robot,
    *,
    motors: ArrayLike | None = None,
    poses: ArrayLike | None = None,
    efforts: ArrayLike | None = None,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    stable_only: bool = False,
    singularities: bool = True,
    time_limit: float | None = None,
    objective: str | None = None,
) -> Trace:
    """Solve for one request after the other, each from the equilibrium before: a whole trajectory.

    The same as a loop of ``solve_forward``, ``solve_inverse`` or ``solve_forward_by_effort``, faster:
    as long as steps are short and nothing happens, no Python is run between them, and each prediction
    learns from the ones before. Exactly one of ``motors``, ``poses`` and ``efforts`` is given; all
    parameters but the robot are given by name.

    Args:
        robot: The robot.
        motors: Motor positions, one row a request, (P, n) [rad or m].
        poses: Controlled platform coordinates, one row a request, as in ``solve_inverse``.
        efforts: Motor efforts, one row a request, (P, n) [N m or N].
        start: Equilibrium to start from; default the robot's home.
        loads: Loads; default those of the start. They change on the way to the first request.
        stable_only: Stop where stability is lost.
        singularities: Locate inverse singularities on the way of motors or efforts too.
        time_limit: Stop after this time [s].
        objective: For redundant robots and poses, as in ``solve_inverse``.

    Returns:
        The equilibria at the requests, up to the event that stopped the way, if one did. Nothing is
        raised for that. Fractions, of events too, are numbers of requests over P: 1 is the last one.

    Raises:
        InvalidRequest: Not one kind of request, or rows of the wrong length.
        NonFiniteInput: A NaN or an infinity.
    """
    # Long, for half of it is what the parameters mean.
    start = checked_start(robot, start)
    choices = (("motors", motors), ("poses", poses), ("efforts", efforts))
    given = [(name, value) for name, value in choices if value is not None]
    if len(given) != 1:
        named = " and ".join(name for name, _ in given) or "none"
        raise InvalidRequest("requests", f"expected one of motors, poses and efforts, got {named}")
    problem, rows = _PROBLEM[given[0][0]], _checked_rows(robot, *given[0])
    deadline = Deadline(time_limit)
    objective_of(start, problem, objective)
    last, count = start, len(rows)
    found, events, stopped = _Records(start, loads, count), [], None
    told = signs_tell(robot, found.loads, problem, stable_only)
    imposed = _imposed(start, problem, rows)
    walked = _walked_to(start, problem, imposed, count, stable_only, singularities)
    while len(found) < count and stopped is None:
        done = len(found)
        until = walked[np.searchsorted(walked, done)]
        limited = not math.isinf(deadline.left)
        until = min(until, done + (_BETWEEN_LOOKS if limited else _BETWEEN_SIGNALS))
        unstable = last.index_free if problem == "efforts" else last.index_locked
        quiet = told and last.loads is found.loads and not (stable_only and unstable)
        if quiet and until > done and not deadline.over:
            last = _run(found, last, problem, imposed[done:until], singularities)
            if len(found) == until:
                continue
            done = len(found)
        walk = walk_to(
            last,
            target_of(last, problem, rows[done]),
            found.loads,
            objective=objective_of(last, problem, objective),
            stable_only=stable_only,
            singularities=singularities,
            time_limit=deadline.left,
        )
        happened = [_numbered(event, done, count) for event in walk.events]
        events += happened
        if walk.stopped is not None:
            stopped = happened[-1]
        else:
            last = walk.last
            found.add(last)
    return Trace(
        robot=robot,
        fractions=np.arange(1.0, len(found) + 1.0) / count,
        equilibria=found,
        events=tuple(events),
        stopped=stopped,
    )


class _Records(Sequence[Equilibrium]):
    """Equilibria as rows of one array, made values when they are asked for."""

    def __init__(self, start: Equilibrium, loads: Loads | None, count: int) -> None:
        same = loads is None or loads is start.loads
        self.robot, self.loads = start.robot, start.loads if loads is None else loads
        self.load_arrays = start.load_arrays if same else start.robot.load_arrays(self.loads)
        self.rows, self.known = new_record(start.robot, count), 0

    def __len__(self) -> int:
        return self.known

    @overload
    def __getitem__(self, number: int) -> Equilibrium: ...

    @overload
    def __getitem__(self, number: slice) -> tuple[Equilibrium, ...]: ...

    def __getitem__(self, number: int | slice) -> Equilibrium | tuple[Equilibrium, ...]:
        if isinstance(number, slice):
            return tuple(self.value(row) for row in range(*number.indices(self.known)))
        if not -self.known <= number < self.known:
            raise IndexError(number)
        return self.value(number % self.known)

    def value(self, row: int, factors: Lanes | None = None) -> Equilibrium:
        """An equilibrium."""
        return Equilibrium(self.robot, self.loads, self.load_arrays, self.rows[row], factors)

    def add(self, equilibrium: Equilibrium) -> None:
        """One more."""
        self.rows[self.known] = equilibrium.record
        self.known += 1


def _imposed(start: Equilibrium, problem: ProblemName, rows: Floats) -> Floats:
    """Requests as the kernels take them, one row each: see ``continue_equilibria``.

    Returns:
        None of them where poses leave something free: it is known after each step only what they impose.
    """
    if problem != "pose":
        return np.array(rows)
    robot = start.robot
    if robot.redundancy or not robot.platform_coordinates.poses_are_whole:
        return rows[:0]
    return np.concatenate([target_of(start, problem, row).given(start) for row in rows])


def _walked_to(
    start: Equilibrium,
    problem: ProblemName,
    imposed: Floats,
    count: int,
    stable_only: bool,
    singularities: bool,
) -> NDArray[np.int64]:
    """Requests that single steps do not lead to, and how many there are, ascending.

    All of which it is not known what they impose. Else those too far from the one before: something may
    happen on the way that does not show at its ends.
    """
    if not len(imposed):
        return np.arange(count + 1)
    if not (problem == "pose" or singularities or may_be_kept_again(start.robot, problem)):
        return np.array([count])
    places = np.concatenate([held(start, problem).given(start), imposed])
    ways = apart(start.robot, problem, places[:-1], places[1:])
    alone = _STABLE_ALONE if problem == "pose" and stable_only else ALONE
    return np.append(np.flatnonzero(ways > alone * LONGEST_STEP), count)


def _run(
    found: _Records,
    start: Equilibrium,
    problem: ProblemName,
    imposed: Floats,
    singularities: bool,
) -> Equilibrium:
    """Go on in compiled code as far as nothing happens; the last equilibrium."""
    robot = found.robot
    factors, records = kept_factors(robot.kernel_arrays), found.rows[len(found) :]
    count = continue_prepared(
        robot.prepared,
        found.load_arrays,
        PROBLEMS[problem],
        imposed,
        WATCHED,
        *Tolerances(),
        start.record,
        start.factors,
        records,
        factors,
    )
    quiet = _quiet(found, start, records[:count], singularities and problem != "pose")
    found.known += quiet
    if quiet == 0:
        return start
    return found.value(len(found) - 1, factors if quiet == len(imposed) else None)


def _quiet(found: _Records, start: Equilibrium, records: Floats, singularities: bool) -> int:
    """How many steps pass no limit and, where they are watched, no inverse singularity."""
    robot, count = found.robot, len(records)
    if singularities:
        at = robot.state_size + SIGNS + INVERSE_SIGN
        flipped = np.flatnonzero(records[:, at] != start.record[at])
        count = int(flipped[0]) if flipped.size else count
    if robot.limited:
        along = np.concatenate([start.record[None], records[:count]])
        count = undisturbed(limits_along(robot, along))
    return count


def _checked_rows(robot: Robot, kind: str, values: ArrayLike) -> Floats:
    """Requests as an array.

    Raises:
        InvalidRequest: No rows, or rows of the wrong length.
        NonFiniteInput: A NaN or an infinity.
    """
    names = pose_meaning(robot) if kind == "poses" else robot.motor_names
    rows = checked_matrix(kind, values, None, len(names), " ".join(names))
    if not len(rows):
        raise InvalidRequest(kind, "expected a row or more, got none")
    if kind == "motors":
        check_rod_lengths(robot, rows)
    return rows


def _numbered(event: PathEvent, row: int, count: int) -> PathEvent:
    """An event on the way to a request, by its place on the whole way."""
    return replace(event, fraction=(row + event.fraction) / count)
