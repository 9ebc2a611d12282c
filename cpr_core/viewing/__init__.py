# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot to look at and to move: a page in the browser. Only what draws the page imports viser."""
