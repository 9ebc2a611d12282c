"""Maps on disk: an xarray Dataset in NetCDF (classic, 64-bit offsets), which everything reads.

A checkpoint is the map so far: written beside the file and then put in its place in one step, so that
the file is a whole map at any time, and a map that was killed goes on from it.
"""

from __future__ import annotations

import json
import os
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..loads import Loads
from ..robot import Robot
from .borders import Border, BorderKind
from .grid import Grid
from .workspace_map import CellArrays, WorkspaceMap

if TYPE_CHECKING:
    import xarray

__all__ = ["as_dataset", "read_flood", "read_map", "write_map"]

Floats = NDArray[np.float64]

#: Version of the layout of the file.
FORMAT = 1
_KINDS: tuple[BorderKind, ...] = ("stability", "stability_free", "limits", "singularity")


def as_dataset(found: WorkspaceMap) -> xarray.Dataset:
    """A map with named dimensions and units.

    Args:
        found: The map, complete or not.
    """
    import xarray

    grid, cells, robot = found.grid, found.cells, found.robot
    axes, shape = grid.axis_names, grid.shape
    dataset = xarray.Dataset(
        coords={
            name: ((name,), values, {"units": unit})
            for name, values, unit in zip(axes, grid.values, grid.axis_units, strict=True)
        },
        attrs=_attributes(found),
    )

    def add(name: str, values: Any, dims: tuple[str, ...], units: str, meaning: str) -> None:
        values = np.asarray(values)
        if not values.size:  # NetCDF has no dimensions without length
            return
        dataset[name] = (
            (*axes, *dims),
            values.reshape(*shape, *values.shape[1:]),
            {"units": units, "long_name": meaning},
        )

    motor_units = _joined(leg.motor.unit for leg in robot.description.legs if leg.motor_name)
    add("order", cells.order.astype(np.int32), (), "1", "when a cell was reached, -1: not reached")
    add("motors", found.motors, ("motor",), motor_units, "motor positions")
    add("efforts", cells.efforts, ("motor",), "N m or N", "motor efforts")
    add("platform_position", cells.position, ("xyz",), "m", "platform origin in the world")
    add("platform_rotation", cells.rotation, ("row", "column"), "1", "platform in the world")
    add("energy", cells.energy, (), "J", "potential energy")
    signs = cells.signs.astype(np.int16)
    add("index_locked", signs[:, 0], (), "1", "stability index, motors held, -1: not reached")
    add("index_free", signs[:, 1], (), "1", "stability index, motors at constant effort")
    add("inverse_side", signs[:, 2], (), "1", "sign of the determinant of the inverse problem")
    add("branch_sign", signs[:, 3], (), "1", "sign that tells branches apart")
    add(
        "eigenvalues_locked",
        cells.eigenvalues,
        ("eigenvalue",),
        "J",
        "smallest of H_r, motors held",
    )
    add("smallest_eigenvalue_size", cells.measures[:, 0], (), "J", "smallest absolute one of H_r")
    add("largest_eigenvalue_size", cells.measures[:, 1], (), "J", "largest absolute one of H_r")
    add("inverse_condition_number", found.inverse_condition_number, (), "1", "of H_r, motors held")
    add("forward_margin", cells.measures[:, 2], (), "1", "smallest singular value, forward problem")
    add("inverse_margin", cells.measures[:, 3], (), "1", "smallest singular value, inverse problem")
    add("bending_strain", found.strains, ("leg",), "1", "largest of every rod")
    add(
        "limit_margin",
        found.limit_margins,
        ("limit",),
        "1",
        "distance from limits, negative: beyond",
    )
    add("within_limits", found.within_limits.astype(np.int8), (), "1", "all limits hold")
    usable = found.usable if np.any(found.reached) else np.zeros(grid.size, bool)
    add("usable", usable.astype(np.int8), (), "1", "reached stable and within limits all the way")
    add("state", cells.state, ("entry",), "SI", "leg coordinates, multipliers, (platform,) motors")
    edges = cells.edges.astype(np.int8)
    meaning = "way to a neighbour: 0 untried 1 passed 2 blocked 3 flipped 4 disagrees"
    add("edges", edges, ("way",), "1", meaning)
    add(
        "edge_fraction", cells.edge_fraction, ("way",), "1", "how far the branch was followed there"
    )
    for border in found.borders:
        _add_border(dataset, border)
    return dataset


def write_map(found: WorkspaceMap, file: str | Path) -> None:
    """Write a map in one step: whoever reads the file sees the map before or this one.

    Args:
        found: The map, complete or not.
        file: NetCDF file to write.
    """
    file = Path(file)
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        as_dataset(found).to_netcdf(beside, engine="scipy", format="NETCDF3_64BIT")
        with beside.open("rb+") as written:
            os.fsync(written.fileno())
        beside.replace(file)
    finally:
        beside.unlink(missing_ok=True)


def read_map(file: str | Path, robot: Robot, loads: Loads | None = None) -> WorkspaceMap:
    """Read a map.

    Args:
        file: NetCDF file.
        robot: The robot it is of.
        loads: Its loads; default those of the description.

    Raises:
        InvalidRequest: No map, or one of another robot or other loads.
    """
    loads = robot.default_loads if loads is None else loads
    with _opened(file) as dataset:
        attributes = dataset.attrs
        if attributes.get("cpr_map_format") != FORMAT:
            raise InvalidRequest("file", f"expected a map of format {FORMAT} in {file}")
        for name, mine in (("robot_description", _described(robot)), ("loads", _as_json(loads))):
            if attributes[name] != mine:
                raise InvalidRequest("file", f"{file} is a map with another {name}")
        grid = _grid_of(dataset)
        cells, whole = grid.size, {}
        for name in _STORED:
            values = dataset[name].values
            whole[name] = np.ascontiguousarray(
                values.reshape(cells, *values.shape[len(grid.shape) :]),
                dtype=float if values.dtype.kind == "f" else np.int64,
            )
        kinds = [kind for kind in _KINDS if kind in attributes["border_kinds"].split()]
        borders = tuple(_border_of(dataset, kind, len(grid.shape)) for kind in kinds)
    signs = [whole[name] for name in ("index_locked", "index_free", "inverse_side", "branch_sign")]
    measures = [whole["smallest_eigenvalue_size"], whole["largest_eigenvalue_size"]]
    measures += [whole["forward_margin"], whole["inverse_margin"]]
    return WorkspaceMap(
        robot=robot,
        loads=loads,
        grid=grid,
        cells=CellArrays(
            order=whole["order"],
            state=whole["state"],
            rotation=whole["platform_rotation"],
            position=whole["platform_position"],
            signs=np.stack(signs, axis=1),
            efforts=whole["efforts"],
            energy=whole["energy"],
            eigenvalues=whole["eigenvalues_locked"],
            measures=np.stack(measures, axis=1),
            edges=whole["edges"],
            edge_fraction=whole["edge_fraction"],
        ),
        expanded=int(attributes["expanded"]),
        borders=borders,
    )


def read_flood(file: Path, robot: Robot, loads: Loads, grid: Grid) -> WorkspaceMap:
    """Read a map to go on with.

    Raises:
        InvalidRequest: A map of another robot, other loads or another grid.
    """
    found = read_map(file, robot, loads)
    if _grid_as_json(found.grid) != _grid_as_json(grid):
        raise InvalidRequest("file", f"{file} is a map of another grid; name another file")
    return found


#: Variables a map is read from; the others follow from them.
_STORED = (
    "order", "state", "platform_rotation", "platform_position", "index_locked", "index_free",
    "inverse_side", "branch_sign", "efforts", "energy", "eigenvalues_locked",
    "smallest_eigenvalue_size", "largest_eigenvalue_size", "forward_margin", "inverse_margin",
    "edges", "edge_fraction",
)  # fmt: skip


def _opened(file: str | Path) -> xarray.Dataset:
    import xarray

    try:
        return xarray.load_dataset(file, engine="scipy")
    except (OSError, TypeError, ValueError) as error:
        raise InvalidRequest("file", f"expected a NetCDF file, {file} is none: {error}") from None


def _attributes(found: WorkspaceMap) -> dict[str, Any]:
    from .. import __version__

    return {
        "title": f"workspace of {found.robot.description.name}",
        "source": f"cpr_core {__version__}",
        "cpr_map_format": FORMAT,
        "robot": found.robot.description.name,
        "robot_file": found.robot.description.text,
        "robot_description": _described(found.robot),
        "loads": _as_json(found.loads),
        "grid": _grid_as_json(found.grid),
        "motor_names": ", ".join(found.robot.motor_names),
        "limit_names": ", ".join(found.limit_names),
        "border_kinds": " ".join(border.kind for border in found.borders),
        "expanded": found.expanded,
        "complete": int(found.complete),
    }


def _add_border(dataset: xarray.Dataset, border: Border) -> None:
    kind = border.kind
    point = f"{kind}_point"
    meaning = f"where the {kind} border is crossed, numbers along the axes"
    parts = (
        ("points", (point, "axis"), border.points),
        ("cells", (point, "side"), border.cells.astype(np.int32)),
        ("before", (point,), border.before.astype(np.int32)),
        ("after", (point,), border.after.astype(np.int32)),
        ("segments", (f"{kind}_segment", "end"), border.segments.astype(np.int32)),
    )
    for name, dims, values in parts:
        if values.size:
            dataset[f"{kind}_{name}"] = (dims, values)
    if border.points.size:
        dataset[f"{kind}_points"].attrs["long_name"] = meaning


def _border_of(dataset: xarray.Dataset, kind: BorderKind, axes: int) -> Border:
    def part(name: str, *shape: int) -> NDArray[np.int64]:
        if f"{kind}_{name}" not in dataset:
            return np.empty((0, *shape), np.int64)
        return dataset[f"{kind}_{name}"].values.astype(np.int64)

    points = np.empty((0, axes))
    if f"{kind}_points" in dataset:
        points = dataset[f"{kind}_points"].values.astype(float)
    return Border(
        kind, points, part("cells", 2), part("before"), part("after"), part("segments", 2)
    )


def _grid_as_json(grid: Grid) -> str:
    return _as_json(grid)


def _grid_of(dataset: xarray.Dataset) -> Grid:
    values = json.loads(dataset.attrs["grid"])
    values.pop("type")
    for name in ("origin", "directions"):
        values[name] = np.array(values[name], float)
    for name in ("names", "units", "axis_names", "axis_units"):
        values[name] = tuple(values[name])
    values["values"] = tuple(np.array(one, float) for one in values["values"])
    values["index"] = np.array(values["index"], np.int64)
    return Grid(**values)


def _described(robot: Robot) -> str:
    """A robot as text, the same wherever its description came from."""
    return _as_json(replace(robot.description, source="", text=""))


def _as_json(value: Any) -> str:
    """A dataclass with all that is in it; numbers are written to the last digit."""
    return json.dumps(_plain(value))


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        parts = {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        return {"type": type(value).__name__, **parts}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, dict):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return value


def _joined(units: Any) -> str:
    return " or ".join(sorted(set(units)))
