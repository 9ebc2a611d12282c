# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Jogging: a twist moves the platform setpoint, as long as twists come. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, InvalidRequest, Robot
from cpr_core.lie import turned

from ..following.goals import PoseGoal
from ..following.pose_coordinates import pose_coordinates
from ..following.watchdog import Watchdog
from .pose_loop import PoseLoop

__all__ = ["JogGoal", "Jogger", "PlatformTwist"]

Floats = NDArray[np.float64]

#: Faster twists count as this one, in their direction [rad/s, m/s].
_FASTEST = 1e6
#: Farthest the setpoint goes in a tick [rod lengths, rad]; the motors are never that fast.
_LONGEST = 0.05


@dataclass(frozen=True)
class PlatformTwist:
    """Velocity of the platform at its origin.

    Attributes:
        twist: [omega; v], (6,) [rad/s, m/s].
        in_platform: Whether its axes turn with the platform; else they are those of the base frame.
    """

    twist: Floats
    in_platform: bool

    @property
    def rests(self) -> bool:
        """Whether it moves nothing."""
        return not self.twist.any()

    def in_base(self, rotation: Floats) -> Floats:
        """The twist in the base frame, (6,), of a platform with a rotation, (3, 3)."""
        return turned(self.twist, rotation) if self.in_platform else self.twist


class JogGoal(PoseGoal):
    """A platform setpoint that twists move on."""

    driven = True


class Jogger:
    """Moves a platform setpoint by the newest twist.

    The setpoint of a tick is a tick's way ahead of the robot: it never runs away from a robot that is
    slower, or halted, and a halted robot goes back as soon as the twist leads back.

    Attributes:
        watchdog: Age of the newest twist.
    """

    def __init__(self, robot: Robot, period: float, loop: PoseLoop, timeout: float) -> None:
        """Jog nothing yet.

        Args:
            robot: The robot.
            period: Time of a tick [s].
            loop: Corrects the setpoint.
            timeout: Age beyond which a twist moves nothing [s].
        """
        self.robot, self.watchdog = robot, Watchdog(timeout)
        self._coordinates, self._period, self._loop = pose_coordinates(robot), period, loop
        self._goal: JogGoal | None = None
        self._twist = PlatformTwist(np.zeros(6), in_platform=False)
        self._moving, self._new = False, False
        self._last = self._elapsed = 0.0
        self._from: Equilibrium | None = None

    def drives(self, goal: object) -> bool:
        """Whether a goal is the one that twists move."""
        return goal is not None and goal is self._goal

    def at_rest(self, goal: object) -> bool:
        """Whether a goal stays where it is until another twist comes."""
        return not self.drives(goal) or not (self._moving or self._new)

    def begin(self, equilibrium: Equilibrium, now: float) -> JogGoal:
        """A setpoint where the robot is, to be moved on.

        Raises:
            InvalidRequest: The robot has no inverse problem.
        """
        self._goal = JogGoal(self.robot, self._loop.uncorrected(equilibrium))
        self._moving, self._last, self._from = False, now, None
        return self._goal

    def check_told(self, twist: PlatformTwist, equilibrium: Equilibrium) -> None:
        """Whether what the robot controls tells a twist: what it does not tell would be lost.

        Raises:
            InvalidRequest: Its angles do not, where the model is.
        """
        rotation = equilibrium.platform_rotation
        if untold := self._coordinates.untold(twist.in_base(rotation), rotation):
            raise InvalidRequest("twist", untold)

    def take(self, twist: PlatformTwist, now: float) -> None:
        """Take a twist; the newest counts."""
        # Beyond what any robot does the direction counts, whatever numbers come.
        largest = float(np.abs(twist.twist).max())
        self._twist = replace(twist, twist=twist.twist / max(1.0, largest / _FASTEST))
        self.watchdog.feed(now)
        self._new = True

    def advance(self, equilibrium: Equilibrium, arrived: bool, now: float) -> None:
        """Move the setpoint on by a tick, before the correction and the motors move.

        Args:
            equilibrium: Where the model is.
            arrived: Whether this is where the setpoint sent it.
            now: Steady time [s].
        """
        goal = self._goal
        # Ticks may be farther apart than a twist is obeyed.
        longest = min(self._period, self.watchdog.timeout or self._period)
        elapsed, self._last = min(longest, max(0.0, now - self._last)), now
        if equilibrium is self._from and not arrived:
            # It did not move: what is asked of it again need not be solved again.
            elapsed = max(elapsed, self._elapsed)
        self._from, self._elapsed = equilibrium, elapsed
        moving = not (self._twist.rests or self.watchdog.stale(now))
        ended, self._moving, self._new = self._moving and not moving, moving, False
        if goal is None or not (moving or ended):
            return
        if not arrived:
            goal.pose = self._loop.uncorrected(equilibrium)
        if moving:
            goal.pose = self._coordinates.moved(goal.pose, self._step(equilibrium, elapsed))

    def _step(self, equilibrium: Equilibrium, elapsed: float) -> Floats:
        rotation = equilibrium.platform_rotation
        twist = self._twist.in_base(rotation)
        way = elapsed * self._coordinates.velocity(twist, rotation)
        size = self._coordinates.size(way)
        return way if size <= _LONGEST else _LONGEST / size * way
