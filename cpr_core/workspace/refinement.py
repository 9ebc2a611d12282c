# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Borders between neighbouring cells, found by bisection."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor

import numpy as np
from numpy.typing import NDArray

from .batch_kernel import Arrivals, Cells
from .batches import Ways, go, guesses_of, in_pieces, joined
from .borders import Border, BorderKind
from .cell_problem import CellProblem
from .map_limits import limit_margins
from .segments import segments_of
from .way_kernel import ARRIVED
from .workspace_map import EdgeState, WorkspaceMap

__all__ = ["refined_borders"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Cancel = Callable[[], bool] | None

#: Crossings of one kind on the way between two neighbours at most.
_MOST_CROSSINGS = 4


def refined_borders(
    found: WorkspaceMap,
    problem: CellProblem,
    tolerance: float,
    executor: Executor | None,
    cancelled: Cancel = None,
) -> tuple[Border, ...]:
    """All borders of a map.

    Args:
        found: The map, complete.
        problem: What it was solved for.
        tolerance: Largest error of a point, in units of the axes.
        executor: Where batches run.
        cancelled: Whether to stop.

    Raises:
        Cancelled: It said so.
    """
    kinds: list[BorderKind] = ["stability", "stability_free"]
    if found.limit_names:
        kinds.append("limits")
    borders = [
        _by_bisection(found, problem, kind, tolerance, executor, cancelled) for kind in kinds
    ]
    return (*borders, _singular(found))


def _value(
    found: WorkspaceMap, kind: BorderKind, signs: Integers, state: Floats, efforts: Floats
) -> Integers:
    """What a border of some kind separates."""
    if kind == "limits":
        return np.sum(limit_margins(found.robot, state, efforts) < -1e-9, axis=1)
    return signs[:, 0 if kind == "stability" else 1]


def _by_bisection(
    found: WorkspaceMap,
    problem: CellProblem,
    kind: BorderKind,
    tolerance: float,
    executor: Executor | None,
    cancelled: Cancel,
) -> Border:
    """Points where a value changes along ways that were passed."""
    grid, cells = found.grid, found.cells
    values = _value(found, kind, cells.signs, cells.state, cells.efforts)
    cell, column = np.nonzero(cells.edges[:, 1::2] == EdgeState.PASSED)
    other = grid.neighbours[cell, 2 * column + 1]
    crossed = values[cell] != values[other]
    cell, other = cell[crossed], other[crossed]
    points: list[Floats] = []
    sides: list[Integers] = []
    before: list[Integers] = []
    after: list[Integers] = []
    first = values[cell]
    low = np.zeros(len(cell))  # fraction of the last point known on the near side
    near, far = _cells_of(found, cell), _cells_of(found, other)
    for _ in range(_MOST_CROSSINGS):
        if not len(cell):
            break
        length = np.linalg.norm(grid.places(other) - grid.places(cell), axis=1)
        high, beyond = np.ones(len(cell)), values[other].copy()
        while np.any((high - low) * length > tolerance):
            middle = 0.5 * (low + high)
            arrivals = _solved_at(
                found, problem, near, far, cell, other, middle, executor, cancelled
            )
            value = _value(found, kind, arrivals.signs, arrivals.state, arrivals.efforts)
            same = (arrivals.status == ARRIVED) & (value == first)
            solved = (arrivals.status == ARRIVED) & ~same
            coordinates = grid.kernel_coordinates(_between(found, cell, other, middle))
            there = Cells(
                coordinates, arrivals.state, arrivals.rotation, arrivals.position, arrivals.signs
            )
            near = _chosen(same, there, near)
            far = _chosen(solved, there, far)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
            beyond = np.where(solved, value, beyond)
        points.append(_between(found, cell, other, 0.5 * (low + high)))
        sides.append(np.stack([cell, other], axis=1))
        before.append(first)
        after.append(beyond)
        more = beyond != values[other]
        near = Cells(*(array[more] for array in far))
        first, low = beyond[more], high[more]
        cell, other = cell[more], other[more]
        far = _cells_of(found, other)
    size = len(grid.shape)
    found_points = np.concatenate(points) if points else np.empty((0, size))
    pairs = np.concatenate(sides) if sides else np.empty((0, 2), np.int64)
    return Border(
        kind=kind,
        points=found_points,
        cells=pairs,
        before=np.concatenate(before) if before else np.empty(0, np.int64),
        after=np.concatenate(after) if after else np.empty(0, np.int64),
        segments=segments_of(grid, found_points, pairs),
    )


def _cells_of(found: WorkspaceMap, cells: Integers) -> Cells:
    mine = found.cells
    return Cells(
        found.grid.kernel_coordinates(found.grid.places(cells)), mine.state[cells],
        mine.rotation[cells], mine.position[cells], mine.signs[cells],
    )  # fmt: skip


def _between(found: WorkspaceMap, cell: Integers, other: Integers, fraction: Floats) -> Floats:
    first, last = found.grid.places(cell), found.grid.places(other)
    return first + fraction[:, None] * (last - first)


def _chosen(which: NDArray[np.bool_], these: Cells, those: Cells) -> Cells:
    """Rows of one batch where it is chosen, of another elsewhere."""
    return Cells(
        *(
            np.where(which.reshape(-1, *[1] * (one.ndim - 1)), one, two)
            for one, two in zip(these, those, strict=True)
        )
    )


def _solved_at(
    found: WorkspaceMap,
    problem: CellProblem,
    near: Cells,
    far: Cells,
    cell: Integers,
    other: Integers,
    fraction: Floats,
    executor: Executor | None,
    cancelled: Cancel,
) -> Arrivals:
    """Equilibria at fractions of the ways, between points nearby."""
    count = len(cell)
    guesses = guesses_of(
        0.5 * (near.state + far.state), near.rotation, 0.5 * (near.position + far.position)
    )
    ways = Ways(
        np.arange(count), found.grid.kernel_coordinates(_between(found, cell, other, fraction)),
        np.full(count, 1.0), np.full(count, 1e-3), guesses,
    )  # fmt: skip
    pieces = list(in_pieces(executor, go, problem, near, ways, cancelled))
    return joined(pieces)


def _singular(found: WorkspaceMap) -> Border:
    """Where the branch ends on the way to a neighbour."""
    grid, cells = found.grid, found.cells
    stopped = (cells.edges == EdgeState.BLOCKED) | (cells.edges == EdgeState.FLIPPED)
    cell, column = np.nonzero(stopped)
    other = grid.neighbours[cell, column]
    open_ = cells.edges[other, column ^ 1] != EdgeState.PASSED  # no way leads there from behind
    cell, column, other = cell[open_], column[open_], other[open_]
    pairs = np.stack([cell, other], axis=1)
    points = _between(found, cell, other, cells.edge_fraction[cell, column])
    return Border(
        kind="singularity",
        points=points,
        cells=pairs,
        before=np.ones(len(cell), np.int64),
        after=np.full(len(cell), -1),
        segments=segments_of(grid, points, pairs),
    )
