# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot as its author wrote it: file, legs, motors, tip joints and loads, checked."""
