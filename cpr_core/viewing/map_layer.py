# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map as points in the scene: where the platform is in every cell that was reached."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.configurations import SAME_EQUILIBRIUM, configuration_distance
from ..model.robot import Robot
from ..workspace.store import read_map
from ..workspace.workspace_map import WorkspaceMap
from .handled_robot import HandledRobot

__all__ = ["MapLayer", "go_to_cell", "read_layer"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Index 0, 1, 2, more (Okabe and Ito, as in pictures of maps); then beyond limits.
_COLORS = np.array([[154, 208, 240], [240, 228, 66], [204, 121, 167], [90, 90, 90]], np.uint8)
_BEYOND = np.array([230, 159, 0], np.uint8)
#: A click farther than so many cells from every point means none of them.
_NEAR = 1.5


@dataclass(frozen=True, eq=False)
class MapLayer:
    """Reached cells of a map.

    Attributes:
        found: The map.
        cells: Flat numbers of the reached cells, (P,).
        points: Where the platform is in them, (P, 3) [m].
        colors: By stability index, orange where a limit does not hold, (P, 3).
        size: Distance of neighbours in the scene [m].
    """

    found: WorkspaceMap
    cells: Integers
    points: Floats
    colors: NDArray[np.uint8]
    size: float

    def nearest(self, origin: ArrayLike, direction: ArrayLike) -> int | None:
        """Number of the cell that a ray of a click meets first; None: it misses them.

        Args:
            origin: Where the ray begins, (3,) [m].
            direction: Where it leads, (3,).
        """
        way = np.asarray(direction, float) / np.linalg.norm(direction)
        offset = self.points - np.asarray(origin, float)
        along = offset @ way
        beside = np.linalg.norm(offset - along[:, None] * way, axis=1)
        hit = (beside < _NEAR * self.size) & (along > 0.0)
        if not np.any(hit):
            return None
        # Among those that are hit about equally well the first; in a plane, the nearest to the ray.
        best = np.flatnonzero(hit)[np.argmin(beside[hit] + 1e-3 * along[hit])]
        return int(self.cells[best])


def read_layer(robot: Robot, file: str | Path, loads: Loads | None = None) -> MapLayer:
    """Read a map.

    Args:
        robot: The robot it is of.
        file: NetCDF file.
        loads: Its loads; default those of the description.

    Raises:
        InvalidRequest: No map, one of another robot, other modes or loads, or an empty one.
    """
    found = read_map(file, robot, loads)
    cells = np.flatnonzero(found.reached)
    if not len(cells):
        raise InvalidRequest("file", f"expected a map with a cell that was reached, got {file}")
    colors = _COLORS[np.minimum(found.index_locked[cells], 3)]
    colors[~found.within_limits[cells]] = _BEYOND
    points = found.cells.position[cells]
    return MapLayer(found, cells, points, colors, _spacing(found))


def go_to_cell(handled: HandledRobot, found: WorkspaceMap, cell: int) -> bool:
    """Walk to what a cell imposes, from where the robot is; whether it was reached, in words too."""
    reached = found.equilibrium(cell)
    if found.grid.given == "motors" or not handled.robot.description.controlled:
        arrived = handled.move_motors(reached.motors, "map")
    else:
        arrived = handled.move_pose(reached.pose, "map")
    if arrived:
        place = ", ".join(f"{value:.4g}" for value in found.place(cell))
        handled.words = f"at the cell {', '.join(found.grid.axis_names)} = {place} of the map"
        current = handled.equilibrium
        apart = configuration_distance(found.robot, current.configuration, reached.configuration)
        if apart > SAME_EQUILIBRIUM:
            handled.words += (
                f", in another equilibrium than the map has there: index {current.index_locked}, that "
                f"of the map {reached.index_locked}"
            )
    return arrived


def _spacing(found: WorkspaceMap) -> float:
    """Typical distance of the platform from a cell to its next one [m]."""
    ways = []
    for column in range(1, found.grid.neighbours.shape[1], 2):
        beyond = found.grid.neighbours[:, column]
        both = found.reached & (beyond >= 0) & found.reached[beyond]
        if np.any(both):
            ends = found.cells.position
            ways.append(np.linalg.norm(ends[beyond[both]] - ends[both], axis=1))
    lengths = np.concatenate(ways) if ways else np.zeros(0)
    lengths = lengths[lengths > 1e-6 * found.robot.mean_length]  # turning alone moves nothing
    return float(np.median(lengths)) if len(lengths) else 0.02 * found.robot.mean_length
