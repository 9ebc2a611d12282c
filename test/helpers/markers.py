# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The markers of a robot after a tick."""

from builtin_interfaces.msg import Time

from cpr_core.drawing.robot_lines import equilibrium_lines
from cpr_ros.messages.frames import Frames
from cpr_ros.messages.leg_markers import leg_markers, leg_width


def markers_of(outcome, by):
    """As the node publishes them, in frames ``base`` and ``platform``."""
    frames = Frames("base", "platform")
    width = leg_width(outcome.assessment.equilibrium.robot)
    lines = equilibrium_lines(outcome.assessment.equilibrium)
    return leg_markers(lines, width, outcome.verdict.action, by, frames, Time())
