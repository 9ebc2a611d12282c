# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is to be measured and is not is missed, and what is not seen is moved slowly."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS
from helpers.session_bench import LIVE, Bench

from cpr_ros.closed_loop.loop_status import Loop, LoopStatus
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.supervision import BLIND, Action, State
from cpr_ros.operation.live_changes import apply_live
from cpr_ros.operation.starting_place import begin_at


def test_motors_that_are_measured_no_more_are_missed(bench):
    """The action was NONE, whatever the motors did."""
    session = bench.session
    apply_live(session, replace(LIVE, measured_timeout=1.5), bench.now)
    assert session.senses.unseen(bench.now) == ""  # nobody has measured them
    session.measured.refuse("names: expected motor1 motor2")
    assert "no measured motors are of use: names" in session.senses.unseen(bench.now)
    session.take_measured(np.array([2.59, 0.55]), bench.now)
    assert session.senses.unseen(bench.now + 1.5) == ""
    for later in (1.51, 100.0):  # the same words, which are not a new message every time
        why = session.senses.unseen(bench.now + later)
        assert why == "the measured motors are older than measured_timeout 1.5 s"
    apply_live(session, replace(LIVE, measured_timeout=0.0), bench.now)
    assert session.senses.unseen(bench.now + 101.0) == ""
    tracked = Bench(motor_source="measured").session
    tracked.measured.refuse("names")
    assert tracked.senses.unseen(1.0) == ""  # of these the state tells


def test_motors_that_come_again_are_measured_though_they_are_still_missed(bench):
    session, motors = bench.session, np.array([2.59, 0.55])
    apply_live(session, replace(LIVE, measured_timeout=0.5), bench.now)
    session.take_measured(motors, bench.now)
    for later, comes, missed, again in (
        (0.4, False, False, True),
        (0.6, False, True, False),
        (0.7, True, True, True),
        (1.0, True, True, True),
        (1.7, True, False, True),
    ):
        now = bench.now + later
        if comes:
            session.take_measured(motors, now)
        assert bool(session.senses.missing_motors(now)) == missed
        assert session.senses.motors_again(now) == again


def test_what_is_not_seen_is_moved_at_half_the_speed(bench):
    """A supervisor was told of half the speed, and commands went out at the whole one."""
    session = bench.session
    home = session.solver.current.equilibrium
    begin_at(session, home, home.motors, 0.0)
    apply_live(session, replace(LIVE, measured_timeout=0.5), bench.now)
    session.take_measured(home.motors, bench.now)
    bench.now += 1.0
    session.orders.follow(MotorGoal(session.robot, home.motors + 0.1), bench.now, ages=False)

    def fastest(ticks):
        sent = len(bench.commands)
        for _ in range(ticks):
            bench.tick()
        return np.abs(np.diff(bench.commands[sent:], axis=0)).max() / PERIOD

    speed = SETTINGS.max_speed
    assert fastest(8) == pytest.approx(BLIND * speed, rel=1e-6)
    session.senses.forget()
    session.take_measured(session.commands.newest, bench.now)
    assert fastest(4) == pytest.approx(speed, rel=1e-6)


def test_motors_do_not_follow_a_wrench_that_is_measured_no_more(bench):
    """A force sensor that died moved the motors by 0.3 rad, and the action was NONE."""
    session = bench.session
    home = session.solver.current.equilibrium
    begin_at(session, home, home.motors, 0.0)
    apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    session.orders.follow(PoseGoal(session.robot, home.pose), bench.now, ages=False)
    while bench.now < 1.0:
        bench.push(0.3, -0.3, 0.0)
        bench.tick()
    pushed = session.commands.newest
    assert np.abs(pushed - home.motors).max() > 1e-2
    sent = len(bench.commands)
    while bench.now < 3.0:
        bench.tick()
    assert len(bench.commands) == sent
    assert session.follower.goal is None
    why = "the external wrench is older than wrench_timeout 0.5 s and acts no more"
    assert session.follower.dropped == why
    assert session.senses.unseen(bench.now) == session.senses.missing_wrench(bench.now) == why
    session.orders.follow(PoseGoal(session.robot, home.pose), bench.now, ages=False)
    while bench.tick().state != State.IDLE:  # who wants the pose all the same has it
        pass
    np.testing.assert_allclose(session.commands.newest, home.motors, atol=1e-7)
    bench.push(0.1, 0.0, 0.0)
    assert session.senses.unseen(bench.now + 1.0) == ""
    session.orders.follow(MotorGoal(session.robot, home.motors + 0.01), bench.now, ages=False)
    end = bench.now + 1.0
    while bench.now < end:  # where motors are sent does not depend on it
        bench.tick()
    assert session.senses.missing_wrench(bench.now) == why
    np.testing.assert_allclose(session.commands.newest, home.motors + 0.01, atol=1e-9)
    assert session.follower.goal is not None


@pytest.mark.parametrize("returning", [False, True])
def test_nothing_sets_off_where_a_wrench_that_was_not_borne_is_measured_no_more(bench, returning):
    """The sensor died in a halt, and half a second later the motors went on as if nothing pushed."""
    session = bench.session
    home = session.solver.current.equilibrium
    begin_at(session, home, home.motors, 0.0)
    apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    target = home.motors + np.array([-0.5, 0.5])
    if returning:
        session.orders.follow(MotorGoal(session.robot, target), bench.now, ages=False)
        while bench.tick().state != State.IDLE:
            pass
        session.orders.reset()
    else:
        session.orders.follow(MotorGoal(session.robot, target), bench.now, ages=False)
    end = bench.now + 1.0
    while bench.now < end:
        bench.push(0.0, -60.0, 0.0)
        outcome = bench.tick()
    assert outcome.verdict.action == Action.HALT
    sent, end = len(bench.commands), bench.now + 3.0
    while bench.now < end:
        outcome = bench.tick()
    assert len(bench.commands) == sent
    assert session.follower.goal is None
    assert "external wrench is older than wrench_timeout" in session.follower.dropped
    assert session.senses.missing_wrench(bench.now) == session.follower.dropped
    assert session.follower.forgotten == session.follower.dropped
    assert session.at_rest
    # Whoever wants it all the same asks again.
    session.orders.follow(MotorGoal(session.robot, target), bench.now, ages=False)
    assert session.follower.forgotten == ""
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_allclose(session.commands.newest, target, atol=1e-9)


def test_commands_on_their_way_wait_where_a_wrench_that_was_not_borne_is_measured_no_more(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors + 0.1, 0.0)
    apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    bench.push(-500.0, 0.0, 0.0)
    assert bench.tick().state == State.ALIGNING
    while bench.now < 2.0:
        bench.tick()
    assert session.present.outcome.state == State.PAUSED
    assert bench.commands == []
    session.orders.pause(False)
    assert bench.tick().state == State.ALIGNING
    assert len(bench.commands) == 1


def test_a_wrench_that_ends_as_it_says_lets_the_robot_go_on(bench):
    """A message of none says that nothing pushes."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors, 0.0)
    apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    session.orders.follow(MotorGoal(session.robot, home.motors - 0.1), bench.now, ages=False)
    for _ in range(100):
        bench.push(0.0, -60.0, 0.0)
        outcome = bench.tick()
    assert outcome.verdict.action == Action.HALT
    bench.push(0.0, 0.0, 0.0)
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_allclose(session.commands.newest, home.motors - 0.1, atol=1e-9)


def test_motors_that_are_measured_too_seldom_are_missed_all_along(bench):
    """The action was SLOW and NONE in turn, with every message, and the log told of each."""
    session = bench.session
    apply_live(session, replace(LIVE, measured_timeout=0.5), bench.now)
    missed = []
    for twentieth in range(100):
        if twentieth % 20 == 0:
            session.take_measured(np.array([2.59, 0.55]), bench.now)
        missed.append(bool(session.senses.unseen(bench.now)))
        bench.now += 0.05
    assert missed == 11 * [False] + 89 * [True]
    session.stand()
    assert session.senses.unseen(bench.now) == ""


def test_a_correction_that_is_frozen_is_missed_only_for_want_of_a_pose(bench, monkeypatch):
    for status, unseen in (
        (LoopStatus(Loop.CLOSED), ""),
        (LoopStatus(Loop.FROZEN, "the robot is on its way"), ""),
        (LoopStatus(Loop.FROZEN, "the pose jumped", blind=True), "the pose jumped"),
    ):
        monkeypatch.setattr(bench.session.loop, "status", lambda goal, now, told=status: told)
        assert bench.session.senses.unseen(bench.now) == unseen
    monkeypatch.setattr(bench.session.loop, "status", lambda goal, now: LoopStatus(Loop.CLOSED))
    assert bench.session.senses.unseen(bench.now + 0.5).startswith("the pose jumped; it came again")
    monkeypatch.setattr(bench.session.loop, "status", lambda goal, now: LoopStatus(Loop.OPEN))
    assert bench.session.senses.unseen(bench.now + 0.5) == ""  # nobody asks where the platform is
    monkeypatch.setattr(bench.session.loop, "status", lambda goal, now: LoopStatus(Loop.CLOSED))
    assert bench.session.senses.unseen(bench.now + 0.5) == ""
