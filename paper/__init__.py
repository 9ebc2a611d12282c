# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Section VI of the paper, reproduced: every table and every figure, computed and compared."""

import os

# Times are those of one core; this has to be known before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
