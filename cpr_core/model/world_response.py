# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How platform and efforts answer to wrench and motors, in world axes, without any eigenvalue.

The same as `kinemato_statics` tells, for who asks at every sample: there the smallest eigenvalues, which
are found along with it, take most of the time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..kernels.kept_factors import border_of
from ..validation import ReadOnlyArrays
from .dense_response import platform_turn
from .equilibrium import Equilibrium
from .kinemato_statics import kinemato_statics
from .robot import Robot, kept_with_robot

__all__ = ["WorldResponse", "effort_units", "twist_units", "world_response", "wrench_units"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WorldResponse(ReadOnlyArrays):
    """First-order behaviour at an equilibrium; b platform coordinates.

    In natural units: radians and mean rod lengths, motors in their own, energies in E J / l. So moments
    count in E J / l and forces in E J / l^2. Twists and wrenches are those of the platform origin.

    Attributes:
        equilibrium: Where.
        twist_by_wrench: World twist, motors held, (b, b).
        efforts_by_wrench: Motors held, (n, b).
        twist_by_motors: World twist at constant loads, (b, n).
        efforts_by_motors: At constant loads, (n, n).
    """

    equilibrium: Equilibrium
    twist_by_wrench: Floats
    efforts_by_wrench: Floats
    twist_by_motors: Floats
    efforts_by_motors: Floats

    def by_way(self, way: Floats) -> tuple[Floats, Floats]:
        """Efforts, (n,), and twist, (b,), of a way of the motors, (n,), at constant loads."""
        return self.efforts_by_motors @ way, self.twist_by_motors @ way


@kept_with_robot
def wrench_units(robot: Robot) -> Floats:
    """Natural units of a wrench on the platform, (b,) [N m, N]."""
    return robot.wrench_units[robot.platform_axes]


@kept_with_robot
def effort_units(robot: Robot) -> Floats:
    """Natural units of motor efforts, (n,) [N m or N]."""
    return robot.kernel_arrays.energy_unit / robot.motor_units


@kept_with_robot
def twist_units(robot: Robot) -> Floats:
    """Natural units of the platform coordinates, (b,) [rad, m]."""
    return robot.kernel_arrays.unit[robot.platform_indices]


def world_response(equilibrium: Equilibrium) -> WorldResponse:
    """First-order behaviour, from what the legs leave of platform and motors.

    Where they cannot be condensed from `kinemato_statics`, which takes milliseconds.
    """
    border = border_of(equilibrium.robot.kernel_arrays, equilibrium.factors)
    if border is None:
        return _dense(equilibrium)
    size = len(equilibrium.robot.platform_axes)
    coupling = border[size:, :size]
    inverse, failed = scipy.linalg.lapack.dgesv(border[:size, :size], np.eye(size))[2:]
    if failed:
        return _dense(equilibrium)
    efforts = coupling @ inverse
    return WorldResponse(
        equilibrium=equilibrium,
        twist_by_wrench=inverse,
        efforts_by_wrench=efforts,
        twist_by_motors=-inverse @ coupling.T,
        efforts_by_motors=border[size:, size:] - efforts @ coupling.T,
    )


def _dense(equilibrium: Equilibrium) -> WorldResponse:
    """The same from `kinemato_statics`, turned to the world.

    Nothing is inverted: a rigid leg may leave the platform no way to move with the motors held.
    """
    robot, model = equilibrium.robot, kinemato_statics(equilibrium)
    energy = robot.kernel_arrays.energy_unit
    turn = platform_turn(equilibrium)
    lengths, motors = twist_units(robot), robot.motor_units
    # Of natural wrenches, and to natural twists.
    pushed, moved = turn.T * (energy / lengths), turn / lengths[:, None]
    return WorldResponse(
        equilibrium=equilibrium,
        twist_by_wrench=moved @ model.platform_by_wrench @ pushed,
        efforts_by_wrench=motors[:, None] / energy * (model.efforts_by_wrench @ pushed),
        twist_by_motors=moved @ model.jacobian * motors,
        efforts_by_motors=motors[:, None] / energy * model.efforts_by_motors * motors,
    )
