# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Compiled mechanics: plain arrays in, plain arrays out; knows no robot, only its numbers."""
