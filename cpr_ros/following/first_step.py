# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The first step out of rest, judged before it is asked for. No ROS here.

A setpoint that comes at rest would wait for a solution and its measures, which take most of a
millisecond on a processor that others have used meanwhile. At rest there is time to look where the
motors could go in a tick; where none of that comes near a warning, the command goes out first and is
solved in the same tick.
"""

from __future__ import annotations

import math
from contextlib import suppress

from cpr_core import Robot
from cpr_core.model.assessment import Assessment

from .judged_steps import LARGEST_CHANGE
from .motion_settings import WATCHED, Settings
from .motor_ways import motor_steps
from .setpoint_following import SetpointFollower
from .surroundings import Surroundings

__all__ = ["FirstStep"]

#: How long the robot rests before it looks around: setpoints may follow each other closely [s].
_QUIET = 0.02
#: Time between two looks, for whatever else comes in [s].
_BREATH = 0.002


class FirstStep:
    """Looks around while the robot rests.

    Attributes:
        due: Steady time of the next look [s]; infinite while there is nothing to look at.
    """

    def __init__(self, robot: Robot, period: float, follower: SetpointFollower) -> None:
        """Know nothing yet.

        Args:
            robot: The robot.
            period: Time of a tick [s].
            follower: Takes the step.
        """
        self.due = math.inf
        self._robot, self._period, self._follower = robot, period, follower
        self._around: Surroundings | None = None
        self._settings: Settings | None = None
        self._free: frozenset[tuple[str, ...]] = frozenset()  # measures that are far from warnings

    def wait(self) -> None:
        """Do not look: the robot moves, or is not to be moved."""
        self.due = math.inf

    def look(self, current: Assessment, now: float) -> None:
        """Look around at rest, a bit at a time; to be asked again and again, and when it is due.

        Args:
            current: Where the robot is.
            now: Steady time [s].
        """
        if self._around is None or not self._looked_from(current):
            self._begin(current)
            self.due = now + _QUIET
        elif self._around.known:
            self.due = math.inf
        elif math.isinf(self.due):  # it was interrupted
            self.due = now + _QUIET
        elif now >= self.due:
            self._around.look()
            self._free = self._judged(self._around)
            self.due = now + _BREATH

    def knows(self, current: Assessment) -> bool:
        """Whether any first step from where the robot is has been judged: the follower's aim is safe.

        Args:
            current: Where the robot is.
        """
        return self._follower.watched in self._free and self._looked_from(current)

    def _judged(self, around: Surroundings) -> frozenset[tuple[str, ...]]:
        """Measures of which none is near a warning, wherever the motors step."""
        if around.known:
            with suppress(Exception):  # who goes to a pose is told what is wrong, if anything
                _ = around.current.kinemato_statics.motors_by_pose  # is ready from now on
        thresholds = self._follower.settings.thresholds
        return frozenset(
            measures for measures in WATCHED if around.free(thresholds, LARGEST_CHANGE, measures)
        )

    def _looked_from(self, current: Assessment) -> bool:
        """Whether what is known is of where the robot is, and what it may do now."""
        around = self._around
        same_settings = self._settings is self._follower.settings
        return around is not None and around.current is current and same_settings

    def _begin(self, current: Assessment) -> None:
        self._settings, self._free = self._follower.settings, frozenset()
        steps = motor_steps(self._robot, self._settings.max_speed, self._period)
        self._around = Surroundings(current, steps)
