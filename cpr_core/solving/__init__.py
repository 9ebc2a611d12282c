# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one equilibrium to others: requests, branches, home, all equilibria, critical loads."""
