# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The shipped robots: whose legs are chains, and a motor step off home that leaves its symmetry."""

#: Legs of a motor and a rod. What takes long is tried on these, and on the chains that tell more.
SHORT_FORM = ("gough_stewart", "planar_body", "rfrfr", "six_rfs", "three_rfs")
CHAINS = ("delta", "four_rfr", "six_rus", "three_prs", "three_rfr_hubs", "two_rods")
#: More motors than platform coordinates: a pose does not say where the motors are.
REDUNDANT = ("four_rfr",)
STEPS = {
    "delta": [0.1, -0.05, 0.08],
    "four_rfr": [0.1, -0.05, 0.05, 0.08],
    "gough_stewart": [0.01, -0.005, 0.0, 0.015, 0.0, 0.01],
    "planar_body": [0.1, -0.05, 0.05],
    "rfrfr": [0.1, -0.1],
    "six_rfs": [0.2, -0.1, 0.15, 0.1, -0.2, 0.05],
    "six_rus": [0.1, -0.05, 0.08, 0.05, -0.1, 0.03],
    "three_prs": [0.01, -0.005, 0.015],
    "three_rfr_hubs": [0.1, -0.05, 0.05],
    "three_rfs": [0.1, -0.05, 0.05],
    "two_rods": [0.1, -0.05],
}
