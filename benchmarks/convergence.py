# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Draw the error of the platform position over the number of modes, for the robots that are measured."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

from cpr_core import load_robot, solve_forward, solve_home

from .walks import ROBOTS

mpl.use("Agg")
import matplotlib.pyplot as plt

FIGURE = Path(__file__).parents[1] / "docs" / "images" / "convergence.png"
MODES = range(2, 13)
STEP = 0.05  # every second motor is moved by this, rad; a rod length by a tenth of it


def position(name: str, modes: int) -> np.ndarray:
    """Platform position of one configuration off home."""
    robot = load_robot(name, modes=modes)
    units = np.array([motor.unit == "rad" for motor in robot.description.motors])
    step = STEP * np.where(units, 1.0, 0.1) * (np.arange(robot.motor_count) % 2)
    return solve_forward(robot, solve_home(robot).motors + step).platform_position


def main() -> None:
    """Write the figure."""
    figure, axes = plt.subplots(figsize=(6.5, 4.0))
    for marker, name in zip("osv^DP", ROBOTS, strict=True):
        exact = position(name, 14)
        errors = [float(np.linalg.norm(position(name, modes) - exact)) for modes in MODES]
        axes.semilogy(MODES, np.maximum(errors, 1e-16), marker=marker, label=name)
    axes.set_xlabel("modes per bending direction")
    axes.set_ylabel("error of the platform position [m]")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(FIGURE, dpi=120, bbox_inches="tight")


if __name__ == "__main__":
    main()
