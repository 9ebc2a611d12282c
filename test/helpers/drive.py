# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots and settings for tests of what the node decides, without ROS."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

import cpr_core
from cpr_core import solve_home
from cpr_core.model.assessment import DEFAULT_THRESHOLDS, Assessment
from cpr_ros.following.goals import PoseGoal
from cpr_ros.following.motion_settings import Settings
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.following.supervision import State
from helpers.yaml_content import shipped_content

PERIOD = 0.005
THRESHOLDS = dict(DEFAULT_THRESHOLDS)
SETTINGS = Settings(THRESHOLDS, hysteresis=0.1, max_speed=1.0, setpoint_timeout=0.0)


@functools.cache
def robot(name: str) -> cpr_core.Robot:
    return cpr_core.load_robot(name)


def changed_robot(name: str, change) -> cpr_core.Robot:
    """A shipped robot with a changed description."""
    content = shipped_content(name)
    change(content)
    return cpr_core.load_robot(content)


def uncontrolled_robot() -> cpr_core.Robot:
    """The RFRFR robot with one more motor, and no inverse problem."""

    def change(content):
        content["controlled"] = []
        content["legs"].append(content["legs"][0])
        content["home"]["motors"].append(content["home"]["motors"][0])

    return changed_robot("rfrfr", change)


def unstable_robot() -> cpr_core.Robot:
    """The RFRFR robot with an unstable home: its rods are bent in waves, as nothing holds them."""

    def change(content):
        strain = [[-2.902, 5.086, -2.887, 0.592, 0.383], [-2.661, -4.84, 6.916, 2.141, -0.969]]
        content["home"] = {
            "motors": content["home"]["motors"],
            "strain": [{"bending_3": series} for series in strain],
            "platform": {"position": [0.546, 0.133, 0.0]},
        }

    return changed_robot("rfrfr", change)


def motorless_robot() -> cpr_core.Robot:
    """A rod of the RFRFR robot that is welded to the ground."""

    def change(content):
        del content["legs"][1]
        content["legs"][0]["motor"] = {"type": "welded"}
        content |= {"controlled": [], "home": {"motors": [], "bow": "left"}}

    return changed_robot("rfrfr", change)


class Drive:
    """A follower, where it is, and a clock that goes one period a tick."""

    def __init__(self, robot: cpr_core.Robot, **settings) -> None:
        self.robot = robot
        self.follower = SetpointFollower(robot, PERIOD, replace(SETTINGS, **settings))
        self.current = Assessment(solve_home(robot))
        self.loads = solve_home(robot).loads
        self.now = 0.0
        self.outcomes = []

    def follow(self, goal):
        self.follower.follow(goal, self.now)

    def tick(self):
        self.now += PERIOD
        outcome = self.follower.tick(self.current, self.loads, self.now)
        self.current = outcome.assessment
        self.outcomes.append(outcome)
        return outcome

    def until(self, done, ticks=4000):
        for _ in range(ticks):
            outcome = self.tick()
            if done(outcome):
                return outcome
        raise AssertionError(f"not within {ticks} ticks: {self.outcomes[-1].verdict}")

    def until_state(self, state: State, ticks=4000):
        return self.until(lambda outcome: outcome.state == state, ticks)

    @property
    def position(self):
        return self.current.equilibrium.platform_position

    @property
    def motors(self):
        return self.current.equilibrium.motors


def to(drive, *pose):
    """Send the platform of a drive to a pose."""
    drive.follow(PoseGoal(drive.robot, pose))


def steps_of(drive):
    """How far motors went in every tick, (ticks - 1, motors)."""
    motors = np.array([outcome.assessment.equilibrium.motors for outcome in drive.outcomes])
    return np.abs(np.diff(motors, axis=0))
