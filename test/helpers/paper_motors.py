# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the motors of the paper's robots are at home."""

HOME = {"rfrfr": [2.59, 0.55], "six_rfs": [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]}
