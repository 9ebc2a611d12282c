# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A motor step off home for every shipped robot, far enough to leave its symmetry."""

STEPS = {
    "gough_stewart": [0.01, -0.005, 0.0, 0.015, 0.0, 0.01],
    "planar_body": [0.1, -0.05, 0.05],
    "rfrfr": [0.1, -0.1],
    "six_rfs": [0.2, -0.1, 0.15, 0.1, -0.2, 0.05],
    "three_rfs": [0.1, -0.05, 0.05],
}
