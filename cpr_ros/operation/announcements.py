# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the log is told of the motion: halts, recoveries, pauses and returns, each once. No ROS here."""

from __future__ import annotations

from ..following.borne_loads import Snapped
from ..following.news import Announced, News
from ..following.outcome import Outcome
from ..following.supervision import Action, State

__all__ = ["Announcements"]

#: A halt that comes back within this time has not ended [s].
_SETTLED = 0.5
_HELD = (State.HALTED, State.STALE, State.LOST)
#: A way home does not end with them.
_ON_THE_WAY_HOME = (State.RETURNING, State.HALTED, State.ALIGNING)


class Announcements:
    """Looks at every tick and has something to say when something begins or ends."""

    def __init__(self) -> None:
        """Take the robot for one that moves freely."""
        self._halted = self._lost = False
        self._snapped: Snapped | None = None
        self._free_since: float | None = None
        self._state = State.IDLE
        self._returning = False
        self._motors, self._wrench, self._commanders = Announced(), Announced(), Announced()
        self._setpoint = Announced()

    @property
    def at_rest(self) -> bool:
        """Whether only what comes can bring news; a halt is over only after a while."""
        return self._free_since is None

    def after_tick(self, outcome: Outcome, now: float) -> News:
        """What to log after a tick.

        Args:
            outcome: Of the tick.
            now: Steady time [s].
        """
        warning, verdict = "", outcome.verdict
        lost_before, self._lost = self._lost, outcome.state == State.LOST
        if verdict.action == Action.HALT or outcome.state in _HELD:
            snapped = outcome.refusal if isinstance(outcome.refusal, Snapped) else None
            newly_lost = self._lost and not lost_before
            newly_snapped = snapped is not None and snapped is not self._snapped
            if newly_lost or newly_snapped or not self._halted:
                warning = f"halt ({outcome.state.name}, {verdict.status.name}): {verdict.text}"
            self._halted, self._free_since, self._snapped = True, None, snapped
            information = ""
        else:
            information = self._recovery(outcome, now)
        news = information, self._changed(outcome.state)
        return News(warning, "; ".join(filter(None, news)))

    def of_motors(self, unmeasured: str, *, again: bool = False) -> News:
        """What to log of measured motors: a warning when they are missing, and that they are back.

        Args:
            unmeasured: Why they are not measured any more; empty: nothing is missing.
            again: Whether they have come again, but not for long enough.
        """
        moved = "was moved meanwhile was" if again else "is moved now is"
        blind = f"{unmeasured}: what {moved} moved without being seen" if unmeasured else ""
        return self._motors.news(blind, "the motors are measured again")

    def of_wrench(self, unmeasured: str) -> News:
        """What to log of the external wrench: a warning when it is missing, and that it is back.

        Args:
            unmeasured: Why it is not known any more; empty: nothing is missing.
        """
        return self._wrench.news(unmeasured, "the external wrench is measured again")

    def of_setpoint(self, forgotten: str) -> News:
        """What to log of a setpoint that was forgotten though nobody has asked for it.

        Args:
            forgotten: Why; empty: none was.
        """
        warning = f"the setpoint is forgotten, the robot holds: {forgotten}" if forgotten else ""
        return self._setpoint.news(warning, "", kind=forgotten)

    def of_commanders(self, others: str) -> News:
        """What to log of others who command the motors: a warning when they come, and that they left.

        Args:
            others: Who they are, in words; empty: nobody.
        """
        return self._commanders.news(others, "nobody else commands the motors any more")

    def _recovery(self, outcome: Outcome, now: float) -> str:
        """That a halt has ended, when it has not come back for a while."""
        if not self._halted:
            return ""
        if self._free_since is None:
            self._free_since = now
        if now - self._free_since < _SETTLED:
            return ""
        self._halted, self._free_since = False, None
        return f"the halt is over ({outcome.state.name}): {outcome.verdict.text}"

    def _changed(self, state: State) -> str:
        """That a pause or a way home begins or ends."""
        before, self._state = self._state, state
        known, self._returning = self._returning, state == State.RETURNING
        if known and state in _ON_THE_WAY_HOME:
            self._returning = True
        if state == before:
            return ""
        if state == State.PAUSED:
            return "paused: holds, and takes no setpoints"
        if before == State.PAUSED and state == State.ALIGNING:
            return "released: commands go on to where the node has the robot"
        if before == State.PAUSED:
            return "released: takes setpoints again"
        if state == State.RETURNING and not known:
            return "on the way home"
        if before == State.RETURNING and state == State.IDLE:
            return "the way home has ended"
        return ""
