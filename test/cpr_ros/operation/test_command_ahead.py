# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The first command out of rest goes out before it is solved, where it is judged already."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS
from helpers.session_bench import LIVE, Bench, measured_for

from cpr_core import solve_inverse
from cpr_ros.closed_loop.jogging import PlatformTwist
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.judged_steps import JudgedSteps
from cpr_ros.following.steps import Undecided
from cpr_ros.following.supervision import Refusal, State
from cpr_ros.operation.live_changes import apply_live


def test_the_first_command_out_of_rest_is_ahead_of_its_solution_and_the_only_one(node):
    session, random = node.session, np.random.default_rng(11)
    for _ in range(20):
        target = session.solver.current.equilibrium.motors + random.uniform(-0.02, 0.02, 2)
        session.orders.follow(MotorGoal(session.robot, target), node.now)
        before, sent, session.unplaced = session.commands.newest, len(node.commands), True
        assert node.tick().obeyed
        assert len(node.commands) == sent + 1
        assert not session.unplaced
        np.testing.assert_array_equal(node.ahead[-1], session.solver.current.equilibrium.motors)
        np.testing.assert_array_equal(node.commands[-1], node.ahead[-1])
        assert np.abs(node.ahead[-1] - before).max() <= PERIOD * (1.0 + 1e-6)
        node.rest()
        np.testing.assert_array_equal(node.commands[-1], target)
    assert len(node.ahead) == 20  # in motion none is


def test_the_first_command_towards_a_pose_is_ahead_of_its_solution_too(node):
    session, random = node.session, np.random.default_rng(12)
    robot = session.robot
    for number in range(1, 21):
        pose = session.solver.current.equilibrium.pose + random.uniform(-0.01, 0.01, 2)
        session.orders.follow(PoseGoal(robot, pose), node.now)
        before, sent = session.commands.newest, len(node.commands)
        assert node.tick().obeyed
        assert len(node.commands) == sent + 1
        assert len(node.ahead) == number
        np.testing.assert_array_equal(node.ahead[-1], session.solver.current.equilibrium.motors)
        np.testing.assert_array_equal(node.commands[-1], node.ahead[-1])
        assert np.abs(node.ahead[-1] - before).max() <= PERIOD * (1.0 + 1e-6)
        node.rest()
        there = solve_inverse(robot, pose, start=session.solver.current.equilibrium).motors
        np.testing.assert_allclose(node.commands[-1], there, rtol=0.0, atol=1e-9)
    assert len(node.ahead) == 20


def test_a_goal_that_moves_in_the_tick_is_solved_first(node, monkeypatch):
    session, pose = node.session, node.session.solver.current.equilibrium.pose
    session.orders.follow(PoseGoal(session.robot, pose + 0.001), node.now)
    with monkeypatch.context() as patched:
        patched.setattr(session.loop, "at_rest", lambda goal: False)  # a correction is on its way
        node.tick()
    assert (len(node.ahead), len(node.commands)) == (0, 1)
    node.rest(1.0)
    session.orders.follow(PoseGoal(session.robot, pose), node.now)
    node.tick()
    assert len(node.ahead) == 1
    node.rest(1.0)
    twist = PlatformTwist(np.array([0.0, 0.0, 0.0, 0.01, 0.0, 0.0]), in_platform=False)
    session.orders.jog(twist, node.now)
    sent = len(node.commands)
    node.tick()
    assert (len(node.ahead), len(node.commands)) == (1, sent + 1)


@pytest.mark.parametrize("behind", [0.0, PERIOD])
def test_a_first_command_that_motors_hold_up_is_solved_first(node, behind):
    """Half of it went out ahead, and the robot was then to wait until the other half could follow."""
    session, home = node.session, node.session.solver.current.equilibrium.motors
    session.commands.max_lead = 1.5 * PERIOD
    session.take_measured(home - behind * SETTINGS.max_speed, node.now)
    session.orders.follow(MotorGoal(session.robot, home + 0.1), node.now)
    assert node.tick().state == State.FOLLOWING
    assert len(node.ahead) == (behind == 0.0)
    assert node.tick().state == State.FOLLOWING
    way = (node.commands[-1] - home).max() + behind * SETTINGS.max_speed
    assert 0.98 * 1.5 * PERIOD <= way <= 1.5 * PERIOD * (1.0 + 1e-5)


@pytest.mark.parametrize("given", ["motors", "pose"])
def test_the_same_commands_go_out_with_and_without_looking_ahead(node, given):
    plain = Bench()
    start = plain.session.solver.current.equilibrium
    home = start.motors
    plain.session.commands.place(home)
    for bench in (plain, node):
        goals = {
            "motors": MotorGoal(bench.session.robot, home + [0.3, -0.2]),
            "pose": PoseGoal(bench.session.robot, start.pose + [0.1, -0.05]),
        }
        bench.session.orders.follow(goals[given], bench.now)
        while bench.tick().state != State.IDLE:
            pass
    assert len(node.ahead) == 1
    np.testing.assert_array_equal(node.commands, plain.commands)


@pytest.mark.parametrize("refused", [False, True])
def test_it_is_not_waited_for_that_the_robot_is_solved_and_remembered(node, monkeypatch, refused):
    """Another command does, as one that leads back."""
    session, events = node.session, []
    session.orders.follow(MotorGoal(session.robot, session.commands.newest + 0.1), node.now)
    if refused:
        unsolved = Undecided("not_converged", "for a test")
        monkeypatch.setattr(JudgedSteps, "_danger", lambda *_: unsolved)
    session.tick(
        node.now,
        lambda command, ahead: events.append("ahead" if ahead else "after"),
        lambda: events.append("kept"),
    )
    assert events == ["ahead", "kept"] + ["after"] * refused


def test_a_first_step_that_is_refused_after_all_is_taken_back(node, monkeypatch):
    session, home = node.session, node.session.solver.current.equilibrium.motors
    session.orders.follow(MotorGoal(session.robot, home + 0.1), node.now)
    refused = Undecided("not_converged", "for a test")
    with monkeypatch.context() as patched:
        patched.setattr(JudgedSteps, "_danger", lambda *_: refused)
        for _ in range(30):
            node.tick()
        np.testing.assert_array_equal(session.solver.current.equilibrium.motors, home)
        np.testing.assert_array_equal(session.commands.newest, home)
        assert session.present.outcome.state == State.HALTED
    assert len(node.ahead) == 1
    ways = np.abs(np.diff([home, *node.commands], axis=0))
    assert ways.max() <= PERIOD * (1.0 + 1e-6)
    while node.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(node.commands[-1], home + 0.1)


@pytest.mark.parametrize(
    "happens",
    [
        lambda node: node.push(0.2, 0.0, 0.0),
        lambda node: node.session.orders.pause(True),
        lambda node: node.session.commands.place(None),
        lambda node: measured_for(node, node.session.commands.newest + 0.5, 0.4),
        lambda node: node.session.commands.place(node.session.commands.newest + 0.001),
        lambda node: apply_live(
            node.session, replace(LIVE, settings=replace(SETTINGS, max_speed=2.0)), node.now
        ),
    ],
    ids=["wrench", "pause", "unknown", "moved by others", "on the way", "parameters"],
)
def test_what_has_happened_since_it_looked_around_is_solved_first(node, happens):
    session = node.session
    goal = MotorGoal(session.robot, session.solver.current.equilibrium.motors + 0.01)
    happens(node)
    session.follower.follow(goal, node.now)
    node.tick()
    assert node.ahead == []


def test_a_halted_robot_is_solved_first(node):
    session = node.session
    session.present.outcome = replace(
        session.present.outcome, refusal=Refusal("margin", "for a test")
    )
    session.orders.follow(MotorGoal(session.robot, session.commands.newest + 0.01), node.now)
    node.tick()
    assert node.ahead == []


def test_who_tracks_motors_or_is_paused_does_not_look_around(node):
    tracked = Bench(motor_source="measured")
    assert math.isinf(tracked.look(1.0, resting=True))
    assert math.isinf(tracked.session.first_step.due)
    node.session.orders.pause(True)
    node.look(node.now, resting=True)
    assert math.isinf(node.session.first_step.due)
    node.session.orders.pause(False)
    apply_live(node.session, replace(LIVE, settings=replace(SETTINGS, max_speed=2.0)), node.now)
    assert node.look(node.now, resting=True) == node.session.first_step.due > node.now
    node.look(node.now, resting=False)  # it moves, or is not active
    assert math.isinf(node.session.first_step.due)
