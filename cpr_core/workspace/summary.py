# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map in a few numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidRequest
from ..validation import checked_number
from .borders import BorderKind
from .workspace_map import WorkspaceMap

__all__ = ["BorderSummary", "MapSummary", "summary_of"]


@dataclass(frozen=True)
class BorderSummary:
    """A border in a few numbers.

    Attributes:
        kind: What changes there.
        points: Number of points.
        lower: Smallest number of any point along every axis; none without points.
        upper: Largest one.
    """

    kind: BorderKind
    points: int
    lower: tuple[float, ...]
    upper: tuple[float, ...]


@dataclass(frozen=True)
class MapSummary:
    """Numbers of cells by their state.

    Attributes:
        cells: Cells of the grid.
        shape: Cells along the axes.
        complete: Whether all that can be reached was reached, and the borders refined to the tolerance.
        reached: Cells that continuous branches lead to.
        stable: Reached cells with index 0, motors held.
        usable: Cells to which the robot can go from the first one, stable and within its limits.
        beyond_limits: Reached cells where a limit of a motor or rod does not hold.
        below_threshold: Reached cells with an inverse condition number of H_r below the threshold.
        disagreements: Pairs of neighbours between which two ways lead to two equilibria.
        cell_area: Product of the steps along the axes: times a number of cells it is an area, where the
            axes are coordinates.
        borders: Borders, without their points.
    """

    cells: int
    shape: tuple[int, ...]
    complete: bool
    reached: int
    stable: int
    usable: int
    beyond_limits: int
    below_threshold: int
    disagreements: int
    cell_area: float
    borders: tuple[BorderSummary, ...]


def summary_of(found: WorkspaceMap, threshold: float) -> MapSummary:
    """A map in a few numbers.

    Args:
        found: The map, complete or not.
        threshold: Cells whose inverse condition number of H_r is below are counted.

    Raises:
        InvalidRequest: A threshold that is no number, or a negative one.
        NonFiniteInput: A NaN or an infinity.
    """
    if checked_number("threshold", threshold) < 0.0:
        raise InvalidRequest("threshold", f"expected at least 0, got {threshold}")
    reached = found.reached
    return MapSummary(
        cells=found.grid.size,
        shape=found.grid.shape,
        complete=found.complete,
        reached=int(reached.sum()),
        stable=int(np.sum(found.index_locked == 0)),
        usable=int(found.usable.sum()),
        beyond_limits=int(np.sum(reached & ~found.within_limits)),
        below_threshold=int(np.sum(found.inverse_condition_number < threshold)),
        disagreements=len(found.disagreements),
        cell_area=float(np.prod(found.grid.steps)),
        borders=tuple(
            BorderSummary(
                border.kind,
                len(border.points),
                tuple(border.points.min(axis=0).tolist()) if len(border.points) else (),
                tuple(border.points.max(axis=0).tolist()) if len(border.points) else (),
            )
            for border in found.borders
        ),
    )
