# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is said of numbers that look like those of other units."""

MILLIMETRES, DEGREES = "looks like millimetres, expected metres", "looks like degrees"
