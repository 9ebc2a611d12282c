# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of maps, with matplotlib."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.robot import Robot
from ..validation import checked_word
from ..workspace.grid import Grid
from ..workspace.workspace_map import WorkspaceMap
from .path_plots import new_figure, save_figure

__all__ = [
    "FIELDS",
    "check_field",
    "field_label",
    "field_names",
    "fields_of",
    "plot_map",
    "prepare",
]

Floats = NDArray[np.float64]

#: What can be drawn of the maps of every robot.
FIELDS = (
    "index",
    "index_free",
    "inverse_condition_number",
    "smallest_eigenvalue",
    "forward_margin",
    "inverse_margin",
    "strain",
    "energy",
    "usable",
)
#: What can be drawn of those of robots with limits besides.
_OF_LIMITS = "limit_margin"
#: Colours that the colour-blind tell apart (Okabe and Ito): indices 0, 1, 2, more; then red.
_INDEX_COLORS = ("#9AD0F0", "#F0E442", "#CC79A7", "#5A5A5A")
_RED = "#C22000"
_LINES = {
    "stability": ("#000000", "-", "stability, motors held"),
    "singularity": ("#0072B2", "-", "end of the branch"),
    "limits": ("#E69F00", "--", "limit of a motor or rod"),
}
#: Pictures of slices at most.
_MOST_PANELS = 9


def field_names(robot: Robot) -> tuple[str, ...]:
    """What can be drawn of a robot's maps."""
    names = (*FIELDS, _OF_LIMITS) if robot.limited else FIELDS
    return (*names, *_positions(robot), *_efforts(robot))


def _positions(robot: Robot) -> tuple[str, ...]:
    """Fields of the motors: their names, unless something else is called so."""
    others = (*FIELDS, _OF_LIMITS, *_efforts(robot))
    return tuple(f"motor:{name}" if name in others else name for name in robot.motor_names)


def _efforts(robot: Robot) -> tuple[str, ...]:
    """Fields of their efforts."""
    return tuple(f"{name}_effort" for name in robot.motor_names)


def check_field(robot: Robot, field: str) -> None:
    """Whether a field can be drawn.

    Raises:
        InvalidRequest: It cannot.
    """
    checked_word("field", field, tuple(field_names(robot)))


def field_label(robot: Robot, field: str) -> str:
    """Name and unit of a field; no unit where it has none."""
    units = {
        "smallest_eigenvalue": "J",
        "energy": "J",
        _OF_LIMITS: "rad, rod lengths, or of the limit",
    }
    motors, of_motors = robot.description.motors, dict[str, str]()
    for motor, position, effort in zip(motors, _positions(robot), _efforts(robot), strict=True):
        of_motors |= {position: motor.unit, effort: motor.effort_unit}
    name = field if field in of_motors else field.replace("_", " ")
    units |= of_motors
    return f"{name} [{units[field]}]" if field in units else name


def fields_of(found: WorkspaceMap) -> dict[str, Floats]:
    """What can be drawn: values of all cells by name, (M,) each."""
    cells = found.cells
    fields: dict[str, Floats] = {
        "index": np.where(found.reached, found.index_locked, np.nan),
        "index_free": np.where(found.reached, found.index_free, np.nan),
        "inverse_condition_number": found.inverse_condition_number,
        "smallest_eigenvalue": cells.eigenvalues[:, 0],
        "forward_margin": found.forward_margin,
        "inverse_margin": found.inverse_margin,
        "strain": found.strains.max(axis=1),
        "energy": cells.energy,
        "usable": np.where(found.reached, found.usable, np.nan),
    }
    if found.limit_names:
        fields[_OF_LIMITS] = found.limit_margins.min(axis=1)
    fields |= dict(zip(_positions(found.robot), found.motors.T, strict=True))
    fields |= dict(zip(_efforts(found.robot), cells.efforts.T, strict=True))
    return fields


def prepare() -> None:
    """Load matplotlib: it takes half a second, which may pass while a map is computed."""
    new_figure((1.0, 1.0))
    importlib.import_module("matplotlib.collections")


def plot_map(
    found: WorkspaceMap,
    file: str | Path,
    *,
    field: str = "index",
    threshold: float = 1e-4,
) -> None:
    """Draw a map; of more than two dimensions slices along the last ones.

    Args:
        found: The map.
        file: Picture to write; its ending tells the format.
        field: What is drawn, out of :func:`field_names`. The index is red where the inverse condition
            number of H_r is below ``threshold``.
        threshold: See there; 0: nothing is red.

    Raises:
        InvalidRequest: No such field, or no format of pictures.
        OSError: The file cannot be written.
    """
    check_field(found.robot, field)
    grid = found.grid
    values = fields_of(found)[field].reshape(grid.shape[0], grid.shape[1], -1)
    near = (found.inverse_condition_number < threshold).reshape(values.shape)
    planes = np.unique(
        np.linspace(0, values.shape[2] - 1, min(_MOST_PANELS, values.shape[2])).round().astype(int)
    )
    columns = min(3, len(planes))
    rows = -(-len(planes) // columns)
    figure = new_figure((7.0 * columns if len(planes) == 1 else 5.0 * columns, 5.6 * rows))
    shown, keys = None, []
    for number, plane in enumerate(planes.tolist(), start=1):
        axes = figure.add_subplot(rows, columns, number)
        picture = np.where(near[:, :, plane], np.nan, values[:, :, plane])
        if field in ("index", "index_free"):
            keys += _draw_index(axes, found, picture, near[:, :, plane], threshold)
        else:
            shown = _draw_cells(axes, grid, values[:, :, plane], "cividis", _range(values))
        _draw_borders(axes, found, plane)
        _name_axes(axes, found, plane)
        keys += axes.get_legend_handles_labels()[0]
    if shown is not None:
        label = field_label(found.robot, field)
        figure.colorbar(shown, ax=figure.axes, label=label, shrink=0.8)
    by_label = {key.get_label(): key for key in keys}
    if by_label:
        below = 0.7 / figure.get_figheight()
        figure.get_layout_engine().set(rect=(0.0, below, 1.0, 1.0 - below))
        figure.legend(
            by_label.values(), by_label.keys(), loc="lower center", ncols=3, fontsize="small"
        )
    title = f"{found.robot.description.name}: {_held_text(found)}"
    if not np.any(np.isfinite(values)):  # else it would look like a robot that gets nowhere
        title += f"\n{field_label(found.robot, field)} is not known of any cell"
    figure.suptitle(title)
    save_figure(figure, file)


def _name_axes(axes: Any, found: WorkspaceMap, plane: int) -> None:
    """Names and units of both axes, and where the plane is along the others."""
    grid = found.grid
    names = [
        f"{name} [{unit}]" for name, unit in zip(grid.axis_names, grid.axis_units, strict=True)
    ]
    axes.set(xlabel=names[0], ylabel=names[1])
    if grid.axis_units[0] == grid.axis_units[1]:
        axes.set_aspect("equal")
    if len(grid.shape) > 2:
        place = found.place(plane)[2:]
        axes.set_title(
            ", ".join(
                _place(name, coordinate, unit)
                for name, coordinate, unit in zip(
                    grid.axis_names[2:], place, grid.axis_units[2:], strict=True
                )
            )
        )


def _draw_cells(
    axes: Any, grid: Grid, values: Floats, colors: Any, limits: tuple[float, float]
) -> Any:
    """Draw the values of one plane, a square for every cell; returns what a colour bar takes."""
    return axes.pcolormesh(
        *grid.values[:2],
        values.T,
        shading="nearest",
        cmap=colors,
        vmin=limits[0],
        vmax=limits[1],
        rasterized=True,
    )


def _range(values: Floats) -> tuple[float, float]:
    """From the least to the largest value that is known; (0, 1) where none is."""
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)


def _draw_index(
    axes: Any, found: WorkspaceMap, index: Floats, near: NDArray[np.bool_], threshold: float
) -> list[Any]:
    """Draw the index of one plane; returns the keys of its colours."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    grid = found.grid
    capped = np.minimum(index, 3.0)
    keys: list[Any] = []
    _draw_cells(axes, grid, capped, ListedColormap(_INDEX_COLORS), (-0.5, 3.5))
    words = {0: ": stable" if found.energy_criterion_applies else "", 3: " or more"}
    for value in np.unique(capped[np.isfinite(capped)]).astype(int).tolist():
        label = f"index {value}{words.get(value, '')}"
        keys.append(Patch(facecolor=_INDEX_COLORS[value], label=label))
    if np.any(near):
        red = np.where(near, 1.0, np.nan)
        axes.pcolormesh(
            *grid.values[:2], red.T, shading="nearest", cmap=ListedColormap([_RED]), rasterized=True
        )
        keys.append(Patch(facecolor=_RED, label=f"inverse condition number below {threshold:g}"))
    return keys


def _draw_borders(axes: Any, found: WorkspaceMap, plane: int) -> None:
    from matplotlib.collections import LineCollection

    flat = len(found.grid.shape) == 2
    depth = int(np.prod(found.grid.shape[2:], dtype=int))
    cut = found.disagreements
    cut = cut[np.all(cut % depth == plane, axis=1)]
    if len(cut):
        middle = 0.5 * (found.grid.places(cut[:, 0]) + found.grid.places(cut[:, 1]))
        label = "two ways disagree"
        axes.plot(*middle[:, :2].T, ".", color="#7A3E00", markersize=2.5, label=label)
    for border in found.borders:
        if not len(border.points) or border.kind not in _LINES:  # of motors held, not of efforts
            continue
        color, style, label = _LINES[border.kind]
        if flat:
            lines = LineCollection(
                list(border.points[border.segments]),
                colors=color,
                linestyles=style,
                linewidths=1.6,
                label=label,
            )
            axes.add_collection(lines)
            continue
        shown = np.all(border.cells % depth == plane, axis=1)
        if np.any(shown):
            axes.plot(*border.points[shown, :2].T, ".", color=color, markersize=2.5, label=label)


def _place(name: str, coordinate: float, unit: str) -> str:
    return f"{name} = {coordinate:.4g}{f' {unit}' if unit != '1' else ''}"


def _held_text(found: WorkspaceMap) -> str:
    grid = found.grid
    fixed = ~np.any(grid.directions != 0.0, axis=0)
    held = [
        _place(name, value, unit)
        for name, value, unit, alone in zip(grid.names, grid.origin, grid.units, fixed, strict=True)
        if alone
    ]
    return ", ".join(held) if held else "workspace"
