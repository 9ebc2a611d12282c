# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The parameters of the node and its arguments: declared, checked, explained."""
