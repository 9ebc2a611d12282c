# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the robot does at present. No rclpy here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpr_core.model.assessment import Assessment

from ..following.outcome import Outcome
from ..following.setpoint_following import SetpointFollower
from ..following.supervision import State
from .outgoing import Outgoing

__all__ = ["Present"]


class Present:
    """What the last tick led to, and what requests have made of it since.

    Who has the answer to a request believes the stream from then on, before the next tick.

    Attributes:
        outcome: Of the last tick, in the state that a request has brought about since.
        velocity: Of the motors in the last tick, or between the last measurements, (n,) [rad/s, m/s].
    """

    outcome: Outcome

    def __init__(self, home: Assessment, follower: SetpointFollower, outgoing: Outgoing) -> None:
        """Stand at home.

        Args:
            home: Where the robot is.
            follower: Judges where it is, and may be paused.
            outgoing: Tells whether motor commands are on their way.
        """
        self._follower, self._outgoing = follower, outgoing
        self.velocity: NDArray[np.float64] = np.zeros(home.equilibrium.robot.motor_count)
        self.begin(home)

    def begin(self, place: Assessment) -> None:
        """Stand at an equilibrium that no tick has led to."""
        told = self._follower.judge(place)
        self.outcome = Outcome(place, False, self._state_at_rest, told)

    def rest(self) -> None:
        """Do what is done without a setpoint."""
        self.be(self._state_at_rest)

    def be(self, state: State) -> None:
        """Be in a state."""
        self.outcome = replace(self.outcome, state=state)

    @property
    def _state_at_rest(self) -> State:
        if self._follower.paused:
            return State.PAUSED
        return State.IDLE if self._outgoing.aligned else State.ALIGNING
