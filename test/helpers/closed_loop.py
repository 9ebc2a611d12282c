# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A node's session and a robot that is not as described, with given times and without ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from cpr_core.model.assessment import Threshold
from cpr_ros.closed_loop.loop_status import Loop, LoopStatus
from cpr_ros.following.goals import PoseGoal
from cpr_ros.following.motor_ways import motor_steps
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.session import Session
from cpr_ros.operation.starting_place import begin_at
from cpr_ros.settings.node_settings import LiveParameters, Parameters, live_parameters
from cpr_ros.settings.parameter_table import PARAMETERS
from helpers.drive import THRESHOLDS, robot
from helpers.soft_robot import SoftRobot

#: Of a tick: longer than a node has it by default, so that seconds are soon over.
PERIOD = 0.02
DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}
FIXED = {parameter.name: parameter.default for parameter in PARAMETERS if not parameter.live}
FRAMES = Frames("base", "platform")
#: A setpoint of the planar robot [m], and how much longer than a tick's way a step may be told.
TARGET, SLACK = np.array([0.05, 0.75]), 1.0 + 2e-5


def live(**changed: float) -> LiveParameters:
    """Live parameters, some of them changed."""
    return live_parameters(lambda name: changed.get(name, DEFAULTS[name]))


class ClosedLoop:
    """A session, the robot it commands, and a camera that measures it."""

    def __init__(self, name: str, payload: list[float] | None = None, **parameters: float) -> None:
        self.robot = robot(name)
        fixed = Parameters(**FIXED | {"tick_rate": 1.0 / PERIOD, "characteristic_length": None})
        self.session = Session(self.robot, FRAMES, fixed, live(**parameters))
        begin_at(self.session, self.model, self.model.motors, 0.0)
        self.real = SoftRobot(name, payload)
        self.now, self.longest_step, self.states = 100.0, 0.0, []
        # The camera: time between pictures, their delay, whether it tells it, whether there are several,
        # what it makes of a pose.
        self.every, self.delay, self.stamped, self.several = 0.02, 0.0, True, False
        self.seen: Callable[[np.ndarray], np.ndarray | None] = lambda pose: pose
        self.next_picture, self._pictures = self.now, deque()

    @property
    def model(self):
        return self.session.solver.current.equilibrium

    @property
    def status(self) -> LoopStatus:
        return self.session.loop_status(self.now)

    def error(self, pose) -> float:
        """How far the real robot is from a pose [rod lengths, rad]."""
        space = self.session.loop.coordinates
        return space.size(space.way(self.real.equilibrium.pose, np.asarray(pose, float)))

    def follow(self, pose) -> None:
        self.session.orders.follow(PoseGoal(self.robot, pose), self.now)

    def tick(self) -> None:
        self.now += PERIOD
        self._measure()
        before, speed = self.session.commands.newest, self.session.follower.settings.max_speed

        def send(command, ahead):
            step = np.abs(command - before) / motor_steps(self.robot, speed, PERIOD)
            self.longest_step = max(self.longest_step, float(step.max()))
            self.real.move_to(command)

        self.states.append(self.session.tick(self.now, send).state)
        current = self.session.solver.current
        for name in ("margin", "motor_range", "effort_reserve"):
            threshold: Threshold = THRESHOLDS[name]
            assert current.value(name) >= threshold.stop, name

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD)):
            self.tick()

    def _measure(self) -> None:
        if self.every and self.now >= self.next_picture - 1e-9:
            self.next_picture += self.every
            self._pictures.append((self.now, self.seen(self.real.equilibrium.pose)))
        while self._pictures and self.now >= self._pictures[0][0] + self.delay - 1e-9:
            taken, pose = self._pictures.popleft()
            if pose is not None:
                late = self.stamped * (self.now - taken)
                self.session.loop.take(pose, self.now, late, several=self.several)


def frozen(bench, seconds, text):
    """Nothing is corrected for a time, and the stream says why."""
    bench.tick()
    before, motors = bench.session.loop.correction, bench.model.motors
    bench.run(seconds)
    np.testing.assert_array_equal(bench.session.loop.correction, before)
    np.testing.assert_allclose(bench.model.motors, motors, rtol=0.0, atol=1e-8)
    assert bench.status.loop == Loop.FROZEN
    assert text in bench.status.text
    assert bench.status.blind == (not text.startswith("loop_"))
    assert bench.longest_step <= SLACK
