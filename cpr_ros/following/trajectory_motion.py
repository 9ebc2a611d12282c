# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A trajectory from its order to its end. No rclpy here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .trajectory_goal import TrajectoryGoal
from .trajectory_order import TrajectoryOrder
from .trajectory_plan import TrajectoryPlan

__all__ = ["Ending", "Joining", "Motion"]


@dataclass(frozen=True)
class Ending:
    """How a trajectory ended.

    Attributes:
        val: Number of cpr_msgs/ErrorCode.
        message: For a person; empty with SUCCESS.
        time: When, since its start [s].
        measure: What stood against it.
        replaced: Whether a newer trajectory took its place, as that of a stream does.
    """

    val: int
    message: str = ""
    time: float = 0.0
    measure: str = ""
    replaced: bool = False


@dataclass(frozen=True, eq=False)
class Joining:
    """How a trajectory goes on from what the motors do.

    Attributes:
        plan: Its path, and equilibria along it.
        own_time: Where on its path it would be at a steady time [s], in its own time, before it has
            begun.
        join: Until then, in its own time, the path is what the motors did before [s].
    """

    plan: TrajectoryPlan
    own_time: Callable[[float], float]
    join: float


@dataclass(eq=False)
class Motion:
    """A trajectory from its order to its end.

    Attributes:
        order: What was ordered.
        joining: What is solved for it.
        on_end: Called with its end, once.
        after: How many orders the follower had had when it came; more of them are newer.
        since: When solving its plan began, steady time [s].
        stamp: When its own time is zero, steady time [s]; None: as soon as it is solved.
        goal: What the follower follows; None: it has not begun.
        cut_off: Whether the one it was to go on from has ended early.
    """

    order: TrajectoryOrder
    joining: Joining
    on_end: Callable[[Ending], None]
    after: int
    since: float
    stamp: float | None
    goal: TrajectoryGoal | None = None
    cut_off: bool = False

    @property
    def time(self) -> float:
        """Where on its path it is, since its start [s]; 0 before it has begun."""
        return 0.0 if self.goal is None else self.goal.time
