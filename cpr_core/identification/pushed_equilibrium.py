# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The equilibrium next to another one, at other motors and under another wrench, in one call."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..kernels.continuation_kernel import UNPREDICTED
from ..kernels.kernel_arrays import LoadArrays
from ..kernels.natural_units import LONGEST_STEP
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import stepped

__all__ = ["pushed_equilibrium"]

Floats = NDArray[np.float64]

#: Dimensionless residual where rounding lets Newton's method come so far: what is left of the pose is
#: taken for the work of a wrench.
_RESIDUAL = 1e-11


def pushed_equilibrium(
    start: Equilibrium,
    motors: Floats,
    loads: Loads,
    load_arrays: LoadArrays,
    wrench_world: Floats | None,
) -> Equilibrium | None:
    """What Newton's method finds from a start, with the motors where they are measured.

    Limits of motors and strain are not looked at: the robot is where it is.

    Args:
        start: Equilibrium to start from.
        motors: Motor positions, (n,) [rad or m].
        loads: What acts beside the wrench.
        load_arrays: The same as the kernels see it.
        wrench_world: What acts beyond them, (6,) [N m, N]; None: nothing.

    Returns:
        None where its corrections do not contract, or stability would be lost on the way.
    """
    robot = start.robot
    way = (motors - start.motors) / robot.motor_units
    if max(map(abs, way.tolist()), default=0.0) > LONGEST_STEP:
        return None
    if wrench_world is not None:
        loads = replace(loads, wrench_world=loads.wrench_world + wrench_world)
        platform = load_arrays.platform.copy()
        platform["moment_world"][0] += wrench_world[ANGULAR]
        platform["force_world"][0] += wrench_world[LINEAR]
        load_arrays = load_arrays._replace(platform=platform)
    target = robot, loads, load_arrays, "motors", motors[None, :], UNPREDICTED
    found = stepped(start, *target, _RESIDUAL) or stepped(start, *target)
    return None if found is None or found.index_locked > start.index_locked else found
