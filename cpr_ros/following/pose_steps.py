# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Steps towards a pose: as long as the speed of the motors allows. No ROS here.

How far motors go for a step of the platform is not known before it is solved: it is learnt from step to
step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core import InvalidRequest, Robot
from cpr_core.model.assessment import Assessment

from .goals import MotorGoal, PoseGoal, whole
from .motor_ways import SLACK, largest_way
from .steps import Undecided, attempt
from .supervision import Refusal

__all__ = ["PoseSteps", "TickWay"]

Floats = NDArray[np.float64]

#: Part of a tick's way that the first step makes where it is not the last: it goes along the tangent,
#: and leaves the straight way by the square of its length.
_FIRST = 0.1
#: Part of the motors' speed that a step is planned for, so that it rarely has to be solved again.
_EXPECTED = 0.9
#: Part of a tick's way that a step makes while it is not known how far motors go for it.
_PROBE = 1e-3
#: How many times a step is solved at most, shorter each time.
_ATTEMPTS = 6
#: Progress of a step is taken to be this at least where it is divided by [rad, rod lengths].
_NO_NEARER = 1e-9
#: Ticks of motors for a rad or a rod length of the platform are taken to be this many at least where
#: they are divided by: motors hardly move.
_NO_TICKS = 1e-9


class TickWay(NamedTuple):
    """How far a robot goes in a tick at full speed.

    Attributes:
        motors: Every motor, (n,) [rad or m].
        platform: The platform [rad, rod lengths].
    """

    motors: list[float]
    platform: float


class PoseSteps:
    """Steps of one robot on its way to a pose."""

    def __init__(self, robot: Robot) -> None:
        """Know nothing of any way."""
        self._robot = robot
        self._ticks_per_way = math.nan  # of motors at full speed, by way of the platform

    def first(
        self, current: Assessment, goal: PoseGoal, factor: float, tick: TickWay
    ) -> Floats | None:
        """Where the first step out of rest takes the motors, (n,) [rad or m]: along the tangent.

        It needs no solution, and leaves the straight way in the pose by the square of its length: so it
        is short, or all of a way that takes no more than a tick. None: the tangent does not tell, or
        leads a motor beyond its range.

        Args:
            current: Where the robot is.
            goal: Where it is to go.
            factor: Part of their speed that motors and platform may have.
            tick: How far they go in a tick at full speed.
        """
        start, way = current.equilibrium.motors, goal.motors_ahead(current)
        if way is None:
            return None
        ticks = largest_way(start, start + way, tick.motors)
        if ticks == 0.0:
            return None
        ticks = max(ticks, goal.remaining(current.equilibrium) / tick.platform)
        part = 1.0 if ticks <= factor else _FIRST * factor / ticks
        try:
            aim = MotorGoal(self._robot, start + part * way)
        except InvalidRequest:  # no rod would be left
            return None
        return None if aim.clipped else aim.motors

    def step(
        self, current: Assessment, goal: PoseGoal, factor: float, tick: TickWay
    ) -> Assessment | Refusal:
        """Solve where the next step leads.

        Args:
            current: Where the robot is.
            goal: Where it is to go.
            factor: Part of their speed that motors and platform may have.
            tick: How far they go in a tick at full speed.
        """
        start, remaining = current.equilibrium, goal.remaining(current.equilibrium)
        way = factor * tick.platform
        if math.isnan(self._ticks_per_way):
            way *= _PROBE
        else:
            way = min(way, _EXPECTED * factor / max(self._ticks_per_way, _NO_TICKS))
        for _ in range(_ATTEMPTS):
            fraction = whole(way / remaining)
            ahead = attempt(current, goal, fraction, start.loads)
            if isinstance(ahead, Refusal):
                return ahead
            ticks = largest_way(start.motors, ahead.equilibrium.motors, tick.motors)
            self._ticks_per_way = ticks / (fraction * remaining)
            if ticks <= factor * (1.0 + SLACK):
                return ahead
            way *= _EXPECTED * factor / ticks
        # Not decided: the next attempt begins with what was learnt.
        text = "the motors would have to move beyond their speed"
        return Undecided("inverse_singularity", text)

    def first_step(
        self, current: Assessment, goal: PoseGoal, aim: Floats, tick: TickWay
    ) -> Assessment | Refusal:
        """Solve where the first step leads.

        Args:
            current: Where the robot is.
            goal: Where it is to go.
            aim: Where the step takes the motors, (n,) [rad or m].
            tick: How far motors and platform go in a tick at full speed.
        """
        start = current.equilibrium
        ahead = attempt(current, MotorGoal(self._robot, aim), 1.0, start.loads)
        if isinstance(ahead, Assessment):
            nearer = goal.remaining(start) - goal.remaining(ahead.equilibrium)
            ticks = largest_way(start.motors, aim, tick.motors)
            self._ticks_per_way = ticks / max(nearer, _NO_NEARER)
        return ahead
