# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A map from what is in its file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.robot import Robot
from .borders import Border, BorderKind
from .grid import Grid
from .map_variables import FORMAT, KINDS, MEASURE_COLUMNS, SIGN_COLUMNS, STORED
from .stored_values import is_robot, is_same
from .workspace_map import CellArrays, WorkspaceMap

__all__ = ["map_of"]


def map_of(
    file: str | Path,
    robot: Robot,
    loads: Loads,
    attributes: dict[str, Any],
    arrays: dict[str, NDArray[Any]],
) -> WorkspaceMap:
    """The map in a file."""
    if attributes.get("cpr_map_format") != FORMAT:
        raise InvalidRequest("file", f"expected a map of format {FORMAT} in {file}")
    if not is_robot(robot, attributes["robot_description"]):
        other = "another robot_description, or other motors held"
        raise InvalidRequest("file", f"{file} is a map with {other}")
    if not is_same(loads, attributes["loads"]):
        raise InvalidRequest("file", f"{file} is a map with other loads")
    grid = _grid_of(attributes["grid"])
    whole = {}
    for name in STORED:
        values = arrays[name]
        whole[name] = np.ascontiguousarray(
            values.reshape(grid.size, *values.shape[len(grid.shape) :]),
            dtype=float if values.dtype.kind == "f" else np.int64,
        )
    for name in ("state", "platform_rotation", "platform_position"):
        if not np.isfinite(whole[name][whole["order"] >= 0]).all():
            raise ValueError(f"{name} of a cell that was reached is not finite")
    kinds = [kind for kind in KINDS if kind in attributes["border_kinds"].split()]
    return WorkspaceMap(
        robot=robot,
        loads=loads,
        grid=grid,
        cells=CellArrays(
            order=whole["order"],
            state=whole["state"],
            rotation=whole["platform_rotation"],
            position=whole["platform_position"],
            signs=_side_by_side(whole, SIGN_COLUMNS),
            efforts=whole["efforts"],
            energy=whole["energy"],
            eigenvalues=whole["eigenvalues_locked"],
            measures=_side_by_side(whole, MEASURE_COLUMNS),
            edges=whole["edges"],
            edge_fraction=whole["edge_fraction"],
        ),
        expanded=int(attributes["expanded"]),
        borders=tuple(_border_of(arrays, kind, len(grid.shape)) for kind in kinds),
        objective=attributes.get("objective", ""),
        # Older maps do not say: of the tolerance of their borders nothing is known.
        tolerance=_tolerance(attributes.get("tolerance", 0.0)),
        refined_to=_tolerance(attributes.get("refined_to", math.inf)),
    )


def _side_by_side(whole: dict[str, NDArray[Any]], columns: dict[str, int]) -> NDArray[Any]:
    """Variables that are columns of one array of the cells."""
    return np.stack([whole[name] for name in sorted(columns, key=columns.__getitem__)], axis=1)


def _tolerance(value: Any) -> float:
    tolerance = float(value)
    if not tolerance >= 0.0:
        raise ValueError(f"a tolerance of {tolerance}")
    return tolerance


def _border_of(arrays: dict[str, NDArray[Any]], kind: BorderKind, axes: int) -> Border:
    def part(name: str, *shape: int, kind_of: type = np.int64) -> NDArray[Any]:
        return arrays.get(f"{kind}_{name}", np.empty((0, *shape))).astype(kind_of)

    return Border(
        kind,
        part("points", axes, kind_of=np.float64),
        part("cells", 2),
        part("before"),
        part("after"),
        part("segments", 2),
    )


def _grid_of(text: str) -> Grid:
    values = json.loads(text)
    values.pop("type")
    for name in ("origin", "directions"):
        values[name] = np.array(values[name], float)
    for name in ("names", "units", "axis_names", "axis_units"):
        values[name] = tuple(values[name])
    values["values"] = tuple(np.array(axis, float) for axis in values["values"])
    values["index"] = np.array(values["index"], np.int64)
    return Grid(**values)
