"""Equilibria over a grid of platform positions, on the branch of a start."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpr_core import Equilibrium, NoSolution, solve_inverse

__all__ = ["sweep"]

Floats = NDArray[np.float64]


def sweep(
    start: Equilibrium,
    pose: Callable[[float, float], ArrayLike],
    xs: Floats,
    ys: Floats,
) -> dict[tuple[int, int], Equilibrium]:
    """Spread from grid point to grid point, each solved from the neighbour it was reached from.

    Args:
        start: Equilibrium at or near a point of the grid.
        pose: Controlled coordinates at (x, y).
        xs: Grid along x [m].
        ys: Grid along y [m].

    Returns:
        Equilibria by grid indices; points that were not reached are missing.
    """
    place = start.platform_position
    seed = (int(np.abs(xs - place[0]).argmin()), int(np.abs(ys - place[1]).argmin()))
    reached = {seed: solve_inverse(start.robot, pose(xs[seed[0]], ys[seed[1]]), start=start)}
    waiting = deque([seed])
    while waiting:
        i, j = waiting.popleft()
        for next_i, next_j in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if not (0 <= next_i < len(xs) and 0 <= next_j < len(ys)) or (next_i, next_j) in reached:
                continue
            try:
                there = solve_inverse(
                    start.robot, pose(xs[next_i], ys[next_j]), start=reached[i, j]
                )
            except NoSolution:
                continue
            reached[next_i, next_j] = there
            waiting.append((next_i, next_j))
    return reached
