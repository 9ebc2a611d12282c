# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Setpoints met in the measured pose of the platform, and twists that move them. No rclpy here."""
