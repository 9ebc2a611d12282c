# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps on disk: NetCDF (classic, 64-bit offsets), which everything reads, and xarray datasets.

A checkpoint is the map so far: written beside the file and then put in its place in one step, so that
the file is a whole map at any time, and a map that was killed goes on from it.
"""

from __future__ import annotations

import json
import math
import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.record_layout import INDEX_FREE, INDEX_LOCKED, INVERSE_SIGN
from ..model.robot import Robot, checked_robot
from ..version import __version__
from .borders import Border, BorderKind
from .cell_layout import (
    BRANCH_SIGN,
    FORWARD_MARGIN,
    INVERSE_MARGIN,
    LARGEST_EIGENVALUE,
    NEAREST_EIGENVALUE,
)
from .grid import Grid
from .map_files import MapNotWritten, check_axis_names, unfinished_file
from .stored_values import as_json, is_robot, is_same, robot_as_json
from .workspace_map import CellArrays, WorkspaceMap

if TYPE_CHECKING:
    import xarray

__all__ = [
    "as_dataset",
    "read_flood",
    "read_map",
    "write_map",
]

#: Version of the layout of the file.
FORMAT = 1
_KINDS: tuple[BorderKind, ...] = ("stability", "stability_free", "limits", "singularity")


@dataclass(frozen=True, eq=False)
class _Variable:
    """An array with named dimensions."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: dict[str, str]


def as_dataset(found: WorkspaceMap) -> xarray.Dataset:
    """A map as an xarray Dataset: what is in the file, with named dimensions and units.

    Args:
        found: The map, complete or not.
    """
    import xarray

    whole = {
        name: (variable.dims, variable.values, variable.attributes)
        for name, variable in _variables(found).items()
    }
    coordinates = {name: whole.pop(name) for name in found.grid.axis_names}
    return xarray.Dataset(whole, coordinates, _attributes(found))


def write_map(found: WorkspaceMap, file: str | Path) -> None:
    """Write a map in one step: whoever reads the file sees the map before or this one.

    Args:
        found: The map, complete or not.
        file: NetCDF file to write.

    Raises:
        MapNotWritten: It cannot be written; the file is as it was.
    """
    file = Path(file)
    beside = unfinished_file(file, os.getpid())
    variables = _variables(found)
    try:
        with scipy.io.netcdf_file(beside, "w", version=2) as target:
            for name, value in _attributes(found).items():
                setattr(target, name, _stored_attribute(value))
            for name, variable in variables.items():
                for dim, length in zip(variable.dims, variable.values.shape, strict=True):
                    if dim not in target.dimensions:
                        target.createDimension(dim, length)
                stored = target.createVariable(name, variable.values.dtype, variable.dims)
                stored[:] = variable.values
                for attribute, text in variable.attributes.items():
                    setattr(stored, attribute, text.encode())
        with beside.open("rb+") as written:
            os.fsync(written.fileno())
        beside.replace(file)
    except OSError as error:
        raise MapNotWritten(file, found, error.strerror or str(error)) from None
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def _stored_attribute(value: str | int | float) -> Any:
    if isinstance(value, str):
        return value.encode()
    return np.int32(value) if isinstance(value, int) else np.float64(value)


def read_map(file: str | Path, robot: Robot, loads: Loads | None = None) -> WorkspaceMap:
    """Read a map.

    Args:
        file: NetCDF file.
        robot: The robot it is of.
        loads: Its loads; default those of the description.

    Raises:
        InvalidRequest: No map, one that is damaged, or one of another robot or other loads.
    """
    loads = checked_robot(robot).default_loads if loads is None else loads
    attributes, arrays = _read(file)
    try:
        return _map_of(file, robot, loads, attributes, arrays)
    except (AttributeError, KeyError, TypeError, ValueError, IndexError) as error:
        problem = f"expected a whole map, {file} is damaged: {error!r:.200}"
        raise InvalidRequest("file", problem) from None


def _map_of(
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
    for name in _STORED:
        values = arrays[name]
        whole[name] = np.ascontiguousarray(
            values.reshape(grid.size, *values.shape[len(grid.shape) :]),
            dtype=float if values.dtype.kind == "f" else np.int64,
        )
    for name in ("state", "platform_rotation", "platform_position"):
        if not np.isfinite(whole[name][whole["order"] >= 0]).all():
            raise ValueError(f"{name} of a cell that was reached is not finite")
    kinds = [kind for kind in _KINDS if kind in attributes["border_kinds"].split()]
    return WorkspaceMap(
        robot=robot,
        loads=loads,
        grid=grid,
        cells=CellArrays(
            order=whole["order"],
            state=whole["state"],
            rotation=whole["platform_rotation"],
            position=whole["platform_position"],
            signs=_side_by_side(whole, _SIGNS),
            efforts=whole["efforts"],
            energy=whole["energy"],
            eigenvalues=whole["eigenvalues_locked"],
            measures=_side_by_side(whole, _MEASURES),
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


def read_flood(file: Path, robot: Robot, loads: Loads, grid: Grid, objective: str) -> WorkspaceMap:
    """Read a map to go on with.

    Raises:
        InvalidRequest: A map of another robot, other loads, another grid or another objective.
    """
    found = read_map(file, robot, loads)
    if as_json(found.grid) != as_json(grid):
        raise InvalidRequest("file", f"{file} is a map of another grid; name another file")
    if found.objective != objective:
        raise InvalidRequest(
            "file", f"{file} is a map of {found.objective}, expected {objective}; name another file"
        )
    return found


#: Variables that are columns of the signs and the measures of the cells.
_SIGNS = {
    "index_locked": INDEX_LOCKED,
    "index_free": INDEX_FREE,
    "inverse_side": INVERSE_SIGN,
    "branch_sign": BRANCH_SIGN,
}
_MEASURES = {
    "smallest_eigenvalue_size": NEAREST_EIGENVALUE,
    "largest_eigenvalue_size": LARGEST_EIGENVALUE,
    "forward_margin": FORWARD_MARGIN,
    "inverse_margin": INVERSE_MARGIN,
}
#: Variables a map is read from; the others follow from them.
_STORED = (
    "order",
    "state",
    "platform_rotation",
    "platform_position",
    *_SIGNS,
    "efforts",
    "energy",
    "eigenvalues_locked",
    *_MEASURES,
    "edges",
    "edge_fraction",
)


def _variables(found: WorkspaceMap) -> dict[str, _Variable]:
    """Everything in the file by name."""
    grid, cells, robot = found.grid, found.cells, found.robot
    check_axis_names(grid)
    variables = {
        name: _Variable((name,), values, {"units": unit})
        for name, values, unit in zip(grid.axis_names, grid.values, grid.axis_units, strict=True)
    }

    def add(name: str, values: NDArray[Any], dims: str, units: str, meaning: str) -> None:
        if values.size:  # NetCDF has no dimensions without length
            variables[name] = _Variable(
                (*grid.axis_names, *dims.split()),
                values.reshape(*grid.shape, *values.shape[1:]),
                {"units": units, "long_name": meaning},
            )

    def add_column(name: str, units: str, meaning: str) -> None:
        add(name, columns[name], "", units, meaning)

    units = {motor.unit for motor in robot.description.motors}
    columns: dict[str, NDArray[Any]] = {
        **{name: cells.signs[:, place].astype(np.int16) for name, place in _SIGNS.items()},
        **{name: cells.measures[:, place] for name, place in _MEASURES.items()},
    }
    usable = found.usable if np.any(found.reached) else np.zeros(grid.size, bool)
    meaning = "way to a neighbour: 0 untried 1 passed 2 blocked 3 flipped 4 disagrees"
    add("order", cells.order.astype(np.int32), "", "1", "when a cell was reached, -1: not reached")
    add("motors", found.motors, "motor", " or ".join(sorted(units)), "motor positions")
    add("efforts", cells.efforts, "motor", "N m or N", "motor efforts")
    add("platform_position", cells.position, "xyz", "m", "platform origin in the world")
    add("platform_rotation", cells.rotation, "row column", "1", "platform in the world")
    add("energy", cells.energy, "", "J", "potential energy")
    add_column("index_locked", "1", "stability index, motors held, -1: not reached")
    add_column("index_free", "1", "stability index, motors at constant effort")
    add_column("inverse_side", "1", "sign of the determinant of the inverse problem")
    add_column("branch_sign", "1", "sign that tells branches apart")
    add("eigenvalues_locked", cells.eigenvalues, "eigenvalue", "J", "smallest of H_r, motors held")
    add_column("smallest_eigenvalue_size", "J", "smallest absolute one of H_r")
    add_column("largest_eigenvalue_size", "J", "largest absolute one of H_r")
    add("inverse_condition_number", found.inverse_condition_number, "", "1", "of H_r, motors held")
    add_column("forward_margin", "1", "smallest singular value, forward problem")
    add_column("inverse_margin", "1", "smallest singular value, inverse problem")
    add("bending_strain", found.strains, "rod", "1", "largest of every rod")
    add("limit_margin", found.limit_margins, "limit", "1", "distance from limits, negative: beyond")
    add("within_limits", found.within_limits.astype(np.int8), "", "1", "all limits hold")
    add("usable", usable.astype(np.int8), "", "1", "reached stable and within limits all the way")
    add("state", cells.state, "entry", "SI", "leg coordinates, multipliers, (platform,) motors")
    add("edges", cells.edges.astype(np.int8), "way", "1", meaning)
    add("edge_fraction", cells.edge_fraction, "way", "1", "how far the branch was followed there")
    for border in found.borders:
        variables |= _border_variables(border)
    return variables


def _read(file: str | Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Attributes and arrays of a file."""
    try:
        with scipy.io.netcdf_file(file, "r", mmap=False) as source:
            attributes = {
                name: value.decode() if isinstance(value, bytes) else value
                for name, value in source._attributes.items()
            }
            arrays = {name: variable.data for name, variable in source.variables.items()}
    except Exception as error:  # damaged headers lead the reader anywhere
        raise InvalidRequest("file", f"expected a NetCDF file, {file} is none: {error}") from None
    return attributes, arrays


def _attributes(found: WorkspaceMap) -> dict[str, Any]:

    return {
        "title": f"workspace of {found.robot.description.name}",
        "source": f"cpr_core {__version__}",
        "cpr_map_format": FORMAT,
        "robot": found.robot.description.name,
        "robot_file": found.robot.description.text,
        "robot_description": robot_as_json(found.robot),
        "loads": as_json(found.loads),
        "grid": as_json(found.grid),
        "motor_names": ", ".join(found.robot.motor_names),
        "limit_names": ", ".join(found.limit_names),
        "border_kinds": " ".join(border.kind for border in found.borders),
        "objective": found.objective,
        "tolerance": float(found.tolerance),
        "refined_to": float(found.refined_to),
        "expanded": found.expanded,
        "complete": int(found.complete),
    }


def _border_variables(border: Border) -> dict[str, _Variable]:
    kind = border.kind
    point = f"{kind}_point"
    meaning = f"where the {kind} border is crossed, numbers along the axes"
    parts = {
        "points": _Variable((point, "axis"), border.points, {"long_name": meaning}),
        "cells": _Variable((point, "side"), border.cells.astype(np.int32), {}),
        "before": _Variable((point,), border.before.astype(np.int32), {}),
        "after": _Variable((point,), border.after.astype(np.int32), {}),
        "segments": _Variable((f"{kind}_segment", "end"), border.segments.astype(np.int32), {}),
    }
    return {f"{kind}_{name}": part for name, part in parts.items() if part.values.size}


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
