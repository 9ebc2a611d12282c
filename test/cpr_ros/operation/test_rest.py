# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""When the robot is at rest: a tick would change nothing. Whatever comes ends it."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, robot
from helpers.session_bench import ticked

from cpr_core import solve_forward
from cpr_core.model.assessment import Assessment
from cpr_ros.closed_loop.jogging import PlatformTwist
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.supervision import Action, State
from cpr_ros.following.trajectory_order import TrajectoryOrder
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.live_changes import apply_live
from cpr_ros.operation.session import Session
from cpr_ros.settings.node_settings import Parameters, live_parameters
from cpr_ros.settings.parameter_table import PARAMETERS

DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}
HOME = np.array([2.59, 0.55])


class Node:
    """A session that ticks until it is at rest, and a clock."""

    def __init__(self, **parameters):
        self.live = live_parameters(DEFAULTS.__getitem__)
        fixed = {
            parameter.name: parameter.default for parameter in PARAMETERS if not parameter.live
        }
        fixed |= {"robot": "rfrfr", "characteristic_length": None, **parameters}
        frames = Frames("base", "platform", lambda frame: None)
        self.session = Session(robot("rfrfr"), frames, Parameters(**fixed), self.live)
        self.session.commands.place(HOME)
        self.now = 0.0
        self.rest()

    def set(self, **settings):
        self.live = replace(self.live, settings=replace(self.live.settings, **settings))
        apply_live(self.session, self.live, self.now)

    def move_to(self, *motors):
        self.session.orders.follow(MotorGoal(self.session.robot, motors), self.now)

    def push(self, force, timeout):
        self.live = replace(self.live, wrench_timeout=timeout)
        apply_live(self.session, self.live, self.now)
        loads = self.session.solver.current.equilibrium.loads
        self.session.wrench.take(loads.with_(wrench_world=[0, 0, 0, force, 0, 0]), self.now)

    def tick(self):
        self.now += PERIOD
        return ticked(self.session, self.now)[1]

    def rest(self, ticks=2000):
        """Tick until it is at rest; then more ticks, at any later time, change nothing."""
        count = 0
        while not self.session.at_rest:
            self.tick()
            count += 1
            assert count < ticks, self.session.present.outcome
        before = self.session.present.outcome
        for later in (0.0, 1.0, 100.0):
            self.now += later
            assert self.tick() is None
            after = self.session.present.outcome
            assert after.assessment is before.assessment
            assert (after.state, after.verdict, after.moved) == (
                before.state,
                before.verdict,
                False,
            )
            assert not self.session.present.velocity.any()
            assert self.session.at_rest
        return count


@pytest.fixture
def node():
    return Node()


def test_a_setpoint_ends_it_until_it_is_reached(node):
    node.move_to(2.60, 0.56)
    assert not node.session.at_rest
    assert node.rest() >= 3  # two steps, and one that finds it there
    np.testing.assert_array_equal(node.session.commands.newest, [2.60, 0.56])
    pose = node.session.solver.current.equilibrium.pose + 0.001
    node.session.orders.follow(PoseGoal(node.session.robot, pose), node.now)
    node.rest()
    np.testing.assert_allclose(node.session.solver.current.equilibrium.pose, pose, atol=1e-9)


def test_a_setpoint_that_is_stale_is_rest(node):
    node.set(setpoint_timeout=0.1)
    node.move_to(3.0, 0.3)
    node.rest()
    assert node.session.present.outcome.state == State.STALE
    held = node.session.commands.newest
    node.set(setpoint_timeout=0.0)  # which starts no motion: the setpoint is forgotten
    assert not node.session.at_rest
    node.rest()
    assert node.session.present.outcome.state == State.IDLE
    np.testing.assert_array_equal(node.session.commands.newest, held)


def test_a_robot_that_is_halted_goes_on_trying(node):
    node.session.orders.follow(PoseGoal(node.session.robot, [0.0, -0.3]), node.now)
    while node.session.present.outcome.state != State.HALTED:
        node.tick()
    for _ in range(20):
        node.tick()
        assert not node.session.at_rest


def test_pause_reset_and_release_are_acted_on(node):
    node.move_to(2.8, 0.4)
    node.rest()
    for change, state in (
        (lambda: node.session.orders.pause(True), State.PAUSED),
        (lambda: node.session.orders.pause(False), State.IDLE),
        (node.session.orders.reset, State.IDLE),
    ):
        change()
        assert not node.session.at_rest
        node.rest()
        assert node.session.present.outcome.state == state
    np.testing.assert_allclose(node.session.commands.newest, HOME, atol=1e-9)


def test_new_thresholds_are_judged_by_at_once(node):
    margin = node.session.present.outcome.assessment.margin
    thresholds = dict(node.live.settings.thresholds)
    thresholds["margin"] = replace(thresholds["margin"], warning=2 * margin, stop=1.5 * margin)
    node.set(thresholds=thresholds)
    assert not node.session.at_rest
    node.rest()
    assert node.session.present.outcome.verdict.action != Action.NONE


def test_a_wrench_ends_it_until_it_is_gone(node):
    node.push(0.05, timeout=0.5)
    assert not node.session.at_rest
    assert node.rest() >= 100
    assert node.session.wrench.watchdog.age(node.now) == -1.0
    assert not node.session.solver.current.equilibrium.loads.wrench_world.any()


def test_a_wrench_without_a_timeout_is_rest_when_it_is_borne(node):
    node.push(0.05, timeout=0.0)
    assert not node.session.at_rest
    assert node.rest() < 5
    assert node.session.solver.current.equilibrium.loads.wrench_world[3] == 0.05
    node.live = replace(node.live, wrench_timeout=0.5)
    apply_live(node.session, node.live, node.now)
    assert not node.session.at_rest
    node.rest()
    assert not node.session.solver.current.equilibrium.loads.wrench_world.any()


def test_commands_lead_to_a_solution_that_was_applied(node):
    found = solve_forward(node.session.robot, [2.65, 0.60])
    node.session.solver.current = Assessment(found)
    assert not node.session.at_rest
    node.tick()
    assert node.session.present.outcome.state == State.ALIGNING
    node.rest()
    np.testing.assert_array_equal(node.session.commands.newest, [2.65, 0.60])


def test_a_twist_ends_it_until_it_is_old(node):
    session, timeout = node.session, node.session.jogger.watchdog.timeout
    for twist in np.multiply.outer([0.0, 0.02, -0.02], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]):
        start = session.solver.current.equilibrium.platform_position
        session.orders.jog(PlatformTwist(twist, in_platform=False), node.now)
        assert session.at_rest == (not twist.any())
        node.rest()
        way = session.solver.current.equilibrium.platform_position - start
        assert way == pytest.approx(timeout * twist[3:], abs=1.01 * PERIOD * 0.02)


def test_a_correction_ends_it_until_it_is_made(node):
    session = node.session
    setpoint = session.solver.current.equilibrium.pose + 0.001
    session.orders.follow(PoseGoal(session.robot, setpoint), node.now)
    node.rest()
    measured = setpoint + [0.002, 0.0]
    session.loop.take(measured, node.now)
    node.now += 1.0
    node.tick()
    session.loop.take(measured, node.now)
    assert not session.at_rest
    node.rest()
    assert session.solver.current.equilibrium.pose[0] < setpoint[0] - 1e-4


def test_a_trajectory_ends_it_until_its_last_point(node):
    """One that takes several ticks to be solved."""
    free, times = np.full(2, np.inf), np.linspace(0.2, 10.0, 50)
    positions = HOME + np.random.default_rng(0).uniform(-0.05, 0.05, (50, 2))
    order = TrajectoryOrder(times, positions, None, None, 0.5, free, free, np.inf)
    endings = []
    node.session.orders.follow_trajectory(order, node.now, endings.append)
    assert not node.session.at_rest
    assert node.rest(ticks=3000) >= 10.5 / PERIOD
    assert len(endings) == 1
    np.testing.assert_allclose(node.session.commands.newest, positions[-1], atol=1e-9)


def test_a_wrench_ends_it_for_measured_motors_too_until_it_is_gone():
    node = Node(motor_source="measured")
    node.session.tracking.take(HOME, node.now)
    timeout = 2.0 * node.live.measured_timeout
    node.push(0.05, timeout)
    assert node.rest() >= timeout / PERIOD
    assert node.session.wrench.watchdog.age(node.now) == -1.0


def test_measured_motors_end_it_until_they_are_old():
    node = Node(motor_source="measured")
    tracking = node.session.tracking
    tracking.take([2.65, 0.60], node.now)
    for _ in range(10):
        assert not node.session.at_rest
        node.tick()
    assert node.session.present.outcome.state == State.TRACKING
    node.rest()
    assert node.session.present.outcome.state == State.STALE
    node.live = replace(node.live, measured_timeout=0.0)
    apply_live(node.session, node.live, node.now)
    assert not node.session.at_rest
    node.tick()
    assert node.session.present.outcome.state == State.TRACKING
