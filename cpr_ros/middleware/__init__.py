# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What rclpy and DDS leave to be done by a node."""
