# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The closed loop: platform setpoints are met in the measured pose. No ROS here.

The pose the model is sent to is the setpoint and a correction. Every measured pose tells by how much
the robot is elsewhere than the model had it when it was measured; the correction approaches what takes
this away. Where the model is at its corrected setpoint, this is the integral of wanted minus measured:
it ends where they are the same. That the model of *then* is compared takes the delay of the measurement
out of the loop; that a measurement takes out half of the error at most keeps slow ones from overshoot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpr_core import Equilibrium, Robot
from cpr_core.errors import distinct

from ..following.goals import Goal, PoseGoal
from ..following.pose_coordinates import pose_coordinates
from ..following.supervision import State
from .loop_status import Loop, LoopStatus
from .measured_pose import MeasuredPose
from .pose_history import PoseHistory
from .several_cameras import TURN, RecentPoses

__all__ = ["LoopSettings", "PoseLoop"]

Floats = NDArray[np.float64]

#: Largest part of the error that one measured pose takes out.
_LARGEST_SHARE = 0.5
_NO_SETPOINT = "no platform setpoint"
_WAITING = {
    State.HALTED: "the robot is halted",
    State.STALE: "the setpoint is too old",
    State.ALIGNING: "motor commands are on their way to the equilibrium",
}


@dataclass(frozen=True)
class LoopSettings:
    """What may change while the node runs.

    Attributes:
        gain: Part of the error that is taken out in a second, while it is small [1/s]; 0: none.
        max_correction: Largest correction [rod lengths, rad].
        max_rate: Largest speed of the correction [rod lengths/s, rad/s].
        jump: Largest step of the measured pose beyond the motion of the platform [rod lengths, rad].
        settling: How long measured poses have to agree after a jump [s].
        timeout: Age beyond which a measured pose is stale [s]; 0: never.
    """

    gain: float
    max_correction: float
    max_rate: float
    jump: float
    settling: float
    timeout: float


class PoseLoop:
    """Corrects platform setpoints by measured poses.

    Attributes:
        coordinates: Controlled coordinates of the robot.
        settings: What may change at any time.
    """

    def __init__(self, robot: Robot, period: float, settings: LoopSettings) -> None:
        """Correct nothing yet.

        Args:
            robot: The robot.
            period: Time of a tick [s].
            settings: Gain, limits, times.
        """
        self.coordinates, self._period = pose_coordinates(robot), period
        self._history = PoseHistory(self.coordinates)
        self._several, self._recent = False, RecentPoses(self.coordinates)
        self._measured = MeasuredPose(self._history, settings.timeout)
        self._correction: Floats
        self._wanted: Floats
        self._distant: str  # why the robot is too far from the model to be corrected
        self._at_setpoint: bool
        self.forget_poses()
        self.settings = settings
        self._noted, self._noted_since = np.empty(0), math.inf
        self._made: tuple[Floats, Floats, PoseGoal] | None = None

    @property
    def settings(self) -> LoopSettings:
        """What may change at any time."""
        return self._settings

    @settings.setter
    def settings(self, settings: LoopSettings) -> None:
        self._settings = settings
        if self.coordinates.size(self._way_to(self._wanted)) > settings.max_correction:
            self._wanted = self._correction
        self._measured.watchdog.timeout = settings.timeout

    @property
    def correction(self) -> Floats:
        """Way from a setpoint to where the model is sent instead."""
        return self._way_to(self._correction)

    def _way_to(self, correction: Floats) -> Floats:
        return self.coordinates.way(self.coordinates.nowhere, correction)

    def at_rest(self, goal: Goal | None) -> bool:
        """Whether no correction of a goal is on its way."""
        return not isinstance(goal, PoseGoal) or self._wanted is self._correction

    def forget_poses(self) -> None:
        """Be as if no pose had ever been measured."""
        self.forget()
        self._measured.forget()
        self._distant, self._at_setpoint = "", False
        self._recent.forget()

    def forget(self) -> None:
        """Correct nothing until a measured pose comes."""
        # Corrections are poses: what moves one that is nowhere.
        self._correction = self._wanted = self.coordinates.nowhere

    def beyond(self, settings: LoopSettings) -> bool:
        """Whether what is corrected is more than other settings allow."""
        return self.coordinates.size(self.correction) > settings.max_correction

    def corrected(self, goal: Goal) -> Goal:
        """Where the model is sent for a goal; the goal itself where nothing is to be corrected."""
        if not isinstance(goal, PoseGoal) or self._correction is self.coordinates.nowhere:
            return goal
        made = self._made
        if made is None or made[0] is not goal.pose or made[1] is not self._correction:
            pose = self.coordinates.moved(goal.pose, self.correction)
            made = goal.pose, self._correction, goal.at(pose)
            self._made = made
        return made[2]

    def uncorrected(self, equilibrium: Equilibrium) -> Floats:
        """The setpoint that is met where the model is."""
        return self.coordinates.moved(equilibrium.pose, -self.correction)

    def refuse(self, problem: str, now: float) -> None:
        """Take note of a measured pose that is none, at a steady time [s]."""
        self._measured.refuse(problem, now)

    def take(self, pose: Floats, now: float, delay: float = 0.0, *, several: bool = False) -> None:
        """Take a measured pose.

        Args:
            pose: Controlled coordinates, as :func:`cpr_core.solve_inverse` takes them.
            now: Steady time of its receipt [s].
            delay: Time since it was measured, by its stamp [s]; negative: clocks differ.
            several: Whether there may be several who measure it.
        """
        settings, space, self._several = self.settings, self.coordinates, several
        age = self._measured.watchdog.age(now)
        if not self._measured.take(
            pose, now, delay, jump=settings.jump, settling=settings.settling, several=several
        ):
            return
        delay = max(0.0, delay)
        then, newest = self._history.at(now - delay), self._history.newest
        self._at_setpoint = False
        if then is None or newest is None:
            return
        error = space.way(then.pose, pose)
        size, self._distant = space.size(error), ""
        if size > settings.max_correction:
            told, most = distinct(size, settings.max_correction)
            self._distant = (
                f"the robot is measured {told} rod lengths or rad from where the model has it, "
                f"more than loop_max_correction {most}"
            )
        elif not then.waiting and not newest.waiting:
            # What was measured in the tick that led to it was so before the motors moved.
            self._at_setpoint = now - delay > self._noted_since + 0.5 * self._period
            if several and self._at_setpoint:
                self._recent.take(pose, error, now)
            share = min(_LARGEST_SHARE, -math.expm1(-settings.gain * max(0.0, age)))
            needed = space.moved(space.nowhere, -error)
            self._wanted = space.moved(self._wanted, share * space.way(self._wanted, needed))

    def advance(self, now: float) -> None:
        """Move the correction on by a tick, before the motors move."""
        newest = self._history.newest
        if self._wanted is self._correction or newest is None or newest.waiting:
            return
        if self._problem(now) or self._measured.jumping:
            self._wanted = self._correction
            return
        way = self.coordinates.way(self._correction, self._wanted)
        size, largest = self.coordinates.size(way), self.settings.max_rate * self._period
        if size <= largest:
            self._correction = self._wanted
        else:
            self._correction = self.coordinates.moved(self._correction, largest / size * way)

    def note(
        self, equilibrium: Equilibrium, goal: Goal | None, state: State, arrived: bool, now: float
    ) -> None:
        """Take note of what a tick led to.

        Args:
            equilibrium: Where the model is.
            goal: Where it was to go.
            state: What the node does.
            arrived: Whether the corrected goal is reached.
            now: Steady time [s].
        """
        waiting = _WAITING.get(state, "")
        if not isinstance(goal, PoseGoal):
            waiting = _NO_SETPOINT
        elif not waiting and not arrived:
            waiting = "the robot is on its way"
        wanted = goal.pose if isinstance(goal, PoseGoal) else self.coordinates.nowhere
        before = self._history.newest
        if wanted is not self._noted or waiting or before is None or before.waiting:
            self._at_setpoint, self._noted, self._noted_since = False, wanted, now
            self._recent.forget()
        self._history.add(now, equilibrium, waiting)

    def status(self, goal: Goal | None, now: float) -> LoopStatus:
        """What a supervisor is told about a goal now."""
        measured = self._measured
        age, newest = measured.watchdog.age(now), self._history.newest
        known = measured.newest is not None or bool(measured.problem)
        if not isinstance(goal, PoseGoal) or newest is None or not known:
            return LoopStatus(age=age)
        problem = self._problem(now)
        text, blind = problem or newest.waiting, bool(problem) and not self._switched_off
        errors, at_setpoint = (math.nan, math.nan), self._at_setpoint
        if measured.newest is not None:
            errors = self.coordinates.sizes(self.coordinates.way(measured.newest, goal.pose))
        apart = ""
        if self._several:
            errors, apart = self._recent.errors(goal.pose) or errors, self._recent.apart()
            at_setpoint = at_setpoint and now - self._noted_since >= TURN
        loop = Loop.FROZEN if text else Loop.CLOSED
        text = text or apart or measured.left_aside(now) or measured.clocks_differ
        return LoopStatus(loop, text, age, *errors, at_setpoint=at_setpoint, blind=blind)

    @property
    def _switched_off(self) -> bool:
        """Whether nothing is to be corrected."""
        return self.settings.gain <= 0.0 or self.settings.max_rate <= 0.0

    def _problem(self, now: float) -> str:
        """Why nothing is corrected, whatever the robot does; empty if it may be."""
        if self.settings.gain <= 0.0:
            return "loop_gain is 0"
        if self.settings.max_rate <= 0.0:
            return "loop_max_rate is 0"
        return self._measured.silent(now) or self._measured.problem or self._distant
