# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Lines of a border through the squares of a two-dimensional grid (marching squares)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .grid import Grid

__all__ = ["segments_of"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def segments_of(grid: Grid, points: Floats, cells: Integers) -> Integers:
    """Pairs of points that a line joins within a square of four neighbouring cells.

    Points that are alone in a square are ends of lines. Where there are more than two, the nearest are
    joined first.

    Args:
        grid: The grid; no segments unless it has two axes.
        points: (P, 2).
        cells: Neighbours on both sides of every point, (P, 2).

    Returns:
        Segments, (S, 2).
    """
    if len(grid.shape) != 2 or not len(points):
        return np.empty((0, 2), np.int64)
    rows, columns = np.unravel_index(cells, grid.shape)
    row, column = rows.min(axis=1), columns.min(axis=1)
    upright = rows[:, 0] != rows[:, 1]  # the way is along the first axis, squares lie on both sides
    squares: dict[tuple[int, int], list[int]] = {}
    for number, (i, j, along) in enumerate(
        zip(row.tolist(), column.tolist(), upright.tolist(), strict=True)
    ):
        for square in ((i, j), (i, j - 1) if along else (i - 1, j)):
            squares.setdefault(square, []).append(number)
    segments = []
    for square in sorted(squares):
        left = squares[square]
        while len(left) > 1:
            steps = points[left] / grid.steps
            distance = np.linalg.norm(steps[:, None] - steps[None], axis=2)
            distance[np.tril_indices(len(left))] = np.inf
            first, second = np.unravel_index(int(distance.argmin()), distance.shape)
            segments.append((left[first], left[second]))
            left = [number for place, number in enumerate(left) if place not in (first, second)]
    return np.array(segments, np.int64).reshape(-1, 2)
