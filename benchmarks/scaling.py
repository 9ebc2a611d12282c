# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Cost against the number of legs, of quadrature nodes and of modes; a plot of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from cpr_core import Robot, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.model_state import evaluate

from .measure import Case, Figure

__all__ = ["AXES", "draw", "exponents", "scaling_cases"]

#: What is varied, and over what.
AXES = {
    "legs": (3, 4, 6, 8, 12, 16, 24),
    "nodes": (16, 32, 48, 64, 96, 128),
    "modes": (2, 3, 4, 5, 6, 8, 10, 12),
}
MEASURES = ("forward solve", "residual and tangent")
#: Largest exponent of the cost, where the requirement is linear or quadratic.
LIMITS = {"legs": 1, "nodes": 1, "modes": 2}
STEP, STEPS = 0.02, 10


def scaling_cases(quick: bool = False) -> Iterator[Case]:
    """Small forward steps and evaluations of robots like the 6-RFS one."""
    for axis, numbers in AXES.items():
        for number in numbers[:: 3 if quick else 1]:
            robot = _robot(axis, number)
            key = f"{axis}/{number}"
            yield Case(f"scaling, forward solve/{key}", partial(_walk, robot), STEPS)
            home = solve_home(robot)
            evaluation = partial(
                evaluate,
                robot,
                home.load_arrays,
                home.state,
                home.platform_rotation,
                home.platform_position,
            )
            yield Case(f"scaling, residual and tangent/{key}", evaluation)


def exponents(figures: dict[str, Figure]) -> dict[str, float]:
    """Exponent of the cost by axis and measure, by least squares over the upper half of the numbers."""
    found = {}
    for axis in AXES:
        for measure in MEASURES:
            numbers, seconds = _curve(figures, axis, measure)
            upper = len(numbers) // 2 if len(numbers) > 3 else 0
            slope = np.polyfit(np.log(numbers[upper:]), np.log(seconds[upper:]), 1)[0]
            found[f"{axis}/{measure}"] = float(slope)
    return found


def draw(figures: dict[str, Figure], file: Path) -> None:
    """Cost against everything that is varied, both axes logarithmic."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Picture

    picture = Picture(figsize=(11.0, 3.8), layout="constrained")
    FigureCanvasAgg(picture)
    slopes = exponents(figures)
    for axes, (axis, power) in zip(picture.subplots(1, 3), LIMITS.items(), strict=True):
        for measure, style in zip(MEASURES, ("o-", "s-"), strict=True):
            numbers, seconds = _curve(figures, axis, measure)
            slope = slopes[f"{axis}/{measure}"]
            axes.loglog(numbers, 1e3 * seconds, style, label=f"{measure}, exponent {slope:.2f}")
        guide = 1e3 * seconds[-1] * (numbers / numbers[-1]) ** power
        axes.loglog(numbers, guide, "k:", lw=1.0, label={1: "linear", 2: "quadratic"}[power])
        axes.set_xticks(numbers, [str(number) for number in numbers.tolist()])
        axes.minorticks_off()
        axes.set_xlabel(axis)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    picture.axes[0].set_ylabel("time [ms]")
    picture.savefig(file, dpi=120)


def _curve(figures: dict[str, Figure], axis: str, measure: str) -> tuple[np.ndarray, np.ndarray]:
    keys = [(number, f"scaling, {measure}/{axis}/{number}") for number in AXES[axis]]
    found = [(number, figures[key].median) for number, key in keys if key in figures]
    numbers, seconds = np.array(found).T
    return numbers.astype(int), seconds


def _walk(robot: Robot) -> None:
    last = solve_home(robot)
    for step in range(1, STEPS + 1):
        last = solve_forward(robot, solve_home(robot).motors + STEP * step / STEPS, start=last)


def _robot(axis: str, number: int) -> Robot:
    content = yaml.safe_load(shipped_robots()["six_rfs"].read_text().replace("e9 ", ".0e+9 "))
    if axis == "modes":
        return load_robot(content, modes=number)
    if axis == "legs":
        content |= _legs(number)
        return load_robot(content)
    nodes = len(load_robot(content).grid.nodes)
    # Stations cut the rods into panels, every one with as many nodes as a whole rod has without.
    panels = round(number / nodes)
    content["stations"] = (np.arange(1, panels) / panels).tolist()
    return load_robot(content)


def _legs(count: int) -> dict[str, Any]:
    """So many legs evenly around a circle, their motors as at the home of the 6-RFS robot."""
    legs: list[dict[str, Any]] = []
    for turn in (2.0 * np.pi * np.arange(count) / count).tolist():
        radial: Sequence[float] = (float(np.cos(turn)), float(np.sin(turn)), 0.0)
        across = turn + (0.5 if len(legs) % 2 else -0.5)
        legs.append(
            {
                "base": {"position": [0.25 * part for part in radial], "tangent": [*radial]},
                "motor": {"type": "revolute", "axis": [-radial[1], radial[0], 0.0]},
                "tip": {
                    "type": "spherical",
                    "position": [0.1 * float(np.cos(across)), 0.1 * float(np.sin(across)), 0.0],
                },
            }
        )
    home = {"motors": [5.6] * count, "bow": "outward"}
    controlled = {3: ["x", "y", "z"], 4: ["x", "y", "z", "yaw"], 6: ["x", "y", "z", "orientation"]}
    return {"legs": legs, "controlled": controlled.get(count, []), "home": home}
