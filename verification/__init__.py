# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Other people's programs and published numbers beside ours: ``make verify``, docs/verification.md."""

import os

# Before numpy is imported: times of small matrices would depend on how many cores are free.
os.environ.update(
    dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
)
