# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cpr_node in which all that a tick has to do besides its motor command fails."""

from cpr_ros import node
from cpr_ros.closed_loop.pose_loop import PoseLoop
from cpr_ros.interface.outputs import Outputs
from cpr_ros.interface.state_output import StateOutput
from cpr_ros.node_run import run
from cpr_ros.operation.announcements import Announcements


def fail(*_arguments, **_options):
    raise ArithmeticError("forced by a test")


PoseLoop.note = fail
Announcements.after_tick = fail
StateOutput.step = fail
# A command that was late would be said after all.
Outputs._repeat_commands = lambda self, session, now: None

if __name__ == "__main__":
    run(node.CprNode)
