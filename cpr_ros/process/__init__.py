# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Of the process of a node: signals, its ROS domain, its log, what is due when."""
