# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Commands wait for motors that are measured too far behind, or are measured no more."""

from dataclasses import replace

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD, SETTINGS
from helpers.session_bench import LIVE, apply, commanded, waiting

from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.standstill import GONE_ON
from cpr_ros.following.supervision import BLIND, Action, State
from cpr_ros.operation.live_changes import apply_live


def measured_off(bench, off, ticks):
    """Ticks in which motors are measured where they were sent, but for an offset."""
    for _ in range(ticks):
        bench.session.take_measured(bench.session.commands.newest + off, bench.now)
        bench.tick()


def lagging(bench, target, max_lead, time_constant, ticks):
    """Follow a setpoint with motors that lag; ways of commands from where they were measured last."""
    session, motors = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, max_lead=max_lead), bench.now)
    commanded(session, motors)
    session.take_measured(motors, bench.now)
    session.orders.follow(MotorGoal(session.robot, target), bench.now)
    ways = []
    for _ in range(ticks):
        before = len(bench.commands)
        bench.tick()
        ways += [np.abs(command - motors).max() for command in bench.commands[before:]]
        motors = motors + PERIOD / time_constant * (session.commands.newest - motors)
        session.take_measured(motors, bench.now)
    return ways


@pytest.mark.parametrize(
    ("max_lead", "time_constant"), [(PERIOD, 0.02), (PERIOD, 0.1), (0.05, 0.1), (0.2, 0.02)]
)
def test_no_command_is_farther_ahead_of_measured_motors_than_max_lead(
    bench, max_lead, time_constant
):
    """One jammed motor bent the rods of all the others for half a second."""
    target = bench.session.solver.current.equilibrium.motors + [0.1, -0.2]
    ways = lagging(bench, target, max_lead, time_constant, 3000)
    reach = max_lead * SETTINGS.max_speed
    assert max(ways) <= reach * (1.0 + 1e-5)
    assert max(ways) >= 0.99 * min(reach, time_constant * SETTINGS.max_speed)
    np.testing.assert_array_equal(bench.commands[-1], target)  # slower, but there
    assert bench.session.present.outcome.state == State.IDLE


def test_commands_wait_for_a_motor_that_jams_and_say_so(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(80):
        session.take_measured(home, bench.now)
        bench.tick()
    lead = LIVE.max_lead * SETTINGS.max_speed
    np.testing.assert_allclose(bench.commands[-1] - home, [0.0, lead], rtol=2e-3, atol=1e-12)
    assert "the commands wait for a motor" in session.senses.unseen(bench.now)
    assert session.follower.pace.waits
    sent, outcome = len(bench.commands), bench.tick()
    assert len(bench.commands) == sent
    assert (outcome.state, outcome.moved) == (State.FOLLOWING, False)
    assert not session.at_rest
    for _ in range(400):  # it goes on
        session.take_measured(bench.commands[-1], bench.now)
        bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], home + [0.0, 0.5])
    assert session.senses.unseen(bench.now) == ""


@pytest.mark.parametrize(
    ("off", "motor"),
    [([0.0, -0.3], "motor2"), ([0.0, 0.3], "motor2"), ([2.0 * np.pi, 0.0], "motor1")],
)
def test_commands_wait_for_a_motor_that_is_beside_its_way(bench, off, motor):
    """One that sagged while others moved bent its rod by any way, FOLLOWING with NONE and stable."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.8, 0.0]), bench.now)
    measured_off(bench, 0.0, 20)
    place = session.commands.newest + off
    session.take_measured(place, bench.now)
    bench.tick()
    sent = len(bench.commands)
    for _ in range(50):
        session.take_measured(place, bench.now)
        bench.tick()
    assert len(bench.commands) == sent
    assert f"the commands wait for {motor}: it was measured beside" in session.senses.unseen(
        bench.now
    )
    assert session.verdict(bench.now).action == Action.SLOW
    measured_off(bench, 0.0, 400)  # it is where it was sent again
    np.testing.assert_array_equal(bench.commands[-1], home + [0.8, 0.0])


def test_a_motor_that_stays_beside_its_way_ends_what_waits_for_it(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.8, 0.0]), bench.now)
    bench.tick()
    measured_off(bench, [0.0, -0.3], 200)
    assert session.follower.goal is None
    assert "the motors do not follow: one was measured 0.3 " in session.orders.left_behind


@pytest.mark.parametrize("tolerances", [{"moved_tolerance": 0.0}, {"max_lead": 0.0}])
def test_who_lets_motors_be_anywhere_waits_for_none(bench, tolerances):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, **tolerances), bench.now)
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.3, 0.0]), bench.now)
    bench.tick()
    measured_off(bench, [0.0, -0.3], 80)
    np.testing.assert_array_equal(bench.commands[-1], home + [0.3, 0.0])


def test_a_motor_that_jams_is_gone_back_to_at_once(bench):
    """It is measured ahead of the way back, as far as max_lead had let commands go."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(80):
        session.take_measured(home - [0.0, 0.05], bench.now)  # and gives way
        bench.tick()
    assert session.follower.pace.waits
    session.orders.follow(MotorGoal(session.robot, home), bench.now)
    bench.tick()
    assert bench.commands[-1][1] < bench.commands[-2][1]


def test_what_is_held_off_farther_than_max_lead_does_not_hear_the_last_command_again(bench):
    """A controller that comes later would jump there."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, max_lead=PERIOD), bench.now)
    commanded(session, home)
    for way in (0.5, 1.0, 1.5, 15.0):
        session.take_measured(home + [0.0, way * PERIOD * SETTINGS.max_speed], bench.now)
        assert (session.outgoing.repeated() is not None) == (way <= 1.0)
    apply_live(session, replace(LIVE, max_lead=0.2), bench.now)
    assert session.outgoing.repeated() is not None


def test_there_is_a_way_back_from_a_motor_that_jams(bench):
    """Whatever is asked for that takes no motor farther from where it is measured."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, settings=replace(SETTINGS, max_speed=0.4)), bench.now)
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for ask in (None, session.orders.reset):
        if ask:
            ask()
        for _ in range(90):
            session.take_measured(home, bench.now)
            bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], home)
    assert session.present.outcome.state == State.IDLE
    assert not session.moved_by_others.away


@pytest.mark.parametrize(("speed", "begins_there"), [(1.0, True), (0.2, False)])
def test_a_motor_that_stays_jammed_ends_what_waits_for_it(bench, speed, begins_there):
    """A setpoint of long ago would set off when it has power again; near its command it stays there."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, settings=replace(SETTINGS, max_speed=speed)), bench.now)
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    ticks, begin = 0, False
    while session.follower.goal is not None:
        begin = session.take_measured(home, bench.now) or begin
        bench.tick()
        ticks += 1
    assert ticks == pytest.approx((0.5 + GONE_ON / speed) / PERIOD, abs=3)
    assert "the motors do not follow: one was measured" in session.follower.dropped
    for _ in range(200):
        begin = session.take_measured(home, bench.now) or begin
        bench.tick()
    assert begin == begins_there
    assert np.abs(bench.commands[-1] - home).max() <= LIVE.max_lead * speed * (1.0 + 1e-5)


def jammed(bench):
    """Commands wait for a motor."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, measured_timeout=0.1), bench.now)
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    while not session.follower.pace.waits or bench.tick().moved:
        session.take_measured(home, bench.now)
        bench.tick()
    return session, home


@pytest.mark.parametrize(
    "changed",
    [{"max_lead": 1.0}, {"max_lead": 0.0}, {"settings": replace(SETTINGS, max_speed=2.0)}],
)
def test_a_parameter_that_lets_commands_go_farther_starts_no_motion(bench, changed):
    session, home = jammed(bench)
    sent = len(bench.commands)
    assert apply_live(session, replace(LIVE, **changed), bench.now)
    for _ in range(20):
        session.take_measured(home, bench.now)
        bench.tick()
    assert len(bench.commands) == sent
    assert session.follower.goal is None


def test_what_waits_for_motors_that_are_measured_no_more_ends(bench):
    """Commands went on, or would have long after, when they were measured again."""
    session, _ = jammed(bench)
    sent = len(bench.commands)
    for _ in range(100):
        bench.tick()
    assert len(bench.commands) == sent
    assert session.follower.goal is None
    assert "the commands wait for a motor" in session.follower.dropped
    assert "the measured motors are older than measured_timeout 0.1 s" in session.follower.dropped
    assert session.follower.forgotten == session.follower.dropped
    # Another one, or a stream of them, leads no farther: motors may have stopped where they were seen.
    target = bench.commands[-1] + 0.1
    for _ in range(20):
        session.orders.follow(MotorGoal(session.robot, target), bench.now)
        bench.tick()
    assert len(bench.commands) == sent
    apply_live(session, replace(LIVE, max_lead=0.0, measured_timeout=0.1), bench.now)
    session.orders.follow(MotorGoal(session.robot, target), bench.now)
    bench.tick()
    assert len(bench.commands) == sent + 1  # who says so knows that


@pytest.mark.parametrize("jogged", [False, True])
def test_slow_commands_run_no_farther_ahead_of_motors_that_are_measured_no_more(bench, jogged):
    """Below 0.4 of the full speed they went on without end: by 0.9 rad in three seconds."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, measured_timeout=0.1), bench.now)
    commanded(session, home)
    slow = replace(LIVE, measured_timeout=0.1, settings=replace(SETTINGS, max_speed=0.2))
    for tick in range(800):
        if tick < 20:
            session.take_measured(home, bench.now)
        if tick == 20:
            apply_live(session, slow, bench.now)
        if tick == 0 or jogged:
            session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.9]), bench.now)
        bench.tick()
    bench.tick()
    lead = np.abs(np.array(bench.commands) - home).max()
    assert lead <= session.commands.max_lead * SETTINGS.max_speed * (1.0 + 1e-9)
    assert lead > 0.05
    assert session.follower.goal is None
    assert "with max_lead 0 they go on unseen" in session.follower.forgotten


def test_a_jammed_motor_ends_what_waits_for_it_without_a_tolerance_too(bench):
    """No tolerance is for motors that are held off; a goal without end is for nobody."""
    session, home = jammed(bench)
    apply_live(session, replace(LIVE, moved_tolerance=0.0), bench.now)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    sent, begin = len(bench.commands), False
    for _ in range(200):
        begin = session.take_measured(home, bench.now) or begin
        bench.tick()
    assert session.follower.goal is None and not begin
    assert "the motors do not follow: one was measured" in session.orders.left_behind
    assert len(bench.commands) == sent and not session.moved_by_others.in_question


def test_motors_that_are_measured_once_hold_no_goal_up_for_ever(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.take_measured(home, bench.now)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(400):
        bench.tick()
    assert session.follower.goal is None
    assert "measured only once, max_lead has to be 0" in session.follower.dropped
    apply_live(session, replace(LIVE, max_lead=0.0), bench.now)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(400):
        bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], home + [0.0, 0.5])


def test_what_is_told_of_a_robot_that_waits_is_that_it_is_not_seen(bench):
    session, _ = jammed(bench)
    told = session.verdict(bench.now)
    assert session.present.outcome.verdict.action == Action.NONE
    assert (told.action, told.speed_scale) == (Action.SLOW, BLIND)
    assert "the commands wait for a motor" in told.text


def test_a_trajectory_that_parameters_end_is_told_so(bench):
    session, endings = bench.session, waiting(bench, 0.0, [0.0, 0.4])
    home = session.solver.current.equilibrium.motors
    while not session.follower.pace.waits:
        session.take_measured(home, bench.now)
        bench.tick()
    apply_live(session, replace(LIVE, max_lead=0.3), bench.now)
    bench.tick()
    [ending] = endings
    assert ending.val == ErrorCode.PREEMPTED and ending.message.startswith("parameters changed")


def test_a_trajectory_that_waits_for_motors_that_are_measured_no_more_fails(bench):
    session, endings = bench.session, waiting(bench, 0.0, [0.0, 0.4])
    home = session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, measured_timeout=0.1), bench.now)
    for _ in range(60):
        session.take_measured(home, bench.now)
        bench.tick()
    assert session.follower.pace.waits
    assert not endings
    for _ in range(30):
        bench.tick()
    assert [ending.val for ending in endings] == [ErrorCode.CONTROL_FAILED]
    assert "the measured motors are older than" in endings[0].message


@pytest.mark.parametrize("asked", [False, True])
def test_commands_on_their_way_wait_too_and_a_parameter_lets_them_not_go_on(bench, asked):
    """Nor does it where a setpoint waits for them."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    apply(session, 2.9, 0.5)
    for _ in range(60):
        session.take_measured(home, bench.now)
        bench.tick()
    sent = len(bench.commands)
    np.testing.assert_allclose(np.abs(bench.commands[-1] - home).max(), 0.2, rtol=1e-5)
    assert bench.session.present.outcome.state == State.ALIGNING
    assert "the commands wait for a motor" in session.senses.unseen(bench.now)
    if asked:
        session.orders.follow(MotorGoal(session.robot, home), bench.now)
    assert apply_live(session, replace(LIVE, max_lead=0.0), bench.now) == asked
    for _ in range(20):
        session.take_measured(home, bench.now)
        bench.tick()
    assert len(bench.commands) == sent
    assert session.present.outcome.state == State.PAUSED
    session.orders.pause(False)
    session.take_measured(bench.commands[-1], bench.now)
    bench.tick()
    assert len(bench.commands) == sent + 1


def test_commands_on_their_way_are_held_where_motors_are_measured_no_more(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, measured_timeout=0.1), bench.now)
    commanded(session, home)
    apply(session, 2.9, 0.5)
    for number in range(100):
        if number < 60:
            session.take_measured(home, bench.now)
        bench.tick()
    np.testing.assert_allclose(np.abs(bench.commands[-1] - home).max(), 0.2, rtol=1e-5)
    assert session.present.outcome.state == State.PAUSED
    assert session.at_rest  # it is ended once, not in every tick
    sent = len(bench.commands)
    session.orders.pause(False)
    for _ in range(3):
        bench.tick()
    assert session.present.outcome.state == State.PAUSED  # held again: nobody sees the motors
    assert len(bench.commands) == sent
    apply_live(session, replace(LIVE, max_lead=0.0, measured_timeout=0.1), bench.now)
    session.orders.pause(False)  # who says so knows that
    bench.tick()
    assert len(bench.commands) == sent + 1


def test_without_max_lead_commands_go_on_until_motors_are_found_not_to_follow(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, max_lead=0.0), bench.now)
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(60):
        session.take_measured(home, bench.now)
        bench.tick()
    way = [0.0, 60 * PERIOD * SETTINGS.max_speed]
    np.testing.assert_allclose(bench.commands[-1] - home, way, rtol=1e-6, atol=1e-12)
    assert session.senses.unseen(bench.now) == ""
