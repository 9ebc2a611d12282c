# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Topics that setpoints come in by: the node hears them, its page tells who else publishes there."""

from __future__ import annotations

__all__ = [
    "COMMANDS",
    "JOINT_TRAJECTORY",
    "MOTOR_SETPOINT",
    "PLATFORM_SETPOINT",
    "PLATFORM_TWIST",
    "SETPOINTS",
]

MOTOR_SETPOINT = "motor_setpoint"
COMMANDS = "commands"
PLATFORM_SETPOINT = "platform_setpoint"
PLATFORM_TWIST = "platform_twist"
JOINT_TRAJECTORY = "joint_trajectory"

#: All of them, below the name of the node.
SETPOINTS = (MOTOR_SETPOINT, COMMANDS, PLATFORM_SETPOINT, PLATFORM_TWIST, JOINT_TRAJECTORY)
