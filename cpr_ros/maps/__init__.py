# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps of the workspace, made by another process for whoever orders them."""
