# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Several who measure the platform: they may contradict each other, and one may hang. No ROS here.

Nobody tells whose a message is. One that hangs beside others is known by numbers that come again and
again while the platform moves, two that disagree by poses that jump and come back from one place.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..following.pose_coordinates import PoseCoordinates
from .pose_history import PoseHistory

__all__ = ["LATENESS", "RESOLUTION", "SeveralCameras"]

Floats = NDArray[np.float64]

#: The platform may move so far without a change of the measured numbers [rod lengths, rad], and
RESOLUTION = 2e-3
#: so long: a measurement may be that late without telling.
LATENESS = 0.2
#: Back from one place so often, each so soon after the one before [s], the platform is in two places.
_OFTEN, _SOON = 5, 0.5
#: So many numbers are looked through for those that are too old to come again.
_MANY = 100


class SeveralCameras:
    """What several who measure the platform say against each other."""

    def __init__(self, coordinates: PoseCoordinates, history: PoseHistory) -> None:
        """Know nothing yet.

        Args:
            coordinates: Of the robot.
            history: Where the model has the platform.
        """
        self._coordinates, self._history = coordinates, history
        self.forget()

    def forget(self) -> None:
        """Be as if no pose had ever come."""
        self._problem, self._noticed = "", -math.inf
        #: The way of the platform when numbers came first, and when they came last.
        self._numbers: dict[bytes, tuple[float, float]] = {}
        self._left: tuple[Floats, float, float] | None = None  # a place, the way then, and when
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
        key, nothing = pose.tobytes(), (self._history.travelled(measured), now)
        first, last = self._numbers.get(key, nothing)
        if now - last > LATENESS:
            first = nothing[0]
        self._numbers[key] = first, now
        if way - first > RESOLUTION:
            self._note(
                f"one of several who publish the measured pose says the same again and again, the "
                f"platform moved by {way - first:.3g} rod lengths or rad",
                now,
            )
        if len(self._numbers) > _MANY:
            known = self._numbers.items()
            self._numbers = {key: way for key, way in known if now - way[1] <= LATENESS}

    def came_back(self, place: Floats, way: float, apart: float, jump: float, now: float) -> None:
        """Notice two places.

        Args:
            place: Where the pose had jumped to.
            way: Of the platform then [rod lengths, rad].
            apart: How far that is from where it is now.
            jump: How far poses of one place may be apart, beyond the motion of the platform.
            now: Steady time [s].
        """
        before, self._left = self._left, (place, way, now)
        if before is None or now - before[2] > _SOON:
            self._returns = 1
            return
        moved = max(0.0, self._history.travelled(now) - before[1])
        same = self._coordinates.size(self._coordinates.way(before[0], place)) <= jump + moved
        self._returns = self._returns + 1 if same else 1
        if self._returns >= _OFTEN:
            self._note(
                f"the platform is measured in two places in turn, {apart:.2g} rod lengths or rad apart, "
                "by several who publish its pose",
                now,
            )

    def _note(self, problem: str, now: float) -> None:
        self._problem, self._noticed = problem, now
