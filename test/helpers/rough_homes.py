# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rough homes of the paper's robots, for solvers that start without strain modes."""

import numpy as np

from cpr_core.lie import rotation_from_quaternion
from cpr_core.reference.continuous_rods import solve_continuous_rough

_TURN = np.array([0.9434, -0.0406, -0.0496, 0.3255])
ROUGH = {
    "rfrfr": ([[0, 0, -2], [0, 0, 2]], [0.0, 0.84, 0.0], np.eye(3)),
    "six_rfs": (
        [[0, -2, 0]] * 6,
        [0.036, 0.013, 0.845],
        rotation_from_quaternion(_TURN / np.linalg.norm(_TURN)),
    ),
}


def continuous_home(robot, **options):
    """The home of a robot of continuous rods."""
    rough = ROUGH[robot.description.name]
    return solve_continuous_rough(robot, robot.description.home.motors, *rough, **options)
