# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where to measure, so that parameters become as exact as so many measurements can make them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..blas_threads import on_one_blas_thread
from ..description.loads import Loads
from ..description.parameters import checked_paths
from ..errors import InvalidRequest
from ..lie import quaternion_from_rotation
from ..model.configurations import SAME_EQUILIBRIUM, configuration_distance
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from ..solving.geometrico_statics import solve_forward
from ..solving.home import solve_home
from ..solving.not_reached import NotReached
from ..solving.targets import apart
from ..validation import ReadOnlyArrays, checked_count, checked_number
from .compared import compared_row
from .measurement_doubts import deviation_doubts
from .measurements import Frame, Measurement, StandardDeviations, checked_deviations
from .number_doubts import hardly_told
from .parameter_problem import natural_changes
from .undetermined import Knowledge, knowledge, parameter_sizes, unseen_in_words

__all__ = ["ProposedPoses", "propose_poses"]

Floats = NDArray[np.float64]

#: More than anybody measures; how long the choice takes grows with the square of them.
_MOST_POSES = 1000
#: Candidates for every pose that is asked for.
_CANDIDATES = 20
#: Motors are tried this far from home, in radians and rod lengths, within their limits.
_REACH = 0.5
#: Smallest margin of stability of a pose.
_MARGIN = 0.2
#: Information that is there before any measurement, over that of all candidates.
_BEFORE = 1e-9
#: Random choices that proposed poses are compared with.
_CHOICES = 100
#: Times that all poses are looked at again for better ones.
_ROUNDS = 10
#: Of the nearest poses that are left so many are tried to go to straight, before the way goes by home.
_TRIED = 5


@dataclass(frozen=True, eq=False)
class ProposedPoses(ReadOnlyArrays):
    """Poses to measure.

    Attributes:
        equilibria: Where to go, in an order in which motors move little.
        home_first: For each whether the robot has to go back home before it: straight from the one
            before it would be stopped on the way, lose stability, or come to another equilibrium. Where
            loads differ they may be changed before the motors move, or afterwards.
        parameters: Paths of the parameters to be found, P.
        standard_deviations: Of the parameters after these measurements, (P,), in SI units; infinite
            where they do not tell.
        random: The same after as many random candidates, the median of many choices, (P,).
        undetermined: What these measurements would not tell, one line each.
        doubts: Numbers that they would hardly tell, and deviations in other units, one line each.
    """

    equilibria: tuple[Equilibrium, ...]
    home_first: tuple[bool, ...]
    parameters: tuple[str, ...]
    standard_deviations: Floats
    random: Floats
    undetermined: tuple[str, ...]
    doubts: tuple[str, ...]


@on_one_blas_thread
def propose_poses(
    robot: Robot,
    parameters: str | Sequence[str],
    deviations: StandardDeviations,
    count: int = 20,
    *,
    loads: Sequence[Loads] = (),
    reach: float = _REACH,
    margin: float = _MARGIN,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> ProposedPoses:
    """Poses that tell most about parameters: with the least volume of what is left in doubt.

    Among random motor positions that the robot reaches from home, stably and within its limits, those
    are chosen whose information matrix has the largest determinant (D-optimal), by exchange. The
    parameters after the count are independent options, given by name.

    Args:
        robot: The robot.
        parameters: Paths of the numbers that are to be found.
        deviations: Standard deviations of what will be measured; None is not measured. Motors drive;
            poses are those that the tracker tells where the description has one.
        count: Number of poses.
        loads: Loads that can be put on, one of which acts on every pose; default the description's.
        reach: Farthest that motors move from home, in radians and rod lengths.
        margin: Smallest margin of stability.
        seed: Of the random candidates.
        progress: Called with the fraction of candidates that are done.

    Raises:
        InvalidRequest: No parameters, nothing to be measured, no candidates, or more than a
            thousand poses.
        UnknownParameter: There is no such number.
    """
    # Long, for half of it is what the parameters mean.
    checked_robot(robot)
    paths = checked_paths(parameters)
    values = robot.parameter_values(paths)
    count = checked_count("count", count, 1, _MOST_POSES)
    checked_number("margin", margin)
    if not checked_number("reach", reach) > 0.0:
        raise InvalidRequest("reach", f"expected a positive distance, got {reach:g}")
    seed = checked_count("seed", seed, 0)
    if not isinstance(loads, Sequence):
        given = "one: put it in brackets" if isinstance(loads, Loads) else f"{loads!r:.80}"
        raise InvalidRequest("loads", f"expected a list of Loads, got {given}")
    checked_deviations(deviations)
    measured = [deviations.position, deviations.rotation, deviations.efforts]
    if all(deviation is None for deviation in measured):
        raise InvalidRequest("deviations", "expected one of position, rotation or efforts")
    candidates = _candidates(
        robot, count, tuple(loads), reach=reach, margin=margin, seed=seed, progress=progress
    )
    scales = natural_changes(candidates[0], paths)
    rates = np.array([_rates(each, deviations, paths) for each in candidates]) * scales
    information = np.einsum("ckp,ckq->cpq", rates, rates)
    chosen = _chosen(information, count)
    generator = np.random.default_rng(seed)
    sizes = parameter_sizes(values, scales)
    several = [
        _deviations(_known(rates[generator.choice(len(candidates), count, replace=False)], sizes))
        for _ in range(_CHOICES)
    ]
    known = _known(rates[chosen], sizes)
    after = _deviations(known) * scales
    order, home_first = _short_way([candidates[number] for number in chosen])
    return ProposedPoses(
        equilibria=order,
        home_first=home_first,
        parameters=paths,
        standard_deviations=after,
        random=np.median(several, axis=0) * scales,
        undetermined=unseen_in_words(known.unseen, np.isinf(after), scales, paths, values),
        doubts=(
            *deviation_doubts(robot, deviations),
            *hardly_told(robot, paths, values, after, scales, np.where(values == 0.0, scales, 0.0)),
        ),
    )


def _candidates(
    robot: Robot,
    count: int,
    loads: tuple[Loads, ...],
    *,
    reach: float,
    margin: float,
    seed: int,
    progress: Callable[[float], None] | None,
) -> list[Equilibrium]:
    """Equilibria that can be gone to.

    Raises:
        InvalidRequest: There are fewer than poses asked for.
    """
    for possible in loads or (robot.default_loads,):
        robot.load_arrays(possible)  # whether they are any
        if not robot.has_potential(possible):
            raise InvalidRequest(
                "loads",
                "expected loads with a potential, as poses have to be stable: moments in space and "
                "wrenches that turn with the platform have none",
            )
    home, generator = solve_home(robot), np.random.default_rng(seed)
    units = robot.motor_units
    limits = [motor.limits for motor in robot.description.motors]
    low = np.maximum(home.motors - reach * units, [limit.lower for limit in limits])
    high = np.minimum(home.motors + reach * units, [limit.upper for limit in limits])
    wanted, found = _CANDIDATES * count, []
    for number in range(wanted):
        acting = loads[number % len(loads)] if loads else None
        motors = generator.uniform(low, high)
        try:
            reached = solve_forward(robot, motors, start=home, loads=acting, stable_only=True)
        except NotReached:
            reached = None
        free = reached is not None and (acting is None or _leads(home, reached))
        if reached is not None and free and reached.margin >= margin:
            found.append(reached)
        if progress is not None:
            progress((number + 1) / wanted)
    if len(found) < count:
        raise InvalidRequest(
            "reach",
            f"only {len(found)} of {wanted} random motor positions up to {reach:g} rad or rod lengths "
            f"from home are reached stably with a margin of {margin:g}: expected at least {count}; "
            "a smaller reach or margin may leave more",
        )
    return found


def _rates(
    equilibrium: Equilibrium, deviations: StandardDeviations, paths: Sequence[str]
) -> Floats:
    """Derivatives by parameters of what would be measured, in standard deviations, (K, P)."""
    frame: Frame = "world" if equilibrium.robot.description.tracker is None else "tracker"
    position, rotation = Measurement(frame=frame).predicted_pose(equilibrium)
    turned = quaternion_from_rotation(rotation)
    row = Measurement(
        motors=equilibrium.motors,
        position=None if deviations.position is None else position,
        quaternion_wxyz=None if deviations.rotation is None else turned,
        efforts=None if deviations.efforts is None else equilibrium.efforts,
        loads=equilibrium.loads,
        frame=frame,
    )
    return compared_row(row, equilibrium, deviations).rates(equilibrium, paths)


def _chosen(information: Floats, count: int) -> list[int]:
    """Numbers of candidates whose information together has a large determinant.

    One after the other the best, then exchanged one by one while that helps.
    """
    total = information.sum(axis=0)
    before = _BEFORE * np.trace(total) / len(total) * np.eye(len(total))
    chosen: list[int] = []
    known = before.copy()
    for _ in range(count):
        best = _best(information, known, chosen)
        chosen.append(best)
        known = known + information[best]
    for _ in range(_ROUNDS):
        exchanged = False
        for place, old in enumerate(chosen):
            others = [number for number in chosen if number != old]
            without = before + information[others].sum(axis=0)
            best = _best(information, without, others)
            if _size(without + information[best]) > _size(without + information[old]) + 1e-9:
                chosen[place], exchanged = best, True
        if not exchanged:
            break
    return chosen


def _best(information: Floats, known: Floats, taken: Sequence[int]) -> int:
    """The candidate that adds most."""
    sizes = np.linalg.slogdet(known + information)[1]
    sizes[list(taken)] = -math.inf
    return int(np.argmax(sizes))


def _size(information: Floats) -> float:
    """Logarithm of the determinant."""
    return float(np.linalg.slogdet(information)[1])


def _known(rates: Floats, sizes: Floats) -> Knowledge:
    """What measurements with these rates, (C, K, P), tell; sizes as in ``unseen_directions``."""
    return knowledge(np.vstack(list(rates)), sizes)


def _deviations(known: Knowledge) -> Floats:
    """Standard deviations in natural units, (P,); infinite of parameters that are not determined."""
    return np.asarray(np.sqrt(np.diag(known.covariance())))


def _short_way(
    equilibria: Sequence[Equilibrium],
) -> tuple[tuple[Equilibrium, ...], tuple[bool, ...]]:
    """The same from home on, each time to a near one that is left, and which of them by way of home."""
    home = solve_home(equilibria[0].robot)
    left, found, home_first, at = list(equilibria), [], [], home
    while left:
        left.sort(key=lambda other: _way(at, other))
        ahead = left[0] if at is home else next(filter(partial(_leads, at), left[:_TRIED]), None)
        home_first.append(ahead is None)
        if ahead is None:
            ahead = min(left, key=lambda other: _way(home, other))
        left.remove(ahead)
        found.append(ahead)
        at = ahead
    return tuple(found), tuple(home_first)


def _way(first: Equilibrium, last: Equilibrium) -> float:
    """How far motors move, in their units."""
    return float(apart(first.robot, "motors", first.motors, last.motors))


def _leads(first: Equilibrium, last: Equilibrium) -> bool:
    """Whether the straight way from one to the other is stable and ends there.

    Where loads are others they may be changed before the motors move, or afterwards.
    """
    if not first.loads.differences(last.loads):
        return _reaches(first, last)
    corners = (first.motors, last.loads), (last.motors, first.loads)
    return all(_reaches(first, last, corner) for corner in corners)


def _reaches(first: Equilibrium, last: Equilibrium, *between: tuple[Floats, Loads]) -> bool:
    """Whether straight ways by motors and loads between lead from one to the other, all stable."""
    at = first
    try:
        for motors, loads in (*between, (last.motors, last.loads)):
            at = solve_forward(first.robot, motors, start=at, loads=loads, stable_only=True)
    except NotReached:
        return False
    missed = configuration_distance(first.robot, at.configuration, last.configuration)
    return bool(missed < SAME_EQUILIBRIUM)
