# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a supervisor is told: status, action and speed scale, from the measures of an equilibrium."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from enum import IntEnum

from cpr_core.errors import distinct
from cpr_core.model.assessment import MEASURES, Assessment, Threshold, Thresholds

__all__ = [
    "BLIND",
    "FIELDS",
    "Action",
    "Refusal",
    "State",
    "Status",
    "Verdict",
    "below_warnings",
    "next_action",
    "slowed_where_unseen",
    "verdict",
]


class Status(IntEnum):
    """STATUS constants of cpr_msgs/StabilityMetrics."""

    INVALID = -1
    NO_WARNING = 0
    DECELERATE_FOR_APPROACHING_SINGULARITY = 1
    HALT_FOR_SINGULARITY = 2
    DECELERATE_FOR_LEAVING_SINGULARITY = 3
    JOINT_BOUND = 6
    STALE_COMMAND = 7
    DECELERATE_FOR_STABILITY = 8
    HALT_FOR_STABILITY = 9
    NOT_CONVERGED = 10
    BRANCH_JUMP = 11
    STRAIN_BOUND = 12


class Action(IntEnum):
    """ACTION constants of cpr_msgs/StabilityMetrics."""

    NONE = 0
    SLOW = 1
    HALT = 2


class State(IntEnum):
    """STATE constants of cpr_msgs/StabilityMetrics."""

    IDLE = 0
    FOLLOWING = 1
    RETURNING = 2
    HALTED = 3
    STALE = 4
    PAUSED = 5
    TRACKING = 6
    LOST = 7
    ALIGNING = 8


#: Statuses of the warning and of the halt of every measure.
_STATUSES = {
    "margin": (Status.DECELERATE_FOR_STABILITY, Status.HALT_FOR_STABILITY),
    "forward_singularity": (
        Status.DECELERATE_FOR_APPROACHING_SINGULARITY,
        Status.HALT_FOR_SINGULARITY,
    ),
    "inverse_singularity": (
        Status.DECELERATE_FOR_APPROACHING_SINGULARITY,
        Status.HALT_FOR_SINGULARITY,
    ),
    "motor_range": (Status.JOINT_BOUND, Status.JOINT_BOUND),
    "effort_reserve": (Status.JOINT_BOUND, Status.JOINT_BOUND),
    "strain_reserve": (Status.STRAIN_BOUND, Status.STRAIN_BOUND),
}
#: Statuses of what has no threshold.
_OTHER = {
    "not_converged": Status.NOT_CONVERGED,
    "branch_jump": Status.BRANCH_JUMP,
    "stale": Status.STALE_COMMAND,
}
#: Where the value of a measure is in cpr_msgs/StabilityMetrics.
FIELDS = {name: name for name in MEASURES} | {
    "forward_singularity": "forward.smallest_singular_value",
    "inverse_singularity": "inverse.smallest_singular_value",
}


#: Factor on speed where something is to be measured and is not.
BLIND = 0.5


@dataclass(frozen=True)
class Refusal:
    """Why the robot may not be moved on, or what it cannot bear.

    Attributes:
        reason: A measure, ``not_converged``, ``branch_jump`` or ``stale``.
        text: For a person.
    """

    reason: str
    text: str


@dataclass(frozen=True)
class Verdict:
    """What a supervisor is told.

    Attributes:
        status: Status code.
        text: For a person.
        action: What to do.
        speed_scale: Recommended factor on speed, in [0, 1].
        nearest: Measure nearest to its stop threshold; empty if nothing limits.
        distance: Its level: 1 at the warning, 0 at the stop.
    """

    status: Status
    text: str
    action: Action
    speed_scale: float
    nearest: str
    distance: float


def slowed_where_unseen(told: Verdict, unseen: str) -> Verdict:
    """What is told of a robot that may be elsewhere, not measured or held there: to be slow at least.

    Args:
        told: Of what the model knows.
        unseen: What is not measured, or where it is, in words; empty: nothing is missing.
    """
    if not unseen or told.action == Action.HALT:
        return told
    if told.action == Action.SLOW:
        slower = min(told.speed_scale, BLIND)
        return replace(told, text=f"{told.text}; {unseen}", speed_scale=slower)
    return replace(
        told, status=Status.STALE_COMMAND, text=unseen, action=Action.SLOW, speed_scale=BLIND
    )


def next_action(previous: Action, distance: float, blocked: bool, hysteresis: float) -> Action:
    """The action for a distance to the nearest threshold, without chattering.

    An action is taken at its threshold and given up only where the distance is greater by the
    hysteresis.

    Args:
        previous: Action before.
        distance: 1 at the warning, 0 at the stop; NaN is taken for a stop.
        blocked: Whether motion is refused.
        hysteresis: Fraction of the way between the thresholds.
    """
    if blocked or not distance > 0.0:
        return Action.HALT
    if previous == Action.HALT and distance <= hysteresis:
        return Action.HALT
    if distance < 1.0:
        return Action.SLOW
    if previous != Action.NONE and distance <= 1.0 + hysteresis:
        return Action.SLOW
    return Action.NONE


def verdict(
    assessment: Assessment,
    thresholds: Thresholds,
    watched: Iterable[str],
    *,
    previous: Action,
    hysteresis: float,
    refusal: Refusal | None = None,
    worsening: Collection[str] = MEASURES,
    stale: bool = False,
) -> Verdict:
    """What a supervisor is told about an equilibrium.

    Args:
        assessment: The equilibrium and its measures.
        thresholds: Thresholds of the measures.
        watched: Measures that count now.
        previous: Action told before.
        hysteresis: See :func:`next_action`.
        refusal: Why the robot may not be moved on, if so.
        worsening: Measures that fell in the last motion.
        stale: Whether the setpoint is too old.
    """
    equilibrium = assessment.equilibrium
    levels = {name: thresholds[name].level(assessment.value(name)) for name in watched}
    # NaN comes before every number.
    nearest = min(levels, key=lambda name: (not math.isnan(levels[name]), levels[name]))
    distance = levels[nearest]
    unknown = math.isnan(distance)
    if math.isinf(distance):
        nearest = ""
    action = next_action(previous, distance, refusal is not None, hysteresis)
    scale = 0.0 if action == Action.HALT else min(1.0, max(0.0, distance))
    if refusal is not None:
        status = _OTHER.get(refusal.reason) or _STATUSES[refusal.reason][1]
        text = refusal.text
    elif unknown:
        status, text = Status.INVALID, f"{nearest} is not defined here"
    elif action == Action.HALT:
        status = _STATUSES[nearest][1]
        text = _compared(assessment, nearest, "stop", thresholds[nearest])
    elif stale:
        status, text = Status.STALE_COMMAND, "the setpoint is too old, holding"
    elif action == Action.SLOW:
        status = _STATUSES[nearest][0]
        if nearest not in worsening and status == Status.DECELERATE_FOR_APPROACHING_SINGULARITY:
            status = Status.DECELERATE_FOR_LEAVING_SINGULARITY
        text = _compared(assessment, nearest, "warning", thresholds[nearest])
    else:
        status, text = Status.NO_WARNING, "stable"
    if not equilibrium.robot.has_potential(equilibrium.loads):
        # No energy decides: be as careful as the numbers say, but never call it stable.
        text = f"non-conservative load, energy does not decide stability ({text})"
        if status == Status.NO_WARNING:
            status = Status.INVALID
    return Verdict(status, text, action, scale, nearest, distance)


def below_warnings(
    assessment: Assessment, thresholds: Thresholds, *, tracked: bool = False
) -> list[str]:
    """What is to be said of measures that are below their warning where a robot begins, one line each.

    Args:
        assessment: Where it begins.
        thresholds: Thresholds of the measures.
        tracked: Whether others move its motors: no motion is halted then, and no pose asked for.
    """
    lines = []
    for name, threshold in thresholds.items():
        of_poses, level = MEASURES[name].of_poses, threshold.level(assessment.value(name))
        if not level < 1.0 or (tracked and of_poses):
            continue
        which, done = ("warning", "slowed down") if level > 0.0 else ("stop", "halted")
        told = f"action is {(Action.SLOW if level > 0.0 else Action.HALT).name}"
        if not tracked:
            motions = "platform setpoints" if of_poses else "motions"
            told = f"{motions} that make it smaller are {done}, and {told}"
            told += " with every one" if of_poses else ""
        compared = _compared(assessment, name, which, threshold)
        lines.append(f"{compared} here: {told}; docs/node.md, Thresholds, tells how to choose them")
    return lines


def _compared(assessment: Assessment, measure: str, which: str, threshold: Threshold) -> str:
    """A measure beside its stop or warning threshold, by the names of message and parameters."""
    value, limit = assessment.value(measure), getattr(threshold, which)
    told, limit_told = distinct(value, limit)
    if value < limit:
        where = f"below {measure}_{which} {limit_told}"
    elif value == limit:
        where = f"at {measure}_{which} {limit_told}"
    else:
        where = f"above {measure}_{which} {limit_told} by less than the hysteresis"
    return f"{FIELDS[measure]} {told} is {where}"
