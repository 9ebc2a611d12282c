#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Draws every shipped robot at home, with the frames at its bases: docs/images/robots/*.png."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image

from cpr_core import load_robot, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.drawing.robot_drawing import draw_equilibrium, set_equal_scale

FOLDER = Path(__file__).parents[1] / "docs/images/robots"


def main(folder: Path = FOLDER) -> None:
    """One picture a robot."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in shipped_robots():
        home = solve_home(load_robot(name))
        planar = home.robot.planar
        figure = Figure(figsize=(4.4, 4.0), dpi=110, layout="constrained")
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_subplot(projection=None if planar else "3d")
        draw_equilibrium(axes, home, color="#0072B2", frame_size=0.12 * home.robot.mean_length)
        set_equal_scale(axes)
        axes.grid(alpha=0.3)
        for axis in (axes.xaxis, axes.yaxis, *(() if planar else (axes.zaxis,))):
            axis.set_major_locator(MaxNLocator(4 if planar else 3))
        if not planar:
            axes.view_init(elev=22.0, azim=-52.0)
            axes.set_box_aspect(np.ptp(np.reshape(axes.get_w_lims(), (3, 2)), axis=1), zoom=0.78)
        for _ in range(2):  # the layout of the first drawing changes the ticks
            canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        picture.quantize(128, dither=Image.Dither.NONE).save(folder / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
