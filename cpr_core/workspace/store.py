# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps on disk: NetCDF (classic, 64-bit offsets), which everything reads, and xarray datasets.

A checkpoint is the map so far: written beside the file and then put in its place in one step, so that
the file is a whole map at any time, and a map that was killed goes on from it.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.robot import Robot, checked_robot
from .grid import Grid
from .map_files import MapNotWritten, unfinished_file
from .map_variables import attributes_of, variables_of
from .stored_map import map_of
from .stored_values import as_json
from .workspace_map import WorkspaceMap

if TYPE_CHECKING:
    import xarray

__all__ = [
    "as_dataset",
    "read_flood",
    "read_map",
    "write_map",
]


def as_dataset(found: WorkspaceMap) -> xarray.Dataset:
    """A map as an xarray Dataset: what is in the file, with named dimensions and units.

    Args:
        found: The map, complete or not.
    """
    import xarray

    whole = {
        name: (variable.dims, variable.values, variable.attributes)
        for name, variable in variables_of(found).items()
    }
    coordinates = {name: whole.pop(name) for name in found.grid.axis_names}
    return xarray.Dataset(whole, coordinates, attributes_of(found))


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
    variables = variables_of(found)
    try:
        with scipy.io.netcdf_file(beside, "w", version=2) as target:
            for name, value in attributes_of(found).items():
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
        return map_of(file, robot, loads, attributes, arrays)
    except (AttributeError, KeyError, TypeError, ValueError, IndexError) as error:
        problem = f"expected a whole map, {file} is damaged: {error!r:.200}"
        raise InvalidRequest("file", problem) from None


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
