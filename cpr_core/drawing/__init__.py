# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots, paths and maps drawn with matplotlib; imported only by who draws."""
