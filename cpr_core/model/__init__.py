# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot ready to be solved, and what one equilibrium tells: stability, kinemato-statics, shape."""
