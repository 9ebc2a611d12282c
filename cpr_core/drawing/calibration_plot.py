# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A picture of a calibration, with matplotlib."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..identification.calibration_result import CalibrationResult
from .path_plots import new_figure, save_figure

__all__ = ["plot_calibration"]

#: Colours that the colour-blind tell apart (Okabe and Ito).
_GREY, _BLUE = "#999999", "#0072B2"


def plot_calibration(found: CalibrationResult, file: Path) -> None:
    """Draw residuals of all rows before and after, parameters with their intervals, correlations.

    Args:
        found: What was found.
        file: Picture to write; its ending tells the format.

    Raises:
        InvalidRequest: No format of pictures.
        OSError: The file cannot be written.
    """
    figure = new_figure((13.0, 8.0))
    places = figure.subplot_mosaic([["rows", "rows"], ["changes", "correlations"]])
    left, right, axes = (places[name] for name in ("rows", "changes", "correlations"))
    pairs = (("before", found.before, _GREY), ("after", found.after, _BLUE))
    for name, equilibria, color in pairs:
        points = [
            (number, value)
            for number, (row, equilibrium) in enumerate(
                zip(found.rows, equilibria, strict=True), start=1
            )
            for value in row.residual(equilibrium)
        ]
        rows, values = np.array(points).T
        left.plot(rows, values, ".", color=color, label=name)
    left.set_yscale("symlog", linthresh=3.0)
    left.set_xlabel("row")
    left.set_title("residuals in standard deviations")
    left.legend(loc="best", fontsize="small")
    left.grid(alpha=0.3)

    size = np.where(found.start == 0.0, 1.0, np.abs(found.start))
    half = 0.5 * np.ptp(found.intervals, axis=1)
    shown = np.isfinite(half)
    count = np.arange(len(found.parameters))
    change = (found.values - found.start) / size
    right.errorbar(change[shown], count[shown], xerr=(half / size)[shown], fmt="o", color=_BLUE)
    right.axvline(0.0, color=_GREY, linewidth=0.8)
    for number in count[~shown]:
        right.text(0.0, number, " not determined", va="center", fontsize="small")
    names = [f"{name}  {number}" for number, name in enumerate(found.parameters, start=1)]
    right.set_yticks(count, names, fontsize="small")
    right.set_ylim(len(count) - 0.5, -0.5)  # from the top, as beside it
    right.set_title("change, relative (of zeros: in SI units), and interval of 95 %")
    right.grid(alpha=0.3)

    picture = axes.imshow(found.correlations, vmin=-1.0, vmax=1.0, cmap="RdBu")
    axes.set_xticks(count, count + 1)
    axes.set_yticks(count, count + 1)
    axes.set_title("correlations (grey: not determined)")
    axes.set_facecolor("0.8")
    figure.colorbar(picture, ax=axes)
    figure.suptitle(f"{found.robot.description.name}: {len(found.rows)} rows, fit {found.fit:.2f}")
    save_figure(figure, file)
