# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Health of the node for /diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from cpr_core.model.assessment import crossed_thresholds

from ..following.supervision import Action, slowed_where_unseen
from ..messages.model_error import estimated_error, warned_error
from ..operation.session import Session

__all__ = ["NodeHealth", "diagnostic_array", "wrench_status"]

_LEVELS = {
    Action.NONE: DiagnosticStatus.OK,
    Action.SLOW: DiagnosticStatus.WARN,
    Action.HALT: DiagnosticStatus.ERROR,
}


@dataclass(frozen=True)
class NodeHealth:
    """How the node gets on.

    Attributes:
        life: State of the life cycle.
        dropped: Number of dropped messages by topic.
        newly_dropped: Those of them since the last diagnostics.
        late_ticks: Ticks that came more than a period late.
        commanders: Who else commands the motors, in words; empty: nobody.
    """

    life: str
    dropped: Mapping[str, int]
    newly_dropped: Mapping[str, int]
    late_ticks: int
    commanders: str

    def status(self, name: str, *, active: bool) -> DiagnosticStatus:
        """The entry of a node with a full name, which may not be active."""
        level = DiagnosticStatus.OK if active else DiagnosticStatus.STALE
        newly = sorted(self.newly_dropped.items())
        counts = ", ".join(f"{count} of {topic}" for topic, count in newly)
        lost = f"messages dropped since the last diagnostics: {counts}" if counts else ""
        warnings = [warning for warning in (lost, self.commanders) if warning]
        dropped = {f"dropped {topic}": count for topic, count in sorted(self.dropped.items())}
        return DiagnosticStatus(
            level=max(level, DiagnosticStatus.WARN) if warnings else level,
            name=f"{name}: node",
            message="; ".join((self.life, *warnings)),
            values=_values({"life cycle": self.life, "late ticks": self.late_ticks, **dropped}),
        )


def diagnostic_array(
    name: str, health: NodeHealth, session: Session | None, unseen: str, stamp: Time
) -> DiagnosticArray:
    """How the node gets on, and how stable the robot in operation is; one entry each.

    Args:
        name: Full name of the node.
        health: Of the node.
        session: The robot in operation; None while the node is not active.
        unseen: What is not measured of it, in words; empty: nothing is missing.
        stamp: ROS time of the message.
    """
    entries = [health.status(name, active=session is not None)]
    if session is not None:
        entries.append(_stability_status(name, session, unseen))
    return DiagnosticArray(header=Header(stamp=stamp), status=entries)


def _stability_status(name: str, session: Session, unseen: str) -> DiagnosticStatus:
    """How stable the robot in operation is."""
    outcome = session.present.outcome
    told = slowed_where_unseen(outcome.verdict, unseen)
    crossed = crossed_thresholds(session.follower.settings.thresholds)
    level = _LEVELS[told.action]
    equilibrium = outcome.assessment.equilibrium
    error, warned = estimated_error(equilibrium), warned_error(equilibrium)
    inexact = f"{error:.1e} m, more than half of strain.tolerance" if error > warned else ""
    return DiagnosticStatus(
        level=max(level, DiagnosticStatus.WARN) if crossed or inexact else level,
        name=f"{name}: stability",
        message=told.text,
        hardware_id=session.robot.description.name,
        values=_values(
            {
                "state": outcome.state.name,
                "status": told.status.name,
                "action": told.action.name,
                "speed scale": f"{told.speed_scale:.3f}",
                "margin": f"{outcome.assessment.margin:.6g}",
                "index, motors held": outcome.assessment.index,
                "nearest threshold": told.nearest or "none",
                "solve time [ms]": f"{1e3 * outcome.assessment.solve_time:.3f}",
                "model error": inexact or f"{error:.1e} m",
                **({"thresholds": "; ".join(crossed)} if crossed else {}),
            }
        ),
    )


def wrench_status(name: str, session: Session, now: float) -> DiagnosticStatus:
    """Whether the wrench on the platform is estimated; a warning with the reason where it is not.

    Args:
        name: Full name of the node.
        session: The robot in operation.
        now: Steady time [s].
    """
    reason = session.felt.reason(now)
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN if reason else DiagnosticStatus.OK,
        name=f"{name}: wrench",
        message=f"no wrench is estimated: {reason}" if reason else "the wrench is estimated",
        hardware_id=session.robot.description.name,
        values=_values({"reason": reason or "none", "with pose": session.felt.with_pose}),
    )


def _values(values: Mapping[str, object]) -> list[KeyValue]:
    return [KeyValue(key=key, value=str(value)) for key, value in values.items()]
