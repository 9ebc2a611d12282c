# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where the model had the platform, and when: a measured pose is older than the newest equilibrium."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium

from ..following.pose_coordinates import PoseCoordinates

__all__ = ["HORIZON", "Place", "PoseChange", "PoseHistory", "Sighting"]

Floats = NDArray[np.float64]

#: How far back it is remembered [s].
HORIZON = 5.0


@dataclass(frozen=True)
class Place:
    """Where the model had the platform from a time on.

    Attributes:
        time: Steady time [s].
        equilibrium: The equilibrium.
        pose: Its controlled coordinates.
        travelled: Length of the whole way there [rod lengths, rad].
        waiting: Why the platform is not where its setpoint sends it; empty if it is.
    """

    time: float
    equilibrium: Equilibrium
    pose: Floats
    travelled: float
    waiting: str


class Sighting(NamedTuple):
    """A measured pose, and how far the platform had come by then.

    Attributes:
        pose: Controlled coordinates.
        travelled: Length of the way until it was measured, or a little before [rod lengths, rad].
        heard: Steady time at which it came [s].
    """

    pose: Floats
    travelled: float
    heard: float


class PoseChange(NamedTuple):
    """From a measured pose to a later one.

    Attributes:
        measured: How far they are apart [rod lengths, rad].
        platform: How far the platform may have moved meanwhile [rod lengths, rad].
    """

    measured: float
    platform: float

    def explained(self, jump: float) -> bool:
        """Whether it is no more than the motion of the platform and a jump [rod lengths, rad]."""
        return self.measured <= jump + self.platform


class PoseHistory:
    """Places of the last seconds; nothing is added while nothing changes."""

    def __init__(self, coordinates: PoseCoordinates) -> None:
        """Remember nothing yet."""
        self._coordinates = coordinates
        self._places: deque[Place] = deque()

    @property
    def newest(self) -> Place | None:
        """Where the platform is; None before the first."""
        return self._places[-1] if self._places else None

    def add(self, time: float, equilibrium: Equilibrium, waiting: str) -> None:
        """Note where the platform is now."""
        places, last = self._places, self.newest
        if last is None:
            places.append(Place(time, equilibrium, equilibrium.pose, 0.0, waiting))
        elif equilibrium is not last.equilibrium:
            pose = equilibrium.pose
            step = self._coordinates.size(self._coordinates.way(last.pose, pose))
            places.append(Place(time, equilibrium, pose, last.travelled + step, waiting))
        elif waiting != last.waiting:
            places.append(Place(time, equilibrium, last.pose, last.travelled, waiting))
        while len(places) > 1 and places[1].time <= time - HORIZON:
            places.popleft()

    def at(self, time: float) -> Place | None:
        """Where the platform was then, or first; None before the first."""
        for place in reversed(self._places):
            if place.time <= time:
                return place
        return self._places[0] if self._places else None

    def travelled(self, time: float) -> float:
        """Length of the whole way until then [rod lengths, rad]."""
        place = self.at(time)
        return place.travelled if place is not None else 0.0

    def change_since(self, sighting: Sighting, pose: Floats, now: float) -> PoseChange:
        """From a sighting to a measured pose that comes now [s]."""
        apart = self._coordinates.size(self._coordinates.way(sighting.pose, pose))
        return PoseChange(apart, max(0.0, self.travelled(now) - sighting.travelled))
