# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the robot is when a motion ends, as results of actions tell it."""

from __future__ import annotations

import traceback

from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from rclpy.node import Node

from ..messages.equilibrium_messages import fill_equilibrium, no_equilibrium
from ..messages.frames import Frames
from ..operation.session import Session

__all__ = ["reached"]


def reached(node: Node, session: Session | None, frames: Frames) -> EquilibriumMessage:
    """The current equilibrium; cannot raise: there is a result, whatever happens.

    Args:
        node: The node.
        session: The robot in operation; None while the node is not active.
        frames: Names of the frames.
    """
    message = no_equilibrium()
    if session is None:
        return message
    current = session.solver.current
    stamp = node.get_clock().now().to_msg()
    try:
        fill_equilibrium(
            message, current.equilibrium, frames, stamp, current.solve_time, eigenvalues=True
        )
    except Exception:
        node.get_logger().error(traceback.format_exc())
    return message
