# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How fast everything is: ``make bench``, described in docs/performance.md."""

import os

__all__ = ["THREAD_VARIABLES"]

#: Variables that tell BLAS how many threads to use.
THREAD_VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")

# Before numpy is imported: times of small matrices would depend on how many cores are free.
os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
