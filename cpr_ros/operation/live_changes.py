# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What new live parameters change of a robot in operation; they start no motion. No rclpy here."""

from __future__ import annotations

from cpr_msgs.msg import ErrorCode

from ..closed_loop.loop_status import Loop
from ..following.supervision import State
from ..settings.node_settings import LiveParameters
from .session import Session

__all__ = ["apply_live"]


def apply_live(session: Session, live: LiveParameters, now: float) -> bool:
    """Take new live parameters.

    Args:
        session: The robot in operation.
        live: The parameters.
        now: Steady time [s].

    Returns:
        Whether a setpoint was forgotten.
    """
    other_wrench = live.wrench_timeout != session.wrench.watchdog.timeout
    forgotten = _would_move(session, live, now)
    if forgotten:
        session.orders.end(ErrorCode.PREEMPTED, "parameters changed: the setpoint is forgotten")
    session.follower.settings = live.settings
    session.solver.time_limit = live.time_limit
    session.wrench.watchdog.timeout = live.wrench_timeout
    outcome = session.present.outcome
    if other_wrench and outcome.state == State.ALIGNING and outcome.refusal:
        session.orders.pause(True)  # commands that the wrench holds back would go out without it
        forgotten = True
    if session.loop.beyond(live.loop):
        session.loop.forget()  # the robot holds where that has led it
    session.loop.settings = live.loop
    session.jogger.watchdog.timeout = live.twist_timeout
    session.felt.settings = live.felt_wrench
    held = session.moved_by_others.in_question
    session.moved_by_others.tolerance = live.moved_tolerance
    if held and not session.moved_by_others.in_question:
        session.commands.repeatable = False  # else saying it again would move the motors
        session.orders.hold_commands()
    if session.outgoing.waits:
        session.orders.hold_commands()  # on their way to where the robot was put
    session.measured.watchdog.timeout = live.measured_timeout
    session.commands.max_lead, session.commands.tolerance = live.max_lead, live.moved_tolerance
    if session.tracking is not None:
        session.tracking.watchdog.timeout = live.measured_timeout
        session.tracking.at_rest = False
    return forgotten


def _would_move(session: Session, live: LiveParameters, now: float) -> bool:
    """Whether parameters would set a robot off to where it was sent.

    One that is held back would, where a threshold or a timeout lets it; a frozen correction and an old
    twist are of the kind. So would one at its goal if a wrench is given another time: motors hold a pose
    against the wrench.
    """
    follower, current = session.follower, session.solver.current.equilibrium
    if follower.goal is None:
        return False
    held_back = (
        session.present.outcome.state in (State.HALTED, State.STALE)
        or follower.stale(now)
        or session.outgoing.waits
    )
    if held_back or session.loop.beyond(live.loop):
        return True
    if live.twist_timeout != session.jogger.watchdog.timeout and session.jogger.drives(
        follower.goal
    ):
        return True
    other_wrench = live.wrench_timeout != session.wrench.watchdog.timeout
    thawed = live.loop != session.loop.settings and session.loop_status(now).loop == Loop.FROZEN
    return (other_wrench or thawed) and follower.arrived(current)
