# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Ways from Python into kernels that only kernels call."""

import numba


def entry(kernel):
    """What calls a kernel: without, Python would crash."""

    @numba.njit
    def call(*arguments):
        return kernel(*arguments)

    return call
