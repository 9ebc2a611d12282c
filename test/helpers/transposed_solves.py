# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Solves with the transposed Newton matrix alone."""

import numpy as np

from cpr_core.kernels import linear_problem_kernel
from helpers.kernel_entry import entry

solve_with_efforts_transposed = entry(linear_problem_kernel.solve_with_efforts_transposed)


def solve_transposed(arrays, square, vector, work, factors):
    """Without a right side of the efforts nothing but the Newton matrix is left."""
    motors = len(arrays.unit) - arrays.motor_index
    whole = np.append(vector, np.zeros(motors))
    solve_with_efforts_transposed(arrays, square, whole, work, factors)
    vector[:] = whole[: len(vector)]
