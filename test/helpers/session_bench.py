# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A session without the node: its clock, what is asked of it, and the commands it gives."""

from dataclasses import replace

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.srv import SolveForward
from sensor_msgs.msg import JointState

from cpr_ros.following.trajectory_order import TrajectoryOrder
from cpr_ros.messages.equilibrium_messages import fill_equilibrium
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.between_ticks import BetweenTicks
from cpr_ros.operation.session import Session
from cpr_ros.operation.starting_place import begin_at
from cpr_ros.settings.node_settings import Parameters, live_parameters
from cpr_ros.settings.parameter_table import PARAMETERS
from helpers.drive import PERIOD, SETTINGS, robot

FIXED = {parameter.name: parameter.default for parameter in PARAMETERS if not parameter.live}
FIXED["characteristic_length"] = None
DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}
LIVE = replace(
    live_parameters(DEFAULTS.__getitem__),
    settings=SETTINGS,
    wrench_timeout=0.0,
    measured_timeout=0.0,
)


def ticked(session, now):
    """A tick of a session: what it led to, and the last command that left in it; None: none did."""
    commands = []
    outcome = session.tick(now, lambda command, ahead: commands.append(command))
    return outcome, commands[-1] if commands else None


class Bench:
    """A session, its clock, and the commands it gives; those that left before they were solved."""

    def __init__(self, **parameters):
        self.session = Session(
            robot("rfrfr"), Frames("base", "platform"), Parameters(**FIXED | parameters), LIVE
        )
        self.now, self.commands, self.ahead = 0.0, [], []

    def push(self, *force):
        loads = self.session.solver.current.equilibrium.loads
        self.session.wrench.take(loads.with_(wrench_world=[0, 0, 0, *force]), self.now)

    def tick(self):
        self.now += PERIOD
        return self.session.tick(self.now, self._send)

    def _send(self, command, ahead):
        self.commands.append(command)
        self.ahead += [command] if ahead else []

    def look(self, now, resting):
        """What the node does between ticks; when it is to be done again."""
        between = BetweenTicks(self.session, lambda: resting)
        between.look(now)
        return between.due

    def rest(self, seconds=0.2):
        """Tick where ticks change anything, and look around between them."""
        end = self.now + seconds
        while self.now < end:
            self.now += PERIOD
            if not self.session.at_rest:
                self.session.tick(self.now, self._send)
            self.look(self.now, self.session.at_rest)


def still(session, motors, now, seconds=0.5, told=lambda ending: None):
    """Some time at the same motors."""
    nothing = np.full(2, np.inf)
    times, points = np.array([0.0, seconds]), np.array([motors, motors])
    order = TrajectoryOrder(times, points, None, None, None, nothing, nothing, np.inf)
    return session.orders.follow_trajectory(order, now, told)


def stop(session, now):
    """The usual stop of a client of trajectories: one without points."""
    endings, nothing = [], np.full(2, np.inf)
    order = TrajectoryOrder(
        np.empty(0), np.empty((0, 2)), None, None, None, nothing, nothing, np.inf
    )
    session.orders.follow_trajectory(order, now, endings.append)
    return [ending.val for ending in endings]


def apply(session, *motors, start=None):
    """Make the equilibrium at these motors the current one, continued from another one than that."""
    state = JointState(name=["motor1", "motor2"], position=motors)
    request = SolveForward.Request(motors=state, apply=True)
    if start is not None:
        message, frames = EquilibriumMessage(), session.solver.frames
        fill_equilibrium(message, start, frames, Time(), 0.0, eigenvalues=False)
        request.start, request.start_equilibrium = request.START_GIVEN, [message]
    session.solver.forward(request)


def commanded(session, motors):
    """Of which it is known where its motors are."""
    begin_at(session, session.solver.current.equilibrium, motors, 0.0)


def measured_for(bench, motors, seconds=1.0):
    """Measured motors ten times a second; whether the robot had to begin there."""
    begin = False
    for _ in range(round(10 * seconds)):
        bench.now += 0.1
        begin = begin or bench.session.take_measured(np.array(motors), bench.now)
        bench.tick()
    return begin


def waiting(bench, seconds, way=0.0):
    """A trajectory that begins later, and how it ends."""
    session, home, endings = bench.session, bench.session.solver.current.equilibrium, []
    commanded(session, home.motors)
    any_error, points = np.full(2, np.inf), np.array([home.motors, home.motors + way])
    times = np.array([0.0, 0.5])
    order = TrajectoryOrder(times, points, None, None, seconds, any_error, any_error, np.inf)
    session.orders.follow_trajectory(order, bench.now, endings.append)
    return endings


def timed(points, start_in):
    """A trajectory with a stamp, a point a second."""
    points, nothing = np.array(points), np.full(2, np.inf)
    times = np.arange(1.0, len(points) + 1.0)
    return TrajectoryOrder(times, points, None, None, start_in, nothing, nothing, np.inf)
