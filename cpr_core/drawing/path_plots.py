# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of equilibria and of paths, with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidRequest
from ..model.configurations import configuration_distance
from ..model.equilibrium import Equilibrium, check_equilibrium
from ..solving.find_equilibria import FoundEquilibrium
from ..solving.trace import Trace
from .robot_drawing import draw_equilibrium, set_equal_scale

__all__ = ["new_figure", "plot_equilibria", "plot_equilibrium", "plot_trace", "save_figure"]

#: Colours that the colour-blind tell apart (Okabe and Ito).
_BLUE, _ORANGE, _GREEN, _RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
_GREY, _BLACK = "#999999", "#000000"
#: Equilibria that are drawn at most: stable ones, then those of lowest energy.
_MOST_DRAWN = 24
_MARKS = {
    "fold": ("v", _RED),
    "bifurcation": ("D", _RED),
    "stability": ("o", _ORANGE),
    "singularity": ("s", _GREEN),
}


def plot_trace(found: Trace, file: Path) -> None:
    """Draw a path: the robot on its way, platform, motors and smallest eigenvalues with all events.

    Args:
        found: The path.
        file: Picture to write; its ending tells the format.
    """
    found = _up_to_the_stop(found)
    figure = new_figure((13.0, 8.0))
    spatial = not found.robot.planar
    views = figure.add_subplot(2, 2, 1, projection="3d" if spatial else None)
    count = len(found.equilibria)
    for number in np.unique(np.linspace(0, count - 1, min(count, 6)).astype(int)):
        equilibrium = found.equilibria[number]
        color = _BLUE if equilibrium.index_locked == 0 else _RED
        draw_equilibrium(views, equilibrium, color=color)
    set_equal_scale(views)
    views.set_title("the robot on its way (red: unstable, motors held)")

    by_step = not np.all(np.diff(found.fractions) > 0.0)
    along = np.arange(count) if by_step else found.fractions
    label = "step along the branch" if by_step else "fraction of the way"
    panels = (
        (found.platform_positions, "platform position [m]", ("x", "y", "z")[: 3 if spatial else 2]),
        (found.motors, f"motors [{_motor_units(found)}]", found.robot.motor_names),
        (found.eigenvalues_locked[:, :3], "smallest eigenvalues of H_r, motors held [J]", None),
    )
    for place, (values, title, names) in enumerate(panels, start=2):
        axes = figure.add_subplot(2, 2, place)
        lines = axes.plot(along, values if names is None else values[:, : len(names)])
        if names is not None:
            _name_lines(axes, lines, names)
        else:
            axes.axhline(0.0, color=_BLACK, linewidth=0.8)
        axes.set_xlabel(label)
        axes.set_title(title)
        axes.grid(alpha=0.3)
        _mark_events(axes, found, _steps_of_events(found) if by_step else None, place == 4)
    figure.suptitle(found.robot.description.name)
    save_figure(figure, file)


def plot_equilibrium(equilibrium: Equilibrium, file: str | Path) -> None:
    """Draw one equilibrium: blue if it is stable with the motors held, else grey.

    Args:
        equilibrium: The equilibrium.
        file: Picture to write; its ending tells the format.

    Raises:
        InvalidRequest: No equilibrium, or the ending names no format of pictures.
    """
    check_equilibrium(equilibrium)
    robot = equilibrium.robot
    figure = new_figure((7.0, 6.0))
    figure.get_layout_engine().set(rect=(0.0, 0.0, 0.93, 1.0))  # names of upright axes stand out
    axes = figure.add_subplot(projection=None if robot.planar else "3d")
    draw_equilibrium(axes, equilibrium, color=_BLUE if equilibrium.stable else _GREY)
    set_equal_scale(axes)
    state = "stable" if equilibrium.stable else f"index {equilibrium.index_locked}"
    axes.set_title(f"{robot.description.name}: {state} with the motors held")
    save_figure(figure, file)


def plot_equilibria(found: Sequence[FoundEquilibrium], file: Path) -> None:
    """Draw equilibria in pictures side by side: stable ones first and in blue, then by energy.

    Args:
        found: The equilibria, by energy; at least one.
        file: Picture to write; its ending tells the format.

    Raises:
        InvalidRequest: There is none, or the ending names no format of pictures.
    """
    if not found:
        raise InvalidRequest("found", "expected at least one equilibrium")
    shown = sorted(found, key=lambda entry: not entry.stable)[:_MOST_DRAWN]
    columns = min(6, len(shown))
    rows = -(-len(shown) // columns)
    figure = new_figure((3.0 * columns, 3.2 * rows + 0.6))
    planar = shown[0].equilibrium.robot.planar
    for place, entry in enumerate(shown, start=1):
        axes = figure.add_subplot(rows, columns, place, projection=None if planar else "3d")
        draw_equilibrium(axes, entry.equilibrium, color=_BLUE if entry.stable else _GREY)
        set_equal_scale(axes)
        axes.set(xlabel="", ylabel="", xticklabels=[], yticklabels=[])
        if not planar:
            axes.set(zlabel="", zticklabels=[])
        kind = "stable" if entry.stable else f"index {entry.equilibrium.index_locked}"
        home = ", branch of home" if entry.from_home else ""
        axes.set_title(
            f"{entry.equilibrium.energy:.4f} J\n{kind}{home}",
            fontsize="small",
            fontweight="bold" if entry.stable else "normal",
            color=_BLUE if entry.stable else _BLACK,
        )
    name = found[0].equilibrium.robot.description.name
    part = f", {len(shown)} of them drawn" if len(found) > len(shown) else ""
    figure.suptitle(f"{name}: {len(found)} equilibria{part}; blue: stable with the motors held")
    save_figure(figure, file, dpi=110.0)


def _up_to_the_stop(found: Trace) -> Trace:
    """The same with the equilibrium that it was stopped at, which is between its points."""
    stopped = found.stopped
    if stopped is None or (found.equilibria and stopped.equilibrium is found.equilibria[-1]):
        return found
    fractions = np.append(found.fractions, stopped.fraction)
    return replace(found, fractions=fractions, equilibria=(*found.equilibria, stopped.equilibrium))


def _name_lines(axes: Any, lines: Sequence[Any], names: Sequence[str]) -> None:
    """A legend of all lines: as labels names that begin with _ would be left out."""
    places = [str(place) for place in range(len(names))]
    legend = axes.legend(lines, places, loc="best", fontsize="small")
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_text(name)


def _steps_of_events(found: Trace) -> list[int]:
    """Numbers of the equilibria that are nearest to the events."""
    shapes = np.array([point.configuration for point in found.equilibria])
    return [
        int(configuration_distance(found.robot, event.equilibrium.configuration, shapes).argmin())
        for event in found.events
    ]


def _mark_events(axes: Any, found: Trace, steps: list[int] | None, named: bool) -> None:
    """Mark the events at their fractions, or at steps."""
    places = [event.fraction for event in found.events] if steps is None else steps
    for event, place in zip(found.events, places, strict=True):
        marker, color = _MARKS.get(event.kind, ("x", _BLACK))
        axes.axvline(place, color=color, linestyle=":", linewidth=1.2)
        if named:
            axes.plot(place, 0.0, marker, color=color, label=event.kind)
    if named and found.events:
        handles, labels = axes.get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        axes.legend(unique.values(), unique.keys(), loc="best", fontsize="small")


def _motor_units(found: Trace) -> str:
    units = {motor.unit for motor in found.robot.description.motors}
    return " or ".join(sorted(units))


def save_figure(figure: Any, file: str | Path, dpi: float = 120.0) -> None:
    """Write a figure; names in it are drawn as they are written, also those with $.

    Raises:
        InvalidRequest: The ending names no format of pictures.
        OSError: The file cannot be written.
    """
    _take_no_mathematics(figure)
    try:
        figure.savefig(file, dpi=dpi, format=Path(file).suffix[1:].lower() or None)
    except ValueError as error:  # matplotlib lists what endings there are
        raise InvalidRequest("file", f"{file}: cannot be drawn to: {error}") from None


def _take_no_mathematics(figure: Any) -> None:
    """Have no text but the numbers along axes read as mathematics, which is between two $."""
    from matplotlib.axis import Axis, Tick
    from matplotlib.text import Text

    numbers = {label for tick in figure.findobj(Tick) for label in (tick.label1, tick.label2)}
    numbers |= {axis.get_offset_text() for axis in figure.findobj(Axis)}
    for text in figure.findobj(Text):
        if text not in numbers:
            text.set_parse_math(False)


def new_figure(size: tuple[float, float]) -> Any:
    """A figure of this size [in] that needs no window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure
