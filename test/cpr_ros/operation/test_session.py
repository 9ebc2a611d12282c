# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in operation, tick by tick: what it sends to the motors and what it makes of a wrench."""

from dataclasses import replace

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD, SETTINGS, motorless_robot, robot
from helpers.session_bench import FIXED, LIVE, Bench, commanded, still, stop, ticked, timed
from helpers.turntable import turntable

from cpr_core import CprError, solve_forward, solve_home
from cpr_ros.closed_loop.jogging import PlatformTwist
from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.supervision import Action, State
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.live_changes import apply_live
from cpr_ros.operation.session import Session
from cpr_ros.operation.starting_place import begin_at
from cpr_ros.settings.node_settings import Parameters


def test_nothing_is_sent_to_motors_of_which_nothing_is_known(bench):
    for _ in range(5):
        bench.tick()
    assert bench.commands == []


def test_a_wrench_moves_the_platform_and_sends_nothing(bench):
    """It was taken for the first motion, and home went out, wherever the motors were."""
    home = bench.session.solver.current.equilibrium
    bench.push(0.2, 0.0, 0.0)
    assert bench.tick().moved
    pushed = bench.session.solver.current.equilibrium
    assert np.abs(pushed.platform_position - home.platform_position).max() > 1e-4
    assert bench.commands == []
    bench.session.orders.follow(MotorGoal(bench.session.robot, home.motors + 0.02), bench.now)
    while bench.tick().state != State.IDLE:
        pass
    assert np.abs(bench.commands[0] - home.motors).max() <= PERIOD * (1.0 + 1e-6)
    np.testing.assert_array_equal(bench.commands[-1], home.motors + 0.02)
    sent = len(bench.commands)
    bench.push(0.1, 0.0, 0.0)
    assert bench.tick().moved
    assert len(bench.commands) == sent  # nor at rest where all is known


@pytest.mark.parametrize(
    "ask",
    [
        lambda session, home, now: session.orders.follow(
            MotorGoal(session.robot, home.motors), now
        ),
        lambda session, home, now: session.orders.follow(PoseGoal(session.robot, home.pose), now),
        lambda session, home, now: session.orders.reset(),
        lambda session, home, now: still(session, home.motors, now),
    ],
    ids=["motors", "pose", "reset", "trajectory"],
)
def test_a_setpoint_that_is_home_is_told_to_motors_of_which_nothing_is_known(bench, ask):
    """It was said to be reached, and the motors, wherever they were, had heard of nothing."""
    home = bench.session.solver.current.equilibrium
    bench.session.unplaced = True
    bench.tick()
    assert bench.commands == []
    ask(bench.session, home, bench.now)
    for _ in range(120):
        bench.tick()
    np.testing.assert_array_equal(bench.commands, [home.motors])  # once
    assert not bench.session.unplaced
    assert bench.session.at_rest


@pytest.mark.parametrize(
    ("kind", "numbers", "words"),
    [
        (MotorGoal, [148.4, 31.5], "motor1 at 148.4 looks like degrees, expected radians"),
        (MotorGoal, [2.59, 31.5], "motor2 at 31.5 looks like degrees, expected radians"),
        (
            PoseGoal,
            [0.0, 830.0],
            r"the platform position \(0, 830, 0\) looks like millimetres, expected metres",
        ),
    ],
)
def test_numbers_of_another_unit_are_not_set_off_for(bench, kind, numbers, words):
    """The robot went as far as it could, right round and to a halt; services said what looks wrong."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    wanted = MotorGoal(session.robot, home + 0.1)
    session.orders.follow(wanted, bench.now)
    bench.tick()
    with pytest.raises(RequestError, match=rf"\A{words}\Z") as refused:
        session.orders.follow(kind(session.robot, numbers), bench.now)
    assert refused.value.val == ErrorCode.INVALID_ROBOT_STATE
    assert session.follower.goal is wanted
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(bench.commands[-1], home + 0.1)


def test_many_turns_are_gone_in_small_steps_however_far_the_robot_is_behind():
    """A table that turns for ever: only at once nobody means as many radians."""
    live = replace(LIVE, settings=replace(SETTINGS, max_speed=40.0))
    table, now = turntable(), 0.0
    session = Session(table, Frames("base", "platform"), Parameters(**FIXED), live)

    def send(*ways):
        for way in ways:
            session.orders.follow(MotorGoal(table, [float(way)]), now)

    with pytest.raises(RequestError, match="motor1 at 40 looks like degrees"):
        send(40)
    send(*range(0, 41, 10))  # all at once
    while not session.follower.arrived(session.solver.current.equilibrium):
        now += PERIOD
        ticked(session, now)
    np.testing.assert_array_equal(session.solver.current.equilibrium.motors, [40.0])
    session.follower.drop()
    send(40.1)
    session.follower.drop()
    send(0)  # home, from anywhere
    session.follower.drop()
    with pytest.raises(RequestError, match="motor1 at 2292 looks like degrees"):
        send(2292)


def test_a_setpoint_that_is_not_obeyed_sends_nothing(bench):
    """Paused, or pushed by a wrench that the robot does not bear, it stays where it is."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    bench.push(0.0, -1000.0, 0.0)
    session.orders.follow(MotorGoal(session.robot, home), bench.now)
    bench.tick()
    session.orders.follow(MotorGoal(session.robot, home + 0.1), bench.now)
    bench.tick()
    session.orders.pause(True)
    bench.tick()
    assert bench.commands == []


@pytest.mark.parametrize("source", ["setpoint", "measured"])
def test_a_wrench_that_is_not_borne_is_a_halt_in_every_state(source):
    bench = Bench(motor_source=source)
    session, home = bench.session, solve_home(robot("rfrfr"))
    if source == "measured":
        session.tracking.take(home.motors, bench.now)
    else:
        begin_at(session, home, home.motors + 0.5, 0.0)  # the motors are elsewhere
        assert bench.tick().state == State.ALIGNING
    assert bench.tick().verdict.action == Action.NONE
    bench.push(0.0, -1000.0, 0.0)
    outcome = bench.tick()
    assert outcome.state == (State.LOST if source == "measured" else State.ALIGNING)
    assert (outcome.verdict.action, outcome.verdict.speed_scale) == (Action.HALT, 0.0)
    sent = len(bench.commands)
    for _ in range(5):
        assert bench.tick().verdict.action == Action.HALT
    assert len(bench.commands) == sent  # they went on to where they were sent, through the halt
    bench.push(0.0, 0.0, 0.0)
    bench.tick()
    assert len(bench.commands) == sent + (source == "setpoint")


def test_the_way_home_is_not_over_before_the_motors_have_heard_of_it(bench):
    """A wrench that was not borne held the one command of it back, and the way was said to be done."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    bench.push(0.0, -1000.0, 0.0)
    session.orders.reset()
    for _ in range(3):
        assert bench.tick().state == State.HALTED
    assert bench.commands == []
    bench.push(0.0, 0.0, 0.0)
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(bench.commands, [home])


def test_where_it_is_measured_while_paused_it_stays_paused(bench):
    """The stream said that it was idle, and setpoints were refused as it was paused."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.orders.pause(True)
    bench.tick()
    begin_at(session, home, home.motors, 0.0)
    assert session.present.outcome.state == State.PAUSED
    assert bench.tick().state == State.PAUSED


def test_what_is_done_before_the_first_tick_is_not_that_of_before(bench):
    session = bench.session
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    assert bench.tick().state == State.FOLLOWING
    session.stand()
    assert session.present.outcome.state == State.IDLE
    assert session.follower.goal is None


def test_motors_that_were_measured_before_an_activation_are_forgotten():
    """They were followed, a thousand seconds later, as if they had just been measured."""
    bench = Bench(motor_source="measured")
    bench.session.tracking.take([2.6, 0.55], bench.now)
    assert bench.tick().state == State.TRACKING
    bench.session.stand()
    bench.now += 1000.0
    outcome = bench.tick()
    assert (outcome.state, outcome.verdict.action) == (State.IDLE, Action.HALT)


def test_what_was_missed_before_an_activation_is_forgotten(bench):
    session = bench.session
    apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    bench.push(0.1, 0.0, 0.0)
    while bench.now < 1.0:
        bench.tick()
    assert "external wrench is older" in session.senses.unseen(bench.now)
    session.stand()
    assert session.senses.unseen(bench.now) == ""


@pytest.mark.parametrize(
    ("every", "speed"), [(1, 0.1), (3, 0.1), (10, 0.1), (41, 0.1), (10, 3.0), (40, 0.6)]
)
def test_velocities_of_measured_motors_are_those_between_measurements(every, speed):
    """They were those of a tick, however many passed from one measurement to the next.

    Fast ones are walked after in several ticks.
    """
    bench, speed = Bench(motor_source="measured"), speed * np.array([0.5, -1.0])
    session, home = bench.session, solve_home(robot("rfrfr")).motors
    told = []
    for number in range(10 * every):
        if number % every == 0:  # in between two ticks, as they come
            since = bench.now + 0.3 * PERIOD
            session.tracking.take(home + speed * since, since)
        assert bench.tick().state == State.TRACKING
        told.append(session.present.velocity)
    np.testing.assert_allclose(told[3 * every :], np.tile(speed, (7 * every, 1)), rtol=1e-6)
    session.tracking.take(home + speed * since, bench.now + 0.1)  # they stand
    for _ in range(25):
        bench.tick()
    assert not session.present.velocity.any()
    apply_live(session, replace(LIVE, measured_timeout=0.05), bench.now)
    session.tracking.take(home + speed * since + 0.05, bench.now)
    bench.tick()
    assert session.present.velocity.any()
    while bench.tick().state != State.STALE:
        pass
    assert not session.present.velocity.any()


def test_the_wrench_of_an_applied_solution_outlives_one_that_is_long_gone(bench):
    """It was dropped in the next tick if any wrench had ever come."""
    session = bench.session
    apply_live(session, replace(LIVE, wrench_timeout=0.1), bench.now)
    bench.push(0.05, 0.0, 0.0)
    for _ in range(30):
        bench.tick()
    np.testing.assert_array_equal(session.solver.current.equilibrium.loads.wrench_world, 0.0)
    assert session.at_rest
    loads = session.robot.default_loads.with_(wrench_world=[0, 0, 0, 0.1, 0, 0])
    pushed = solve_forward(session.robot, session.solver.current.equilibrium.motors, loads=loads)
    begin_at(session, pushed, None, 0.0)
    for _ in range(5):
        bench.tick()
    assert session.solver.current.equilibrium is pushed


def test_the_state_is_the_new_one_as_soon_as_a_request_is_answered(bench):
    """The stream came once more with IDLE before the next tick: the end of the way, it seemed."""
    session = bench.session
    bench.tick()
    for ask, state in (
        (session.orders.reset, State.RETURNING),
        (lambda: session.orders.pause(True), State.PAUSED),
        (lambda: session.orders.pause(False), State.IDLE),
    ):
        ask()
        assert session.present.outcome.state == state
        assert not session.at_rest
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    bench.tick()
    session.orders.pause(False)  # there was none
    assert session.present.outcome.state == State.FOLLOWING


def test_a_pause_holds_commands_that_are_on_their_way(bench):
    """They went on to the node's equilibrium, however long that took."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors + 0.1, 0.0)
    assert bench.tick().state == State.ALIGNING
    session.orders.pause(True)
    held = bench.commands[-1]
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    assert session.at_rest
    np.testing.assert_array_equal(bench.commands[-1], held)
    session.orders.pause(False)
    assert not session.at_rest
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(bench.commands[-1], home.motors)


def test_parameters_send_no_commands_that_a_wrench_holds_back(bench):
    """Another timeout took the wrench away, and the motors set off."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors + 0.1, 0.0)
    bench.push(-500.0, 0.0, 0.0)
    outcome = bench.tick()
    assert outcome.state == State.ALIGNING
    assert outcome.refusal is not None
    bench.now += 1.0
    assert apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    assert bench.commands == []
    session.orders.pause(False)
    assert bench.tick().state == State.ALIGNING
    assert len(bench.commands) == 1


@pytest.mark.parametrize(("offset", "force"), [(0.1, 0.0), (0.0, -500.0)])
def test_parameters_pause_no_commands_that_go_on_and_no_robot_that_has_none(bench, offset, force):
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors + offset, 0.0)
    bench.push(force, 0.0, 0.0)
    outcome = bench.tick()
    assert (outcome.state == State.ALIGNING) == (offset > 0.0)
    assert (outcome.refusal is not None) == (force != 0.0)
    assert not apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    assert not session.follower.paused
    assert bench.tick().state == outcome.state


def test_parameters_do_not_move_motors_that_hold_a_pose_against_a_wrench(bench):
    """Another timeout takes the wrench away: they would go where they hold it without."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    bench.push(3.0, 0.0, 0.0)
    session.orders.follow(PoseGoal(session.robot, home.pose), bench.now)
    held = replace(LIVE, wrench_timeout=5.0)
    while bench.tick().state != State.IDLE:
        assert not apply_live(session, held, bench.now)  # under way it is seen what becomes of it
    sent, bench.now = len(bench.commands), bench.now + 1.0
    assert not apply_live(session, held, bench.now)
    assert apply_live(session, replace(LIVE, wrench_timeout=0.5), bench.now)
    for _ in range(5):
        bench.tick()
    assert sent and len(bench.commands) == sent


def test_parameters_give_no_new_time_to_a_setpoint_that_has_just_become_too_old(bench):
    """Between two ticks: the first of them would have halted."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    apply_live(session, replace(LIVE, settings=replace(SETTINGS, setpoint_timeout=0.1)), bench.now)
    commanded(session, home)
    session.orders.follow(MotorGoal(session.robot, home + 0.5), bench.now)
    assert bench.tick().state == State.FOLLOWING
    bench.now += 0.2
    assert apply_live(session, LIVE, bench.now)
    assert bench.tick().state == State.IDLE
    assert len(bench.commands) == 1


def test_only_another_timeout_of_twists_ends_a_twist(bench):
    session = bench.session
    commanded(session, session.solver.current.equilibrium.motors)
    session.orders.jog(PlatformTwist(0.01 * np.eye(6)[3], in_platform=False), bench.now)
    assert bench.tick().state == State.FOLLOWING
    assert not apply_live(session, replace(LIVE, max_lead=0.5), bench.now)
    assert apply_live(session, replace(LIVE, twist_timeout=2.0 * LIVE.twist_timeout), bench.now)
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    bench.tick()
    assert not apply_live(session, LIVE, bench.now)  # no twist, none of its concern


def test_an_empty_trajectory_ends_the_way_home(bench):
    """It was refused as setpoints are, and the robot went on."""
    session = bench.session
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    while bench.tick().state != State.IDLE:
        pass
    session.orders.reset()
    for _ in range(5):
        assert bench.tick().state == State.RETURNING
    held = bench.commands[-1]
    assert stop(session, bench.now) == [ErrorCode.SUCCESS]
    assert session.follower.goal is None
    for _ in range(5):
        assert bench.tick().state == State.IDLE
    np.testing.assert_array_equal(bench.commands[-1], held)
    assert session.at_rest


def test_an_empty_trajectory_holds_commands_that_are_on_their_way(bench):
    """It was said to be done, and they went on to the node's equilibrium, however long that took."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors + 0.1, 0.0)
    assert bench.tick().state == State.ALIGNING
    held = bench.commands[-1]
    assert stop(session, bench.now) == [ErrorCode.SUCCESS]
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    np.testing.assert_array_equal(bench.commands[-1], held)
    assert stop(session, bench.now) == [ErrorCode.SUCCESS]  # it holds already
    assert session.follower.paused


def test_an_empty_trajectory_is_refused_by_a_node_that_moves_nothing():
    bench = Bench(motor_source="measured")
    with pytest.raises(RequestError, match="tracks measured motors"):
        stop(bench.session, bench.now)


def test_a_robot_waits_for_a_measurement_until_it_moves(bench):
    session = bench.session
    session.unplaced = True
    bench.push(0.2, 0.0, 0.0)
    bench.tick()
    assert session.unplaced
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    bench.tick()
    assert not session.unplaced


def test_the_command_of_a_tick_leaves_before_note_is_taken_of_it(bench):
    """And after it was kept where the robot is."""
    session, events = bench.session, []
    session.commands.place(session.solver.current.equilibrium.motors)
    session.orders.follow(MotorGoal(session.robot, [2.60, 0.56]), bench.now)
    bench.tick()
    before, places = session.present.velocity, session.loop._history.newest
    bench.now += PERIOD

    def take_down(event):
        assert session.present.velocity is before and session.loop._history.newest is places
        assert session.present.outcome.moved
        motors = session.solver.current.equilibrium.motors
        events.append((event, motors.tolist(), session.commands.newest.tolist()))

    def send(command, ahead):
        np.testing.assert_array_equal(command, session.solver.current.equilibrium.motors)
        assert not ahead
        take_down("sent")

    assert session.tick(bench.now, send, lambda: take_down("kept")).moved
    sent = session.solver.current.equilibrium.motors.tolist()
    assert events == [("kept", sent, sent), ("sent", sent, sent)]
    way = session.solver.current.equilibrium.motors - bench.commands[-1]
    np.testing.assert_allclose(session.present.velocity, way / PERIOD)
    assert session.loop._history.newest.equilibrium is session.solver.current.equilibrium


def test_a_place_that_is_found_late_ends_a_setpoint_that_was_thought_reached(bench):
    """Any tick, after a change of parameters say, then sent the robot back to where it had been."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors, 0.0)  # the last command, of a node before
    session.orders.follow(MotorGoal(session.robot, home.motors), bench.now)
    bench.tick()
    found = solve_forward(session.robot, home.motors + [0.3, -0.2])
    begin_at(session, found, found.motors, 0.0)
    assert session.follower.goal is None
    assert "elsewhere" in session.follower.dropped
    apply_live(session, replace(LIVE, settings=replace(SETTINGS, hysteresis=0.2)), bench.now)
    for _ in range(5):
        assert bench.tick().state == State.IDLE
    assert bench.commands == []


def test_a_place_that_is_found_late_ends_a_trajectory_that_waits(bench):
    """It never began and never ended."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors, 0.0)
    endings = []
    session.orders.follow_trajectory(timed([home.motors + 0.1], 1.0), bench.now, endings.append)
    for _ in range(5):
        bench.tick()
    found = solve_forward(session.robot, home.motors + [0.3, -0.2])
    begin_at(session, found, found.motors, 0.0)
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]
    bench.tick()
    assert bench.commands == []
    assert session.at_rest


def test_a_trajectory_sends_nothing_before_its_stamp_to_motors_of_which_nothing_is_known(bench):
    """They were sent home at once, perhaps minutes before."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    points = [home.motors, home.motors + 0.01]
    session.orders.follow_trajectory(timed(points, 0.5), bench.now, lambda _: None)
    while bench.now < 0.45:
        bench.tick()
    assert bench.commands == []
    while bench.now < 3.0:
        bench.tick()
    np.testing.assert_allclose(bench.commands[0], home.motors, atol=1e-3)
    np.testing.assert_allclose(bench.commands[-1], home.motors + 0.01, atol=1e-12)


def test_a_return_that_a_wrench_holds_up_can_be_replaced(bench):
    session = bench.session
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    while bench.tick().state != State.IDLE:
        pass
    session.orders.reset()
    bench.tick()
    with pytest.raises(RequestError, match="on its way home"):
        session.orders.follow(MotorGoal(session.robot, [2.65, 0.52]), bench.now)
    bench.push(-1e4, 0.0, 0.0)
    assert bench.tick().state == State.HALTED
    session.orders.follow(MotorGoal(session.robot, [2.65, 0.52]), bench.now)
    assert not session.follower.returning


def test_a_setpoint_that_is_dropped_while_commands_are_on_their_way_holds_them(bench):
    """Cancelled goals were said to hold, and the motors went on."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    begin_at(session, home, home.motors + 0.1, 0.0)
    session.orders.follow(MotorGoal(session.robot, home.motors + 0.2), bench.now)
    assert bench.tick().state == State.ALIGNING
    held = bench.commands[-1]
    session.orders.drop()
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    np.testing.assert_array_equal(bench.commands[-1], held)


def test_a_robot_without_motors_is_refused_by_that_name():
    """The deviation of its efforts was said to be infinite."""
    frames, parameters = Frames("base", "platform"), Parameters(**FIXED)
    with pytest.raises(CprError, match="rfrfr: expected a robot with motors"):
        Session(motorless_robot(), frames, parameters, LIVE)
