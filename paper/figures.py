# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The figures, drawn to be read: units, legends, colours told apart by everybody."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium
from cpr_core.drawing.robot_drawing import draw_equilibrium, set_equal_scale
from cpr_core.workspace import WorkspaceMap

from .stability import Line

__all__ = [
    "draw_determinants",
    "draw_errors",
    "draw_line",
    "draw_path",
    "draw_workspace",
]

Floats = NDArray[np.float64]

#: Colours of Okabe and Ito.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
DASHES = ("-", "--", "-.", ":")
MARKERS = "os^D"
#: Borders of workspaces that are drawn.
BORDERS = {
    "stability": ("#8A1C00", "border of stability"),
    "singularity": ("#0072B2", "inverse singularity"),
}


def _new(width: float, height: float, **options: Any) -> tuple[Any, Any]:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "cpr_ros"})
    return plt.subplots(figsize=(width, height), layout="constrained", **options)


def _save(figure: Any, folder: Path, name: str) -> None:
    import matplotlib.pyplot as plt

    figure.savefig(folder / f"{name}.png", dpi=110)
    figure.set_layout_engine(None)  # it has been laid out, which takes longer than drawing it
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    plt.close(figure)


def draw_path(
    folder: Path, name: str, title: str, points: Sequence[Equilibrium], track: Floats
) -> None:
    """Configurations along a path, and all positions of P on it (Figs. 4 and 10)."""
    import matplotlib as mpl

    planar = points[0].robot.planar
    options = {} if planar else {"subplot_kw": {"projection": "3d"}}
    figure, axes = _new(6.0, 5.0, **options)
    colours = mpl.colormaps["viridis"]
    last = len(points) - 1
    for t, point in enumerate(points):
        draw_equilibrium(axes, point, color=colours(t / last))
    axes.plot(*track.T[: 2 if planar else 3], ":", color="black", linewidth=1.0, label="path of P")
    axes.plot([], [], "o", color="black", markersize=4, label="motors A_i")
    set_equal_scale(axes)
    axes.legend(loc="upper left")
    axes.set_title(title)
    scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(0, last), colours)
    figure.colorbar(scale, ax=axes, shrink=0.7, pad=0.1, label=f"t of Eq. (53), n_c = {last}")
    _save(figure, folder, name)


def draw_errors(
    folder: Path,
    name: str,
    title: str,
    label: str,
    errors: dict[int, Floats],
    counted: str,
) -> None:
    """Errors along a path, one line per model (Figs. 5 and 11)."""
    figure, axes = _new(6.0, 3.6)
    for number, (key, values) in enumerate(errors.items()):
        axes.semilogy(
            values,
            color=COLOURS[number],
            linestyle=DASHES[number],
            marker=MARKERS[number],
            markersize=3.5,
            label=f"{key} {counted}",
        )
    axes.set_xlabel("t of Eq. (53), n_c = 50")
    axes.set_ylabel(label)
    axes.set_title(title)
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    _save(figure, folder, name)


def draw_workspace(
    folder: Path, name: str, title: str, found: WorkspaceMap, line: Line, threshold: float
) -> None:
    """Where the robot is stable, and where H_r is near to singular (Figs. 6 and 12)."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure, axes = _new(5.6, 5.0)
    kind = np.where(found.index_locked > 0, 1.0, 0.0)
    kind[found.inverse_condition_number < threshold] = 2.0
    kind[~found.reached] = np.nan
    shades = ("#cfe3f2", "#f6e3b4", "#D55E00")
    axes.pcolormesh(
        *found.grid.values,
        kind.reshape(found.grid.shape).T,
        cmap=ListedColormap(shades),
        vmin=0,
        vmax=2,
        rasterized=True,
    )
    handles: list[Any] = [
        Patch(color=shades[0], label="stable"),
        Patch(color=shades[1], label="unstable"),
        Patch(color=shades[2], label=f"inverse condition number of H_r < {threshold:g}"),
    ]
    for border in found.borders:
        if border.kind in BORDERS and len(border.points):
            colour, label = BORDERS[border.kind]
            segments = list(border.points[border.segments])
            lines = LineCollection(segments, colors=colour, linewidths=1.4, label=label)
            handles.append(axes.add_collection(lines))
    place = np.array(line.places)
    handles += axes.plot(*place.T, "-", color="black", linewidth=1.2, label="path tested")
    axes.plot(*place.T, "o", color="black", markersize=4)
    for number, (x, y) in enumerate(place):
        right = number % 2 == 0  # neighbours are close together
        axes.annotate(
            f"X$_{number + 1}$",
            (x, y),
            (9 if right else -9, 0),
            textcoords="offset points",
            horizontalalignment="left" if right else "right",
            verticalalignment="center",
            bbox={"boxstyle": "round,pad=0.1", "color": "white", "alpha": 0.8},
        )
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(title)
    places = found.grid.places(np.flatnonzero(found.reached))
    margin = 0.04 * np.ptp(places[:, 0])
    axes.set_xlim(places[:, 0].min() - margin, places[:, 0].max() + margin)
    axes.set_ylim(places[:, 1].min() - margin, places[:, 1].max() + margin)
    below = 0.85 / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0.0, below, 1.0, 1.0 - below))
    figure.legend(handles=handles, loc="lower center", ncols=2)
    _save(figure, folder, name)


def draw_line(folder: Path, name: str, title: str, line: Line, shown: int) -> None:
    """Eigenvalues and determinants along a line (Figs. 7 and 13)."""
    figure, (above, below) = _new(6.4, 5.4, nrows=2, sharex=True)
    values = [point.value for point in line.samples]
    for order in range(shown):
        above.plot(
            values,
            [1e3 * point.eigenvalues[order] for point in line.samples],
            color=COLOURS[order],
            linestyle=DASHES[order],
            marker=MARKERS[order],
            markersize=3.5,
            label=f"$\\sigma_{order + 1}$ of H$_r$ (strain modes)",
        )
    above.set_ylabel("eigenvalue [mJ]")
    unit = abs(line.samples[0].at_base)
    below.plot(
        values,
        [point.at_base / unit for point in line.samples],
        color=COLOURS[2],
        marker="^",
        markersize=3.5,
        label="det b$_\\lambda$(0) / its value at X$_1$",
    )
    below.plot(
        values,
        [point.determinants.min() / unit for point in line.samples],
        color=COLOURS[3],
        linestyle="--",
        marker="D",
        markersize=3.5,
        label="min over u of det b$_\\lambda$(u), same unit",
    )
    below.set_yscale("symlog", linthresh=1e-3)
    below.set_ylabel("determinant (continuous rods)")
    below.set_xlabel(f"{line.axis} [m]")
    for axes in (above, below):
        axes.axhline(0.0, color="black", linewidth=0.8)
        for crossing in line.crossings:
            axes.axvline(crossing.eigenvalue, color="grey", linestyle=":", linewidth=1.2)
        axes.grid(alpha=0.3)
        axes.legend()
    for number, point in enumerate(line.marked):
        above.annotate(
            f"X$_{number + 1}$",
            (point.value, 1.0),
            (2, 2),
            xycoords=above.get_xaxis_transform(),
            textcoords="offset points",
            weight="bold",
        )
    if values[0] > values[-1]:
        below.invert_xaxis()
    above.set_title(title, pad=16)
    _save(figure, folder, name)


def draw_determinants(folder: Path, name: str, title: str, line: Line) -> None:
    """Determinants det b(u) along the rods at the points X_i (Figs. 8 and 14)."""
    count = len(line.marked)
    figure, panels = _new(6.4, 1.7 * count + 0.8, nrows=count, sharex=True)
    for number, (axes, point) in enumerate(zip(panels, line.marked, strict=True)):
        unit = np.abs(point.determinants).max()
        axes.plot(point.sections, point.determinants / unit, color=COLOURS[0])
        axes.axhline(0.0, color="black", linewidth=0.8)
        # At a crossing the new conjugate point is at u = 0 up to the truncation of the modes.
        zeros = [u for u in point.conjugate if u > 1e-4]
        border = any(abs(point.value - crossing.eigenvalue) < 1e-12 for crossing in line.crossings)
        zeros = [0.0, *zeros] if border else zeros
        if zeros:
            axes.plot(zeros, np.zeros(len(zeros)), "o", color=COLOURS[1], clip_on=False)
        found = ", ".join(f"u = {u:.3f}" for u in zeros) or "none"
        axes.set_yscale("symlog", linthresh=1e-2)
        axes.set_yticks([-1.0, 0.0, 1.0], ["-1", "0", "1"])
        axes.set_title(
            f"X$_{number + 1}$: {line.axis} = {point.value:.5f} m; conjugate points: {found}",
            fontsize=9,
        )
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("u = s / l")
    figure.supylabel("det b$_\\lambda$(u) / largest (linear up to 0.01, then logarithmic)", size=9)
    figure.suptitle(title)
    _save(figure, folder, name)
