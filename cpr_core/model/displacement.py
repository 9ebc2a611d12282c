# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a robot is after a finite change of its state coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.square_problem import Configuration
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..lie import rotation_exp
from .platform_coordinates import six_components
from .robot import Robot

__all__ = ["displaced"]

Floats = NDArray[np.float64]


def displaced(
    robot: Robot,
    state: Floats,
    platform_rotation: Floats,
    platform_position: Floats,
    change: Floats,
) -> Configuration:
    """A configuration after a change of the state coordinates.

    What the change has in place of the platform is a twist in the world: the platform is turned by the
    exponential of its angular part about its own origin, and moved by its linear part.

    Args:
        robot: The robot.
        state: Before, (N,).
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,) [m].
        change: In state order and units, (N,).
    """
    twist = six_components(robot.platform_axes, change[robot.platform_indices])
    change = change.copy()
    change[robot.platform_indices] = 0.0
    turned = rotation_exp(twist[ANGULAR]) @ platform_rotation
    return Configuration(state + change, turned, platform_position + twist[LINEAR])
