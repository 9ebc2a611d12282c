# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ten thousand solves in compiled code, on one core and on two.

`solve_batch` is the one place that knows how a batch is solved: as the ways between the cells of a map.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial

import numpy as np

from cpr_core.workspace import motor_grid
from cpr_core.workspace.batch_kernel import Arrivals, Cells, Ways
from cpr_core.workspace.batches import Crew, arrivals_of, joined, no_guesses
from cpr_core.workspace.cell_problem import CellProblem, cell_problem
from cpr_core.workspace.first_cell import signs_row
from cpr_core.workspace.way_kernel import ARRIVED

from .measure import Case
from .walks import walk_of

__all__ = ["batch_cases"]


def batch_cases(count: int, modes: int = 5) -> Iterator[Case]:
    """Path steps of the 6-RFS robot, from every point of its path to the next."""
    problem, cells, ways = _batch(count, modes)
    _check(solve_batch(problem, cells, ways, None))
    for cores, executor in (("1 core", None), ("2 cores", ThreadPoolExecutor(2))):
        run = partial(solve_batch, problem, cells, ways, executor)
        yield Case(f"batch of {count}, {cores}/six_rfs/{modes}", run, count, "wall", slow=True)


def solve_batch(
    problem: CellProblem, cells: Cells, ways: Ways, executor: Executor | None
) -> Arrivals:
    """All ways, in pieces where there is an executor."""
    return joined(list(Crew(executor).results(arrivals_of, problem, cells, ways)))


def _batch(count: int, modes: int) -> tuple[CellProblem, Cells, Ways]:
    walk = walk_of("six_rfs", modes, "forward")
    robot, loads = walk.start.robot, walk.start.loads
    points = (walk.start, *walk.equilibria())[: len(walk.requests)]
    chosen = np.arange(count) % len(points)
    # Cells of a grid in the motors; where they lie in it does not matter to the ways between them.
    axes = zip(robot.motor_names[:2], walk.start.motors.tolist(), strict=False)
    grid = motor_grid(robot, {name: [at, at + 1.0] for name, at in axes}, resolution=1.0)
    problem = cell_problem(robot, loads, grid)
    cells = Cells(
        coordinates=np.array([point.motors for point in points])[chosen],
        state=np.array([point.state for point in points])[chosen],
        rotation=np.array([point.platform_rotation for point in points])[chosen],
        position=np.array([point.platform_position for point in points])[chosen],
        # The branch of a forward problem is told by the index with motors held.
        signs=np.array([signs_row(point, point.signs.index_locked) for point in points])[chosen],
    )
    ways = Ways(
        origin=np.arange(count),
        targets=np.array(walk.requests)[chosen],
        longest=np.ones(count),
        smallest=np.full(count, 1.0 / 64.0),
        guesses=no_guesses(count, robot.state_size),
    )
    return problem, cells, ways


def _check(arrivals: Arrivals) -> None:
    missed = int(np.sum(arrivals.status != ARRIVED))
    if missed:
        raise RuntimeError(f"{missed} solves of the batch did not arrive")
