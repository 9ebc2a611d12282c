# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A program that compiles, beside `cpr compile`, what that comes to last or not at all.

Two processes share the work by the order in which they begin: `cpr compile` with the model and the paths
along it, this one with what needs neither. When it comes to maps, the model lies on disk. None of these
calls computes anything that is looked at.
"""

from __future__ import annotations

import numpy as np

from cpr_core import load_robot
from cpr_core.kernels.condensation_kernel import UNKNOWN
from cpr_core.kernels.kept_factors import kept_factors
from cpr_core.kernels.linearisation_kernel import linearise
from cpr_core.model.equilibrium_records import new_record
from cpr_core.reference.continuous_rods import follow_motors
from cpr_core.reference.rod_integration import integrate
from cpr_core.workspace import pose_grid
from cpr_core.workspace.batch_kernel import Cells, Ways
from cpr_core.workspace.batches import analyses_and_arrivals, no_guesses
from cpr_core.workspace.cell_layout import SIGN_COUNT
from cpr_core.workspace.cell_problem import cell_problem
from helpers.rough_homes import continuous_home


def main() -> None:
    """Compile them."""
    robot = load_robot("rfrfr")
    linearise_nothing(robot)
    shoot(robot)
    map_nothing(robot)


def linearise_nothing(robot) -> None:
    """Linearise where no tangent was kept."""
    factors = kept_factors(robot.kernel_arrays)
    factors["lane"] = UNKNOWN
    record = np.zeros_like(new_record(robot))
    size = len(robot.kernel_arrays.border_indices)
    eigenvalues, matrix = np.empty(3), np.empty((size, size))
    known, _ = linearise(robot.prepared, factors, record, True, False, eigenvalues, matrix)
    assert not known


def shoot(robot) -> None:
    """The compiled rods of the reference."""
    found = continuous_home(robot)
    follow_motors(found, [found.motors])
    integrate((np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)), 1.0, np.ones(3), np.zeros(3))


def map_nothing(robot) -> None:
    """A map's kernels on no cell."""
    grid = pose_grid(robot, {"x": [0.0, 0.1], "y": [0.0, 0.1]}, resolution=0.1)
    size, none, numbers = robot.state_size, np.empty(0), np.empty(0, np.int64)
    coordinates = np.empty((0, len(grid.names)))
    cells = Cells(
        coordinates,
        np.empty((0, size)),
        np.empty((0, 3, 3)),
        np.empty((0, 3)),
        np.empty((0, SIGN_COUNT), np.int64),
    )
    ways = Ways(numbers, coordinates, none, none, no_guesses(0, size))
    analyses_and_arrivals(cell_problem(robot, robot.default_loads, grid), cells, ways)


if __name__ == "__main__":
    main()
