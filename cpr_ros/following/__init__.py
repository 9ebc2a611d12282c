# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot is sent, and how it gets there without harm. No rclpy here."""
