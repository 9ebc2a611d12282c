# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A follower with timed trajectories, and ways of the RFRFR robot for it."""

import numpy as np

from cpr_core.model.assessment import MEASURES
from cpr_ros.following import trajectory_plan
from cpr_ros.following.measured_motors import MeasuredMotors
from cpr_ros.following.motor_ways import motor_steps
from cpr_ros.following.trajectory_following import Trajectories
from cpr_ros.following.trajectory_order import TrajectoryOrder
from cpr_ros.following.trajectory_plan import TrajectoryPlan
from helpers.drive import PERIOD, Drive

WATCHED = [name for name in MEASURES if name != "inverse_singularity"]
#: A force on it that it bears where it is, but not on this way [N].
PUSH = -3.0
#: A way of the RFRFR robot straight into its instability.
DOWN = [4.0, -4.0]


class Follower(Drive):
    """A follower with trajectories."""

    def __init__(self, robot, **changed):
        super().__init__(robot, **changed)
        self.measured = MeasuredMotors(0.5)
        self.trajectories = Trajectories(robot, self.follower, PERIOD, self.measured)
        self.endings = []

    def order(self, times, ways, velocities=None, start_in=None, **given):
        """Points by the way of the motors from where they are."""
        free = np.full(self.robot.motor_count, np.inf)
        return TrajectoryOrder(
            np.array(times, float),
            self.motors + np.array(ways, float),
            velocities if velocities is None else np.array(velocities, float),
            given.get("accelerations"),
            start_in,
            given.get("path_tolerance", free),
            given.get("goal_tolerance", free),
            given.get("goal_time_tolerance", np.inf),
        )

    def take(self, *points, **given):
        endings = []
        order = self.order(*points, **given)
        motion = self.trajectories.take(order, self.current, self.now, endings.append)
        return motion, endings

    def begin(self, *points, **given):
        """The same, until it is solved, however long that takes; nothing has moved then."""
        motion, endings = self.take(*points, **given)
        while motion.goal is None:
            assert not endings
            self.tick()
        return motion, endings

    def tick(self, late=0.0):
        self.now += PERIOD + late
        self.trajectories.before_tick(self.current, self.now)
        outcome = self.follower.tick(self.current, self.loads, self.now)
        self.current = outcome.assessment
        self.outcomes.append(outcome)
        self.trajectories.after_tick(outcome, self.now)
        return outcome

    def until_ended(self, endings):
        for _ in range(4000):
            if endings:
                return endings[0]
            self.tick()
        raise AssertionError("it did not end")

    @property
    def steps(self):
        motors = [outcome.assessment.equilibrium.motors for outcome in self.outcomes]
        return np.abs(np.diff(motors, axis=0)) / motor_steps(
            self.robot, self.follower.settings.max_speed, PERIOD
        )


def in_long_strides(monkeypatch):
    """Strides of plans depend on the number of ticks only, not on how busy the machine is just then."""
    monkeypatch.setattr(trajectory_plan, "_LONGEST", 1e6)


def solved_slowly(monkeypatch, every):
    """A plan goes on by the least it can, once in so many calls; what the calls were allowed [s]."""
    in_long_strides(monkeypatch)
    allowed, advance = [], TrajectoryPlan.advance

    def slow(plan, seconds=np.inf):
        allowed.append(seconds)
        if len(allowed) % every == 0:
            advance(plan, 0.0)

    monkeypatch.setattr(TrajectoryPlan, "advance", slow)
    return allowed
