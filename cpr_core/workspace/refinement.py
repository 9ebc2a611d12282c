# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Borders between neighbouring cells, found by bisection."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..kernels.limit_kernel import ROUNDING
from ..kernels.record_layout import INDEX_FREE, INDEX_LOCKED
from ..model.configurations import configuration_rows
from .batch_kernel import Arrivals, Cells, Ways
from .batches import Crew, Task, arrivals_of, cell_rows, cells_at, joined
from .borders import Border, BorderKind
from .cell_problem import CellProblem
from .grid import Grid
from .map_limits import limit_margins
from .segments import segments_of
from .way_kernel import ARRIVED
from .workspace_map import CellArrays, EdgeState, WorkspaceMap

__all__ = ["ends_of_branches", "refined_borders"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Crossings of one kind on the way between two neighbours at most.
_MOST_CROSSINGS = 4
#: Then the ends of a bisection are neighbouring numbers.
_MOST_BISECTIONS = 54


def refined_borders(
    found: WorkspaceMap,
    problem: CellProblem,
    tolerance: float,
    crew: Crew,
    arrive: Task[Arrivals] = arrivals_of,
) -> tuple[Border, ...]:
    """All borders of a map.

    Args:
        found: The map, complete.
        problem: What it was solved for.
        tolerance: Largest error of a point, in units of the axes.
        crew: Who goes there.
        arrive: How to go from cells to places between them.

    Raises:
        Cancelled: It was stopped.
    """
    kinds: list[BorderKind] = ["stability", "stability_free"]
    if found.limit_names:
        kinds.append("limits")
    solve = partial(_solved_at, problem, crew, arrive)
    borders = [_by_bisection(found, kind, tolerance, solve) for kind in kinds]
    return (*borders, _singular(found))


def _value(
    found: WorkspaceMap, kind: BorderKind, signs: Integers, state: Floats, efforts: Floats
) -> Integers:
    """What a border of some kind separates."""
    if kind == "limits":
        return np.sum(limit_margins(found.robot, state, efforts) < -ROUNDING, axis=1)
    return signs[:, INDEX_LOCKED if kind == "stability" else INDEX_FREE]


def _by_bisection(
    found: WorkspaceMap,
    kind: BorderKind,
    tolerance: float,
    solve: Callable[[Cells, Cells, Floats], Arrivals],
) -> Border:
    """Points where a value changes along ways that were passed.

    ``solve`` finds equilibria at coordinates between two points near by.
    """
    grid, cells = found.grid, found.cells
    values = _value(found, kind, cells.signs, cells.state, cells.efforts)
    cell, column = np.nonzero(cells.edges[:, 1::2] == EdgeState.PASSED)
    neighbour = grid.neighbours[cell, 2 * column + 1]
    crossed = values[cell] != values[neighbour]
    cell, neighbour = cell[crossed], neighbour[crossed]
    points: list[Floats] = []
    sides: list[Integers] = []
    before: list[Integers] = []
    after: list[Integers] = []
    first = values[cell]
    low = np.zeros(len(cell))  # fraction of the last point known on the near side
    near, far = cells_at(grid, cells, cell), cells_at(grid, cells, neighbour)
    for _ in range(_MOST_CROSSINGS):
        if not len(cell):
            break
        length = np.linalg.norm(grid.places(neighbour) - grid.places(cell), axis=1)
        high, beyond = np.ones(len(cell)), values[neighbour].copy()
        for _ in range(_MOST_BISECTIONS):
            if not np.any((high - low) * length > tolerance):
                break
            middle = 0.5 * (low + high)
            coordinates = grid.kernel_coordinates(_between(found, cell, neighbour, middle))
            arrivals = solve(near, far, coordinates)
            value = _value(found, kind, arrivals.signs, arrivals.state, arrivals.efforts)
            same = (arrivals.status == ARRIVED) & (value == first)
            solved = (arrivals.status == ARRIVED) & ~same
            between = Cells(
                coordinates, arrivals.state, arrivals.rotation, arrivals.position, arrivals.signs
            )
            near = _chosen(same, between, near)
            far = _chosen(solved, between, far)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
            beyond = np.where(solved, value, beyond)
        points.append(_between(found, cell, neighbour, 0.5 * (low + high)))
        sides.append(np.stack([cell, neighbour], axis=1))
        before.append(first)
        after.append(beyond)
        more = beyond != values[neighbour]
        near = cell_rows(far, more)
        first, low = beyond[more], high[more]
        cell, neighbour = cell[more], neighbour[more]
        far = cells_at(grid, cells, neighbour)
    return _border_of(grid, kind, points, sides, before, after)


def _border_of(
    grid: Grid,
    kind: BorderKind,
    points: list[Floats],
    sides: list[Integers],
    before: list[Integers],
    after: list[Integers],
) -> Border:
    """A border of points that were found in batches, of none too."""
    every_point = np.concatenate(points) if points else np.empty((0, len(grid.shape)))
    pairs = np.concatenate(sides) if sides else np.empty((0, 2), np.int64)
    return Border(
        kind=kind,
        points=every_point,
        cells=pairs,
        before=np.concatenate(before) if before else np.empty(0, np.int64),
        after=np.concatenate(after) if after else np.empty(0, np.int64),
        segments=segments_of(grid, every_point, pairs),
    )


def _between(found: WorkspaceMap, cell: Integers, neighbour: Integers, fraction: Floats) -> Floats:
    first, last = found.grid.places(cell), found.grid.places(neighbour)
    return first + fraction[:, None] * (last - first)


def _chosen(which: NDArray[np.bool_], batch: Cells, other_batch: Cells) -> Cells:
    """Rows of one batch where it is chosen, of another elsewhere."""
    return Cells(
        *(
            np.where(which.reshape(-1, *[1] * (chosen.ndim - 1)), chosen, otherwise)
            for chosen, otherwise in zip(batch, other_batch, strict=True)
        )
    )


def _solved_at(
    problem: CellProblem,
    crew: Crew,
    arrive: Task[Arrivals],
    near: Cells,
    far: Cells,
    coordinates: Floats,
) -> Arrivals:
    """Equilibria at coordinates between two points nearby: from the first, else from the second.

    Where the way between them leads over a place where branches cross, the sign of the problem stays
    only from the one that is on the same side of it.
    """

    def solved(start: Cells, other: Cells, coordinates: Floats) -> Arrivals:
        count = len(coordinates)
        guesses = configuration_rows(
            0.5 * (start.state + other.state),
            start.rotation,
            0.5 * (start.position + other.position),
        )
        ways = Ways(
            origin=np.arange(count),
            targets=coordinates,
            longest=np.full(count, 1.0),
            smallest=np.full(count, 1e-3),
            guesses=guesses,
        )
        return joined(list(crew.results(arrive, problem, start, ways)))

    found = solved(near, far, coordinates)
    left = np.flatnonzero(found.status != ARRIVED)
    if len(left):
        others = solved(cell_rows(far, left), cell_rows(near, left), coordinates[left])
        for values, instead in zip(found, others, strict=True):
            values[left] = instead
    return found


def ends_of_branches(grid: Grid, cells: CellArrays) -> tuple[Integers, Integers]:
    """Cells, and columns of their ways, on which the branch ends and to which no other way leads."""
    stopped = (cells.edges == EdgeState.BLOCKED) | (cells.edges == EdgeState.FLIPPED)
    cell, column = np.nonzero(stopped)
    neighbour = grid.neighbours[cell, column]
    open_ = cells.edges[neighbour, column ^ 1] != EdgeState.PASSED  # no way leads there from behind
    return cell[open_], column[open_]


def _singular(found: WorkspaceMap) -> Border:
    """Where the branch ends on the way to a neighbour."""
    grid, cells = found.grid, found.cells
    cell, column = ends_of_branches(grid, cells)
    neighbour = grid.neighbours[cell, column]
    pairs = np.stack([cell, neighbour], axis=1)
    points = _between(found, cell, neighbour, cells.edge_fraction[cell, column])
    return Border(
        kind="singularity",
        points=points,
        cells=pairs,
        before=np.ones(len(cell), np.int64),
        after=np.full(len(cell), -1),
        segments=segments_of(grid, points, pairs),
    )
