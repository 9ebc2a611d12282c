# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The stability index by another way than elimination."""

import numpy as np


def index_by_eigenvalues(equilibrium):
    """Index with the motors locked from all eigenvalues of the bordered Hessian."""
    robot, tangent = equilibrium.robot, equilibrium.tangent
    scaled = (
        tangent
        * robot.kernel_arrays.unit[:, None]
        * robot.kernel_arrays.unit
        / robot.kernel_arrays.energy_unit
    )
    bordered = (
        0.5
        * (scaled + scaled.T)[: robot.kernel_arrays.motor_index, : robot.kernel_arrays.motor_index]
    )
    values = np.linalg.eigvalsh(bordered)
    negative = int(np.sum(values < -1e-11 * np.abs(values).max()))
    return negative - len(robot.multiplier_indices)
