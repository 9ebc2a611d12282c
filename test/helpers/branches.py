# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria on other branches than that of home."""

from __future__ import annotations

import numpy as np

from cpr_core import Equilibrium, Robot, find_equilibria, solve_home


def stable_elsewhere(robot: Robot) -> Equilibrium:
    """A stable equilibrium at the motors of home, with the platform in another place."""
    home = solve_home(robot)
    return next(
        found.equilibrium
        for found in find_equilibria(robot, home.motors, starts=200)
        if found.equilibrium.index_locked == 0
        and np.abs(found.equilibrium.platform_position - home.platform_position).max() > 0.05
    )
