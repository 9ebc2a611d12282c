# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""All equilibria at given motor positions: how many there are, and which of them a robot may snap to."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..blas_threads import on_one_blas_thread
from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.closing_kernel import close_joints
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.square_problem import Configuration, Tolerances
from ..model.configurations import SAME_EQUILIBRIUM, leg_distance
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_records import record_of
from ..model.equilibrium_steps import corrected
from ..model.robot import Robot, checked_robot
from ..validation import checked_count, checked_vector
from .assembly import turned_over, with_best_multipliers
from .geometrico_statics import solve_forward
from .limits import beyond_limits
from .not_reached import NotReached
from .targets import check_rod_lengths

__all__ = ["FoundEquilibrium", "find_equilibria", "merged_equilibria"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: A million take an hour and more; all are numbered before the first one begins.
_MOST_STARTS = 1_000_000
#: Bending of random starts: smallest and largest standard deviation of the curvature times the length.
_BENDING = (0.3, 3.0)
#: Most Newton steps from one random start.
_STEPS = 60


@dataclass(frozen=True, eq=False)
class FoundEquilibrium:
    """One equilibrium out of many.

    Attributes:
        equilibrium: The equilibrium.
        from_home: Whether it is the one the branch of home leads to, straight in the motors.
        starts: How many of the random starts led to it.
    """

    equilibrium: Equilibrium
    from_home: bool
    starts: int

    @property
    def stable(self) -> bool:
        """Whether it is stable with the motors held, and energy decides that."""
        return self.equilibrium.stable

    @property
    def beyond(self) -> str:
        """Why the robot cannot be there, in words: a motor or a rod beyond a limit; empty: it can."""
        return str(beyond_limits(self.equilibrium) or "")


@on_one_blas_thread
def find_equilibria(
    robot: Robot,
    motors: ArrayLike,
    *,
    starts: int = 1000,
    seed: int = 0,
    loads: Loads | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[FoundEquilibrium, ...]:
    """Search equilibria at given motors by Newton's method from random shapes.

    Nothing guarantees that all are found: compare two seeds, and look at how often each was met.

    Args:
        robot: The robot.
        motors: Motor positions q_a, (n,) [rad or m].
        starts: Number of random starts.
        seed: Of the random numbers; the same seed finds the same equilibria in the same order.
        loads: Loads; default those of the description.
        executor: Where the starts run; default threads on all cores.
        progress: Called with the fraction of the starts that are done.

    Returns:
        The equilibria by energy, lowest first, each once. As ``Equilibrium.energy`` leaves out moments
        on the platform, the first of them need not be the lowest where one acts on a planar robot.

    Raises:
        InvalidRequest: Wrong number of motors, a rod length of zero or less, no start, or more than a
            million.
        NonFiniteInput: A NaN or an infinity.
    """
    checked_robot(robot)
    values = checked_vector("motors", motors, robot.motor_count, " ".join(robot.motor_names))
    check_rod_lengths(robot, values)
    if executor is not None and not isinstance(executor, Executor):
        raise InvalidRequest("executor", f"expected an Executor, got {executor!r:.200}")
    starts = checked_count("starts", starts, 1, _MOST_STARTS)
    seed = checked_count("seed", seed, 0)
    loads = robot.default_loads if loads is None else loads
    seeds = np.random.SeedSequence(seed).spawn(starts)
    home = _from_home(robot, values, loads)
    search = partial(_searched, robot, values, loads, robot.load_arrays(loads), _spread(robot))
    if executor is not None:
        candidates = _counted(robot, executor.map(search, seeds), starts, progress)
    else:
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            candidates = _counted(robot, threads.map(search, seeds), starts, progress)
    return _distinct(robot, candidates, home)


def merged_equilibria(
    first: Sequence[FoundEquilibrium], second: Sequence[FoundEquilibrium]
) -> tuple[FoundEquilibrium, ...]:
    """What searches at the same motors and loads, but with other seeds, found: each once, by energy."""
    everything = [*first, *second]
    if not everything:
        return ()
    robot = everything[0].equilibrium.robot
    equilibria = [found.equilibrium for found in everything]
    merged = []
    for group in _groups(robot, equilibria):
        members = [everything[number] for number in group]
        merged.append(
            FoundEquilibrium(
                equilibrium=equilibria[min(group)],
                from_home=any(found.from_home for found in members),
                starts=sum(found.starts for found in members),
            )
        )
    return tuple(merged)


def _from_home(robot: Robot, motors: Floats, loads: Loads) -> Equilibrium | None:
    try:
        return solve_forward(robot, motors, loads=loads)
    except NotReached:
        return None


def _counted(
    robot: Robot,
    found: Iterable[Equilibrium | None],
    starts: int,
    progress: Callable[[float], None] | None,
) -> list[Equilibrium]:
    kept = []
    for number, candidate in enumerate(found):
        if candidate is not None:
            # Another process answers with a copy of the robot.
            kept.append(candidate if candidate.robot is robot else replace(candidate, robot=robot))
        if progress is not None:
            progress((number + 1) / starts)
    return kept


class _Spread(NamedTuple):
    """What of a robot is random at a start.

    Attributes:
        passive: State indices of its passive joints.
        strain: State indices of the strain coordinates of its rods, (m,).
        lengths: Length of the rod of each, (m,) [m].
        orders: Order of the shape function of each, (m,).
        forces: State indices of the multipliers that hold the tips' positions, (L, 2) or (L, 3).
    """

    passive: Integers
    strain: Integers
    lengths: Floats
    orders: Integers
    forces: Integers


def _spread(robot: Robot) -> _Spread:
    """That of a robot."""
    moved = [index for leg in robot.numbers.legs for index in leg.coordinates]
    rods, states = list(robot.numbers.rods), np.arange(robot.state_size)
    return _Spread(
        np.array(
            [i for i in moved if i is not None and i < robot.kernel_arrays.platform_index], int
        ),
        np.concatenate([states[rod.strain] for rod in rods]),
        np.concatenate([[rod.element.rod.length] * rod.element.modes.total for rod in rods]),
        np.concatenate([np.arange(n) for rod in rods for n in rod.element.modes.counts]),
        np.array([states[leg.forces] for leg in robot.numbers.legs]),
    )


def _searched(
    robot: Robot,
    motors: Floats,
    loads: Loads,
    load_arrays: LoadArrays,
    spread: _Spread,
    seed: np.random.SeedSequence,
) -> Equilibrium | None:
    """The equilibrium Newton's method finds from one random shape, if any."""
    random, passive = np.random.default_rng(seed), spread.passive
    state = np.zeros(robot.state_size)
    state[robot.motor_indices] = motors
    bending = np.exp(random.uniform(*np.log(_BENDING)))
    state[passive] = robot.kernel_arrays.unit[passive] * random.normal(size=len(passive))
    deviations = bending / spread.lengths / (1.0 + spread.orders)
    state[spread.strain] = random.normal(size=len(deviations)) * deviations
    rotation = np.eye(3)
    if robot.planar and not robot.description.point_platform:
        angle = random.uniform(-np.pi, np.pi)
        rotation[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    elif not robot.planar:
        rotation = np.linalg.qr(random.normal(size=(3, 3)))[0].copy()  # numpy's is ready sooner
        rotation *= np.sign(np.linalg.det(rotation))
    position, held = np.empty(3), robot.multiplier_indices.copy()  # read-only is another type
    if not close_joints(
        robot.prepared, load_arrays, spread.forces, held, state, rotation, position
    ):
        return None
    shape = Configuration(state, rotation, position)
    state = with_best_multipliers(robot, load_arrays, shape)
    tolerances = Tolerances(iterations=_STEPS, contraction=1.0)
    rough = record_of(robot, shape._replace(state=state))
    found = corrected(robot, loads, load_arrays, rough, tolerances)
    return found if found.converged and robot.rods_exist(found.state) else None


def _distinct(
    robot: Robot, candidates: list[Equilibrium], home: Equilibrium | None
) -> tuple[FoundEquilibrium, ...]:
    """Every equilibrium once, by energy; but for home, none with a leg that is turned over."""
    known = ([home] if home is not None else []) + candidates
    shift = 0 if home is None else 1
    return tuple(
        FoundEquilibrium(
            equilibrium=known[min(group)],
            from_home=home is not None and 0 in group,
            starts=sum(number >= shift for number in group),
        )
        for group in _groups(robot, known)
        if min(group) < shift or turned_over(known[min(group)]) is None
    )


def _groups(robot: Robot, known: Sequence[Equilibrium]) -> list[list[int]]:
    """Numbers of those that are the same equilibrium, by energy; of equal ones the first known first.

    Rounding tells the energies of mirrored equilibria apart, on every computer in another way.
    """
    places = np.array([found.configuration for found in known])
    energies = np.array([found.energy for found in known])
    near = SAME_EQUILIBRIUM * robot.kernel_arrays.energy_unit
    groups: list[list[int]] = []
    for number in np.argsort(energies, kind="stable").tolist():
        for group in reversed(groups):
            if energies[number] - energies[group[0]] > near:
                groups.append([number])
                break
            if leg_distance(robot, places[number], places[group[0]]) < SAME_EQUILIBRIUM:
                group.append(number)
                break
        else:
            groups.append([number])
    lowest = [energies[group[0]] for group in groups]
    levels = np.cumsum(np.diff(lowest, prepend=lowest[:1]) > near).tolist()
    order = sorted(range(len(groups)), key=lambda index: (levels[index], min(groups[index])))
    return [groups[index] for index in order]
