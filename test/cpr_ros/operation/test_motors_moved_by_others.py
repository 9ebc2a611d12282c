# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors that others have moved: what was to lead elsewhere ends, and nothing goes back by itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD
from helpers.session_bench import LIVE, Bench, apply, commanded, measured_for, still, waiting

from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import Action, State
from cpr_ros.following.trajectory_order import TrajectoryOrder
from cpr_ros.operation.live_changes import apply_live
from cpr_ros.operation.starting_place import begin_at_measured


def test_motors_that_others_have_moved_are_not_sent_back(bench):
    """The last command was said again, and the next motion began there: at once, 0.5 rad away."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    assert not measured_for(bench, home.motors)
    np.testing.assert_array_equal(session.outgoing.repeated(), home.motors)
    session.orders.follow(MotorGoal(session.robot, home.motors), bench.now)
    bench.tick()
    elsewhere = home.motors + [0.1, -0.4]
    assert not measured_for(bench, elsewhere, 0.3)  # they may still be moved
    assert session.outgoing.repeated() is None
    assert session.follower.goal is None
    assert "somebody else has moved the motors" in session.follower.dropped
    for ask in (
        lambda: session.orders.follow(MotorGoal(session.robot, home.motors), bench.now),
        lambda: still(session, home.motors, bench.now),
        lambda: apply(session, 2.6, 0.5),
        session.orders.reset,
    ):
        with pytest.raises(RequestError, match="somebody else has moved the motors"):
            ask()
    assert measured_for(bench, elsewhere, 0.5)
    begin_at_measured(session, elsewhere)
    assert bench.commands == []
    assert not measured_for(bench, elsewhere)
    assert bench.commands == []
    held = session.outgoing.repeated()
    assert held is None  # nobody asked them to hold against what held them off
    session.orders.follow(MotorGoal(session.robot, elsewhere + 0.01), bench.now)
    assert bench.tick().state == State.FOLLOWING
    assert np.abs(bench.commands[0] - elsewhere).max() <= PERIOD * (1.0 + 1e-5)
    np.testing.assert_array_equal(session.outgoing.repeated(), bench.commands[0])


def test_what_a_goal_was_told_of_motors_elsewhere_stays_known(bench):
    """A goal that ended by it was told these words, and motors move on."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    told = []
    for way in (0.2, 0.4):
        session.orders.follow(MotorGoal(session.robot, home), bench.now)
        bench.tick()
        measured_for(bench, home + way, 0.2)
        told.append(session.orders.left_behind)
        assert told[-1] == session.follower.dropped == session.moved_by_others.away != ""
        measured_for(bench, home + way + 0.05, 0.2)
        assert session.moved_by_others.away != told[-1]
        assert session.orders.left_behind == told[-1]
        measured_for(bench, home, 0.2)
        assert session.moved_by_others.away == ""
    assert told[0] != told[1]


@pytest.fixture
def moved(bench):
    """A robot that others have moved, and that is measured no more."""
    motors = bench.session.solver.current.equilibrium.motors
    commanded(bench.session, motors)
    for way in np.arange(0.0, 0.4, 0.02):  # by a hand, at rest nowhere
        assert not measured_for(bench, motors + way, 0.1)
    assert bench.session.moved_by_others.away
    return bench


def halted(bench):
    """Whether a supervisor is told that others have moved the motors; nothing is sent to them."""
    sent, outcome = len(bench.commands), bench.tick()
    assert len(bench.commands) == sent
    assert outcome is bench.session.present.outcome
    told = outcome.verdict
    assert bench.session.at_rest
    if told.action == Action.NONE:
        return False
    assert (told.action, told.speed_scale) == (Action.HALT, 0.0)
    assert told.text == bench.session.moved_by_others.away != ""
    return True


def test_that_others_have_moved_the_motors_is_a_halt_until_they_are_measured_where_sent(moved):
    """Every setpoint was refused, and `action` was NONE."""
    session, home = moved.session, moved.session.solver.current.equilibrium
    assert session.known_place == (home, None, False)  # a node of later has to measure them
    for _ in range(3):
        moved.now += 100.0
        assert halted(moved)
        session.orders.pause(True)
        assert halted(moved)
        session.orders.pause(False)
    session.stand()
    assert halted(moved)
    with pytest.raises(RequestError, match="somebody else has moved the motors"):
        session.orders.follow(MotorGoal(session.robot, home.motors), moved.now)
    session.take_measured(home.motors + 0.05, moved.now)
    assert not session.at_rest
    assert not halted(moved)
    np.testing.assert_array_equal(session.known_place.motors, home.motors)
    session.orders.follow(MotorGoal(session.robot, home.motors + 0.1), moved.now)
    assert moved.tick().state == State.FOLLOWING


def test_no_moved_tolerance_ends_it_and_sends_nothing_by_itself(moved):
    session, home = moved.session, moved.session.solver.current.equilibrium
    apply_live(session, replace(LIVE, moved_tolerance=0.0, max_lead=0.0), moved.now)
    assert not session.at_rest
    assert not halted(moved)
    assert session.outgoing.repeated() is None
    session.orders.follow(MotorGoal(session.robot, home.motors + 0.1), moved.now)
    moved.tick()
    np.testing.assert_array_equal(session.outgoing.repeated(), moved.commands[-1])


def test_no_moved_tolerance_sets_off_no_commands_that_were_on_their_way(bench):
    """They were held by a wrench that was not borne, then by others who had moved the motors."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 2.7, 0.5)
    bench.tick()
    bench.now += 10.0
    for _ in range(2):
        bench.now += 0.1
        session.take_measured(home.motors + 0.5, bench.now)
    assert session.moved_by_others.away and bench.tick().state == State.ALIGNING
    sent = len(bench.commands)
    apply_live(session, replace(LIVE, moved_tolerance=0.0), bench.now)
    assert bench.tick().state == State.PAUSED
    assert len(bench.commands) == sent


def test_a_tracked_robot_is_remembered_where_it_is_measured_and_not_where_it_is_lost():
    bench = Bench(motor_source="measured")
    session, home = bench.session, bench.session.solver.current.equilibrium
    assert session.known_place is None
    session.tracking.take(home.motors + 0.05, bench.now)
    assert bench.tick().state == State.TRACKING
    equilibrium, motors, measured = session.known_place
    assert measured
    assert equilibrium is session.solver.current.equilibrium
    np.testing.assert_array_equal(motors, home.motors + 0.05)
    for shift in np.linspace(0.0, 4.0, 200):
        session.tracking.take(home.motors + [shift, -shift], bench.now)
        state = bench.tick().state
    assert state == State.LOST
    assert session.known_place == (session.solver.current.equilibrium, None, True)


def test_a_trajectory_that_waits_ends_where_others_move_the_motors(bench):
    session, home, endings = bench.session, bench.session.solver.current.equilibrium, []
    commanded(session, home.motors)
    nothing = np.full(2, np.inf)
    points = np.array([home.motors, home.motors])
    order = TrajectoryOrder(
        np.array([0.0, 0.5]), points, None, None, 30.0, nothing, nothing, np.inf
    )
    session.orders.follow_trajectory(order, bench.now, endings.append)
    measured_for(bench, home.motors + 0.3, 0.8)
    assert [ending.val for ending in endings] == [ErrorCode.CONTROL_FAILED]  # as goals of ~/move_to
    assert "somebody else has moved the motors" in endings[0].message


def test_one_wrong_measurement_ends_nothing_and_halts_nothing(bench):
    """A glitch of an encoder ended a trajectory that waited for its time."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    apply_live(session, replace(LIVE, max_lead=0.0), bench.now)
    endings = waiting(bench, 2.0)
    measured_for(bench, home.motors)
    bench.now += 0.1
    assert not session.take_measured(home.motors + 3.0, bench.now)
    assert bench.tick().verdict.action == Action.NONE
    assert session.outgoing.repeated() is None  # it may be true
    with pytest.raises(RequestError, match="the next measurements tell whether somebody has moved"):
        session.orders.follow(MotorGoal(session.robot, home.motors), bench.now)
    measured_for(bench, home.motors)
    assert (endings, session.outgoing.repeated() is None) == ([], False)
    while not endings:
        measured_for(bench, home.motors)
    assert [ending.val for ending in endings] == [ErrorCode.SUCCESS]


def test_no_command_goes_out_in_doubt_and_none_is_far_from_the_one_before(bench):
    """A trajectory that begins within a tick of the wrong measurement."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    endings = waiting(bench, 1.0, way=0.1)
    end = bench.now + 1.0
    while bench.now < end - PERIOD:
        session.take_measured(home.motors, bench.now)
        bench.tick()
    assert bench.commands == []
    session.take_measured(home.motors + 3.0, bench.now)
    for _ in range(8):
        assert bench.tick().verdict.action == Action.NONE
    assert bench.commands == []
    while not endings:
        session.take_measured(bench.commands[-1] if bench.commands else home.motors, bench.now)
        bench.tick()
    assert [ending.val for ending in endings] == [ErrorCode.SUCCESS]
    steps = np.diff([home.motors, *bench.commands], axis=0)
    assert np.abs(steps).max() <= PERIOD * (1.0 + 1e-5)
    np.testing.assert_allclose(bench.commands[-1], home.motors + 0.1, atol=1e-12)


def test_a_doubt_that_nothing_settles_ends_what_waits(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium
    endings = waiting(bench, 30.0)
    measured_for(bench, home.motors)
    session.take_measured(home.motors + 3.0, bench.now)
    for age in (0.0, 0.4):
        due = bench.look(bench.now + age, resting=False)
        assert endings == []
        assert due == session.moved_by_others.due == pytest.approx(bench.now + 0.5)
    bench.look(bench.now + 0.5, resting=False)
    assert "somebody else has moved the motors" in endings[0].message
    assert session.moved_by_others.due == math.inf
    assert bench.tick().verdict.action == Action.HALT


def test_commands_that_a_pause_holds_do_not_go_on_where_others_have_moved_the_motors(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 2.7, 0.5)
    bench.tick()
    session.orders.pause(True)
    sent = len(bench.commands)
    measured_for(bench, home.motors + 0.5, 0.8)
    session.orders.pause(False)
    bench.tick()
    assert len(bench.commands) == sent


def test_motors_in_motion_are_not_compared(bench):
    """They are late: that is no reason to end the motion."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    apply_live(session, replace(LIVE, max_lead=0.0), bench.now)  # else commands wait for them
    commanded(session, home.motors)
    session.orders.follow(MotorGoal(session.robot, home.motors + [0.5, -0.5]), bench.now)
    while bench.tick().state != State.IDLE:
        assert not session.take_measured(home.motors, bench.now)
    np.testing.assert_array_equal(bench.commands[-1], home.motors + [0.5, -0.5])


def test_a_robot_that_is_measured_in_two_places_is_halted_and_sent_nowhere(bench):
    """Half of what was measured agreed with the commands: none was told of the rest."""
    home = bench.session.solver.current.equilibrium.motors
    commanded(bench.session, home)
    bench.session.orders.follow(MotorGoal(bench.session.robot, home + 0.5), bench.now)
    sent = 0
    for number in range(200):
        own = bench.session.commands.newest
        assert not bench.session.take_measured(home - 0.3 if number % 2 else own, bench.now)
        outcome = bench.tick()
        if number == 20:
            sent = len(bench.commands)
    assert outcome.verdict.action == Action.HALT
    assert "measured in two places in turn" in outcome.verdict.text
    assert sent and len(bench.commands) == sent
    assert bench.session.follower.goal is None
    motors = bench.session.known_place.motors
    assert motors is None


@pytest.mark.parametrize("signs", [[-1.0, -1.0], [1.0, -1.0]])
def test_motors_that_are_measured_with_the_other_sign_are_no_place_to_begin(bench, signs):
    """It began there, and sent them back and forth by twice as far."""
    home = bench.session.solver.current.equilibrium.motors
    commanded(bench.session, home)
    for _ in range(400):
        assert not bench.session.take_measured(home * signs, bench.now)
        outcome = bench.tick()
    assert outcome.verdict.action == Action.HALT
    assert "where it would be with the other sign" in outcome.verdict.text
    assert bench.commands == []
    assert not bench.session.take_measured(home, bench.now)
    assert bench.tick().verdict.action == Action.NONE
