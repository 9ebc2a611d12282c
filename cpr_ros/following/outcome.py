# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a tick led to, whoever moved the robot in it. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass

from cpr_core.model.assessment import Assessment

from .supervision import Refusal, State, Verdict

__all__ = ["Outcome"]


@dataclass(frozen=True)
class Outcome:
    """What a tick led to.

    Attributes:
        assessment: Equilibrium after the tick.
        moved: Whether the motors moved.
        state: What the node does.
        verdict: What a supervisor is told.
        home_missed: Whether a return ended at the motors of home, but in another equilibrium.
        refusal: Why the robot is halted, if it is.
        obeyed: Whether the motors are where a setpoint wants them in this tick: a step towards it was
            accepted, or it is reached.
    """

    assessment: Assessment
    moved: bool
    state: State
    verdict: Verdict
    home_missed: bool = False
    refusal: Refusal | None = None
    obeyed: bool = False
