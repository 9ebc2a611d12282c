# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From a rough position to a stable equilibrium with MuJoCo's forces, as if in something viscous.

Every motion is damped alike and time goes on in implicit steps, longer and longer as things come to
rest: in the end Newton's method. Where a branch ends on the way the robot slides to the next stable one,
which Newton's method alone does not find.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .mujoco_statics import LARGEST, SMALL, MujocoRobot, NotBalanced

__all__ = ["settled"]

Floats = NDArray[np.float64]

#: Damping over step of time, in units of the stiffness of a rod: at first, and where it counts as none.
FIRST, NONE = 0.1, 1e-9
#: By how much time steps grow, from motions below this on [rad or m]; by how much they shrink.
GROWTH, CALM, SHRINKAGE = 3.0, 0.1, 4.0
#: Steps that are taken at most, and the most damping that is tried.
MOST, LAST = 400, 1e6


def settled(robot: MujocoRobot, position: Floats, steps: int | None = None) -> Floats:
    """Where the robot comes to rest, or where it is after so many steps of time.

    Args:
        robot: The robot, whose forces go along.
        position: Where it begins.
        steps: How many; None: until it rests.

    Raises:
        NotBalanced: It does not come to rest.
    """
    size, leg = len(robot.free), robot.robot.legs[0].rods[0]
    unit = robot.robot.stiffness * leg.length**2
    damping = FIRST * unit
    for _ in range(MOST if steps is None else steps):
        residual, tangent = robot.linearised(position)
        step, damping = _step(residual, tangent, size, damping, LAST * unit)
        position = robot.moved(position, step[:size])
        robot.forces = robot.forces + step[size:]
        largest = np.abs(step[:size]).max()
        if largest < SMALL and damping < NONE * unit:
            return position
        if largest < CALM:
            damping = damping / GROWTH
    if steps is None:
        raise NotBalanced(f"MuJoCo, {robot.pieces} joints a rod: no rest")
    return position


def _step(
    residual: Floats, tangent: Floats, size: int, damping: float, most: float
) -> tuple[Floats, float]:
    """An implicit step of time, damped so much that it is short and leads downhill; and the damping.

    Raises:
        NotBalanced: None does.
    """
    while damping < most:
        damped = tangent.copy()
        damped[np.arange(size), np.arange(size)] -= damping
        step = np.asarray(-np.linalg.solve(damped, residual), np.float64)
        motion = step[:size]
        curvature = 0.5 * damping * (motion @ motion) - motion @ tangent[:size, :size] @ motion
        largest = np.abs(motion).max()
        if largest < SMALL or (largest < LARGEST and curvature > 0.0):
            return step, damping
        damping = max(SHRINKAGE * damping, 1e-6 * most / LAST)
    raise NotBalanced("MuJoCo: no short step leads downhill")
