# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Several who measure the platform: they may contradict each other, and one may hang. No ROS here.

Nobody tells whose a message is. One that hangs beside others is known by numbers that come again and
again while the platform moves, two that disagree by poses that jump and come back from one place. Those
that disagree by less are all believed, and what they say of a setpoint is the worst of it.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ..following.pose_coordinates import PoseCoordinates
from .pose_history import PoseHistory, Sighting

__all__ = ["LATENESS", "RESOLUTION", "TURN", "RecentPoses", "SeveralCameras"]

Floats = NDArray[np.float64]

#: How far the platform may move without a change of the measured numbers [rod lengths, rad].
RESOLUTION = 2e-3
#: How late a measurement may be without its stamp saying so [s].
LATENESS = 0.2
#: The platform is measured in two places if its pose comes back so many times from the same one, each
#: time so soon after the time before [s].
_OFTEN, _SOON = 5, 0.5
#: Within this time everyone who measures it has done so [s].
TURN = 0.5
#: Those who are nearer to each other agree [rod lengths, rad].
_AGREED = 0.01
#: Poses that are too old to come again are forgotten when so many are known.
_MANY = 100


class SeveralCameras:
    """What several who measure the platform say against each other."""

    def __init__(self, history: PoseHistory) -> None:
        """Know nothing yet.

        Args:
            history: Where the model has the platform.
        """
        self._history = history
        self.forget()

    def forget(self) -> None:
        """Be as if no pose had ever come."""
        self._problem, self._noticed = "", -math.inf
        #: By the bytes of a pose: way of the platform until it came first, and when it came last.
        self._numbers: dict[bytes, tuple[float, float]] = {}
        self._left: Sighting | None = None  # the place that the pose came back from
        self._left_at = -math.inf
        self._returns = 0  # from there

    def problem(self, now: float, lasting: float) -> str:
        """What speaks against all of them, if it was noticed less than so long ago [s]; else empty."""
        return self._problem if now - self._noticed < lasting else ""

    def hear(self, pose: Floats, way: float, measured: float, now: float) -> None:
        """Notice one that hangs.

        Args:
            pose: Of a message.
            way: Of the platform until it was measured, or a little before [rod lengths, rad].
            measured: Steady time at which it was measured, by its stamp [s].
            now: Steady time [s].
        """
        key, travelled = pose.tobytes(), self._history.travelled(measured)
        first, last = self._numbers.get(key, (travelled, now))
        if now - last > LATENESS:
            first = travelled
        self._numbers[key] = first, now
        if way - first > RESOLUTION:
            self._note(
                f"one of several who publish the measured pose says the same again and again, the "
                f"platform moved by {way - first:.3g} rod lengths or rad",
                now,
            )
        if len(self._numbers) > _MANY:
            known = self._numbers.items()
            self._numbers = {key: came for key, came in known if now - came[1] <= LATENESS}

    def came_back(self, place: Sighting, apart: float, jump: float, now: float) -> None:
        """Notice two places.

        Args:
            place: Where the pose had jumped to.
            apart: How far that is from where it is now [rod lengths, rad].
            jump: How far poses of one place may be apart, beyond the motion of the platform.
            now: Steady time [s].
        """
        before, self._left = self._left, place
        left_at, self._left_at = self._left_at, now
        if before is None or now - left_at > _SOON:
            self._returns = 1
            return
        same = self._history.change_since(before, place.pose, now).explained(jump)
        self._returns = self._returns + 1 if same else 1
        if self._returns >= _OFTEN:
            self._note(
                f"the platform is measured in two places in turn, {apart:.2g} rod lengths or rad apart, "
                "by several who publish its pose",
                now,
            )

    def _note(self, problem: str, now: float) -> None:
        self._problem, self._noticed = problem, now


class RecentPoses:
    """What several have measured of the platform at its setpoint, each of them in their turn.

    What they say together is found once for every pose that comes: it is asked for several times a tick.
    """

    def __init__(self, coordinates: PoseCoordinates) -> None:
        """Know of none."""
        self._space = coordinates
        self._poses: deque[tuple[float, Floats, Floats]] = deque()
        #: The setpoint that errors were found for, and these; None: not since the last pose.
        self._found: tuple[Floats, tuple[float, float]] | None = None
        self._apart: float | None = None

    def forget(self) -> None:
        """The platform is elsewhere."""
        self._poses.clear()
        self._found = self._apart = None

    def take(self, pose: Floats, error: Floats, now: float) -> None:
        """Take a measured pose, and its way from the model of then, at a steady time [s]."""
        self._poses.append((now, pose, error))
        while now - self._poses[0][0] > TURN:
            self._poses.popleft()
        self._found = self._apart = None

    def errors(self, wanted: Floats) -> tuple[float, float] | None:
        """How far the farthest is from a setpoint [m], [rad]; None: nothing is known."""
        if not self._poses:
            return None
        if self._found is None or not np.array_equal(self._found[0], wanted):
            sizes = [self._space.sizes(self._space.way(pose, wanted)) for _, pose, _ in self._poses]
            position, rotation = np.max(sizes, axis=0).tolist()
            self._found = wanted.copy(), (position, rotation)
        return self._found[1]

    def apart(self) -> str:
        """How far they are from each other, in words; empty: they agree."""
        if self._apart is None:
            errors = [error for _, _, error in self._poses]
            ways = (self._space.size(error - errors[-1]) for error in errors)
            self._apart = max(ways, default=0.0)
        if self._apart <= _AGREED:
            return ""
        return (
            f"several publish the measured pose, and differ by {self._apart:.2g} rod lengths or rad: "
            "between them is where the platform is held"
        )
