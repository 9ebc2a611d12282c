# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether the platform pose that somebody measures can be believed. No ROS here."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from cpr_core.errors import distinct

from ..following.watchdog import Watchdog
from .pose_history import HORIZON, PoseChange, PoseHistory, Sighting
from .several_cameras import LATENESS, RESOLUTION, SeveralCameras

__all__ = ["MeasuredPose"]

Floats = NDArray[np.float64]

#: How many measured poses have to agree after a jump, however often they come.
_AGREEING = 5
#: A pose that is not believed is left aside for this time before it is a problem: cameras mistake a
#: picture or two for something else [s].
_MOMENT = 0.1
#: How far stamps may be ahead of the clock: clocks that are kept together agree better [s].
_CLOCKS_AGREE = 0.01
#: How far back jumps are counted [s].
_LATELY = 10.0


class MeasuredPose:
    """The newest measured pose, and what speaks against it.

    Attributes:
        newest: Controlled coordinates, but for what is left aside; None before the first.
        problem: Why it is not believed; empty if it is.
        watchdog: Age of the newest, by receipt.
    """

    def __init__(self, history: PoseHistory, timeout: float) -> None:
        """Know nothing yet.

        Args:
            history: Where the model has the platform.
            timeout: Age beyond which a measured pose is stale [s]; 0: never.
        """
        self._history = history
        self.watchdog = Watchdog(timeout)
        self._cameras = SeveralCameras(history)
        self.forget()

    def forget(self) -> None:
        """Be as if no pose had ever come."""
        self.watchdog.forget()
        self._cameras.forget()
        self.newest: Floats | None = None
        self.problem = ""
        self._heard = math.nan  # when the last message came, whatever it was
        self._ahead = 0.0  # of the clock, by its stamp
        self._travelled_at_change = 0.0  # by the platform until the numbers changed
        self._jump, self._jump_since = "", 0.0
        self._agree_since, self._agreeing = 0.0, 0  # of measured poses after a jump
        self._last: Sighting | None = None  # whether it was believed or not
        self._believed: Sighting | None = None  # the last that was
        self._jumps: deque[tuple[float, float]] = deque()  # when, and how far

    def refuse(self, problem: str, now: float) -> None:
        """Take note of a message that is no pose, at a steady time [s]."""
        self.problem, self._heard = problem, now

    def silent(self, now: float) -> str:
        """That nothing has come for too long, and what spoke against the last; empty otherwise."""
        age, timeout = now - self._heard, self.watchdog.timeout
        if not 0.0 < timeout < age:
            return ""
        told, most = distinct(age, timeout)
        limit = f"more than measured_pose_timeout {most} s"
        if self.problem:
            return f"no measured pose came for {told} s, {limit} (the last: {self.problem})"
        return f"the measured pose is {told} s old, {limit}"

    @property
    def jumping(self) -> bool:
        """Whether the pose is elsewhere than it was believed, and nobody knows yet which is wrong."""
        return bool(self._jump)

    def left_aside(self, now: float) -> str:
        """How often the pose has jumped lately, in words; empty: never."""
        count = self._jumps_lately(now)
        if not count:
            return ""
        return (
            f"left aside: the measured pose jumped {count} time{'s' * (count > 1)} in the last "
            f"{_LATELY:g} s, the last time by {self._jumps[-1][1]:.3g} rod lengths or rad"
        )

    @property
    def clocks_differ(self) -> str:
        """How far the stamp of the newest is ahead of the clock, in words; empty: it is not."""
        if self._ahead <= _CLOCKS_AGREE:
            return ""
        return (
            f"the measured pose was stamped {self._ahead:.3g} s ahead of the clock here: how old it "
            f"was when it came is not known"
        )

    def take(
        self,
        pose: Floats,
        now: float,
        delay: float,
        *,
        jump: float,
        settling: float,
        several: bool = False,
    ) -> bool:
        """Take a measured pose; says whether it is believed.

        Args:
            pose: Controlled coordinates.
            now: Steady time of its receipt [s].
            delay: Time since it was measured, by its stamp [s]; negative: clocks differ.
            jump: How far it may be from the one before, more than the platform moved [rod lengths, rad].
            settling: How long measured poses have to agree after a jump [s].
            several: Whether there may be several who measure it.
        """
        timeout, self._heard = self.watchdog.timeout, now
        oldest = min(timeout, HORIZON) if timeout > 0.0 else HORIZON
        if delay > oldest:
            self.problem = f"the measured pose was {delay:.3g} s old when it came, by its stamp"
            return False
        self._ahead, delay = max(0.0, -delay), max(0.0, delay)
        if self._ahead > max(oldest, _CLOCKS_AGREE):
            self.problem = self.clocks_differ
            return False
        before = self._last
        travelled = self._history.travelled(now - delay - LATENESS)
        self._last = Sighting(pose, travelled, now)
        self.watchdog.feed(now)
        if several:
            self._cameras.hear(pose, travelled, now - delay, now)
        changed = True
        if before is not None:
            change = self._history.change_since(before, pose, now)
            changed = change.measured > 0.0
            if self._goes_on(pose, now, jump, settling):
                self._jump = ""
                if several:
                    self._cameras.came_back(before, change.measured, jump, now)
            elif not change.explained(jump):
                self._note_jump(change, now)
        if changed:
            self._travelled_at_change = self._history.travelled(now - delay)
        if self._jump:
            self._agreeing += 1
            if self._agreeing < _AGREEING or now - self._agree_since < settling:
                if now - self._jump_since > _MOMENT:
                    self.newest, self.problem = pose, self._jump
                return False
            self._jump = ""
        self.newest, self._believed = pose, self._last
        self.problem = self._cameras.problem(now, settling) or self._stuck(travelled)
        return not self.problem

    def _goes_on(self, pose: Floats, now: float, jump: float, settling: float) -> bool:
        """Whether a pose is where the platform was believed to be a moment ago: what jumped is over."""
        believed = self._believed
        if not self._jump or believed is None or now - believed.heard >= settling:
            return False
        return self._history.change_since(believed, pose, now).explained(jump)

    def _note_jump(self, change: PoseChange, now: float) -> None:
        self._agree_since, self._agreeing = now, 0
        self._jumps.append((now, change.measured))
        count = self._jumps_lately(now)
        often = f", {count} times in the last {_LATELY:g} s" if count > 1 else ""
        if not self._jump:
            self._jump_since = now
        told, moved_told = distinct(*change, fewest=3)
        self._jump = (
            f"the measured pose jumped by {told} rod lengths or rad{often}, "
            f"the platform moved by {moved_told}"
        )

    def _jumps_lately(self, now: float) -> int:
        while self._jumps and self._jumps[0][0] < now - _LATELY:
            self._jumps.popleft()
        return len(self._jumps)

    def _stuck(self, travelled: float) -> str:
        """Why numbers that stay the same are no measurement; empty if they may be one.

        Args:
            travelled: By the platform until the newest was measured [rod lengths, rad].
        """
        moved = travelled - self._travelled_at_change
        if moved <= RESOLUTION:
            return ""
        return f"the measured pose does not change, the platform moved by {moved:.3g} rod lengths or rad"
