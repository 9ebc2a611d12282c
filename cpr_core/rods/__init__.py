# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One elastic rod: section, material, strain modes and the quadrature along it."""
