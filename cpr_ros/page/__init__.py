# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a running node, which knows it by its topics alone."""
