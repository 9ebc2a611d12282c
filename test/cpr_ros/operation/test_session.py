# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in operation, tick by tick: what it sends to the motors and what it makes of a wrench."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveForward, SolveInverse
from geometry_msgs.msg import PoseStamped
from helpers.branches import stable_elsewhere
from helpers.drive import PERIOD, SETTINGS, robot
from sensor_msgs.msg import JointState

from cpr_core import solve_forward, solve_home, solve_inverse
from cpr_ros.closed_loop.jogging import PlatformTwist
from cpr_ros.closed_loop.pose_loop import Loop, LoopStatus
from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.judged_steps import JudgedSteps
from cpr_ros.following.steps import Undecided
from cpr_ros.following.supervision import BLIND, Action, Refusal, State
from cpr_ros.following.trajectory_order import TrajectoryOrder
from cpr_ros.messages.conversions import Frames, fill_equilibrium
from cpr_ros.operation.kept_state import KeptState
from cpr_ros.operation.session import Session
from cpr_ros.operation.starting_place import HELD, begin_at_last, begin_at_measured
from cpr_ros.settings.parameter_table import PARAMETERS
from cpr_ros.settings.parameters import Parameters, live_parameters

FIXED = {parameter.name: parameter.default for parameter in PARAMETERS if not parameter.live}
FIXED["characteristic_length"] = None
DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}
LIVE = replace(
    live_parameters(DEFAULTS.__getitem__),
    settings=SETTINGS,
    wrench_timeout=0.0,
    measured_timeout=0.0,
)


class Bench:
    """A session, its clock, and the commands it gives."""

    def __init__(self, **parameters):
        self.session = Session(
            robot("rfrfr"), Frames("base", "platform"), Parameters(**FIXED | parameters), LIVE
        )
        self.now, self.commands = 0.0, []

    def push(self, *force):
        loads = self.session.solver.current.equilibrium.loads
        self.session.wrench.take(loads.with_(wrench_world=[0, 0, 0, *force]), self.now)

    def tick(self):
        self.now += PERIOD
        outcome = self.session.tick(self.now)
        command = self.session.next_command(self.now)
        self.commands += [] if command is None else [command]
        return outcome


@pytest.fixture
def bench():
    return Bench()


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
    bench.session.follow(MotorGoal(bench.session.robot, home.motors + 0.02), bench.now)
    while bench.tick().state != State.IDLE:
        pass
    assert np.abs(bench.commands[0] - home.motors).max() <= PERIOD * (1.0 + 1e-6)
    np.testing.assert_array_equal(bench.commands[-1], home.motors + 0.02)
    sent = len(bench.commands)
    bench.push(0.1, 0.0, 0.0)
    assert bench.tick().moved
    assert len(bench.commands) == sent  # nor at rest where all is known


def still(session, motors, now, seconds=0.5, told=lambda ending: None):
    """Some time at the same motors."""
    nothing = np.full(2, np.inf)
    times, points = np.array([0.0, seconds]), np.array([motors, motors])
    order = TrajectoryOrder(times, points, None, None, None, nothing, nothing, np.inf)
    return session.follow_trajectory(order, now, told)


@pytest.mark.parametrize(
    "ask",
    [
        lambda session, home, now: session.follow(MotorGoal(session.robot, home.motors), now),
        lambda session, home, now: session.follow(PoseGoal(session.robot, home.pose), now),
        lambda session, home, now: session.reset(),
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


def test_a_setpoint_that_is_not_obeyed_sends_nothing(bench):
    """Paused, or pushed by a wrench that the robot does not bear, it stays where it is."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    bench.push(0.0, -1000.0, 0.0)
    session.follow(MotorGoal(session.robot, home), bench.now)
    bench.tick()
    session.follow(MotorGoal(session.robot, home + 0.1), bench.now)
    bench.tick()
    session.pause(True)
    bench.tick()
    assert bench.commands == []


@pytest.mark.parametrize("source", ["setpoint", "measured"])
def test_a_wrench_that_is_not_borne_is_a_halt_in_every_state(source):
    bench = Bench(motor_source=source)
    session, home = bench.session, solve_home(robot("rfrfr"))
    if source == "measured":
        session.tracking.take(home.motors, bench.now)
    else:
        session.begin_at(home, home.motors + 0.5, 0.0)  # the motors are elsewhere
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
    session.reset()
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
    session.pause(True)
    bench.tick()
    session.begin_at(home, home.motors, 0.0)
    assert session.outcome.state == State.PAUSED
    assert bench.tick().state == State.PAUSED


def test_what_is_done_before_the_first_tick_is_not_that_of_before(bench):
    session = bench.session
    session.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    assert bench.tick().state == State.FOLLOWING
    session.stand()
    assert session.outcome.state == State.IDLE
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
        told.append(session.velocity)
    np.testing.assert_allclose(told[3 * every :], np.tile(speed, (7 * every, 1)), rtol=1e-6)
    session.tracking.take(home + speed * since, bench.now + 0.1)  # they stand
    for _ in range(25):
        bench.tick()
    assert not session.velocity.any()
    session.apply(replace(LIVE, measured_timeout=0.05), bench.now)
    session.tracking.take(home + speed * since + 0.05, bench.now)
    bench.tick()
    assert session.velocity.any()
    while bench.tick().state != State.STALE:
        pass
    assert not session.velocity.any()


def test_the_wrench_of_an_applied_solution_outlives_one_that_is_long_gone(bench):
    """It was dropped in the next tick if any wrench had ever come."""
    session = bench.session
    session.apply(replace(LIVE, wrench_timeout=0.1), bench.now)
    bench.push(0.05, 0.0, 0.0)
    for _ in range(30):
        bench.tick()
    np.testing.assert_array_equal(session.solver.current.equilibrium.loads.wrench_world, 0.0)
    assert session.at_rest
    loads = session.robot.default_loads.with_(wrench_world=[0, 0, 0, 0.1, 0, 0])
    pushed = solve_forward(session.robot, session.solver.current.equilibrium.motors, loads=loads)
    session.begin_at(pushed, None, 0.0)
    for _ in range(5):
        bench.tick()
    assert session.solver.current.equilibrium is pushed


def test_the_state_is_the_new_one_as_soon_as_a_request_is_answered(bench):
    """The stream came once more with IDLE before the next tick: the end of the way, it seemed."""
    session = bench.session
    bench.tick()
    for ask, state in (
        (session.reset, State.RETURNING),
        (lambda: session.pause(True), State.PAUSED),
        (lambda: session.pause(False), State.IDLE),
    ):
        ask()
        assert session.outcome.state == state
        assert not session.at_rest
    session.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    bench.tick()
    session.pause(False)  # there was none
    assert session.outcome.state == State.FOLLOWING


def test_a_pause_holds_commands_that_are_on_their_way(bench):
    """They went on to the node's equilibrium, however long that took."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.begin_at(home, home.motors + 0.1, 0.0)
    assert bench.tick().state == State.ALIGNING
    session.pause(True)
    held = bench.commands[-1]
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    assert session.at_rest
    np.testing.assert_array_equal(bench.commands[-1], held)
    session.pause(False)
    assert not session.at_rest
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(bench.commands[-1], home.motors)


def test_parameters_send_no_commands_that_a_wrench_holds_back(bench):
    """Another timeout took the wrench away, and the motors set off."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.begin_at(home, home.motors + 0.1, 0.0)
    bench.push(-500.0, 0.0, 0.0)
    outcome = bench.tick()
    assert outcome.state == State.ALIGNING
    assert outcome.refusal is not None
    bench.now += 1.0
    assert session.apply(replace(LIVE, wrench_timeout=0.5), bench.now)
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    assert bench.commands == []
    session.pause(False)
    assert bench.tick().state == State.ALIGNING
    assert len(bench.commands) == 1


def stop(session, now):
    """The usual stop of a client of trajectories: one without points."""
    endings, nothing = [], np.full(2, np.inf)
    order = TrajectoryOrder(
        np.empty(0), np.empty((0, 2)), None, None, None, nothing, nothing, np.inf
    )
    session.follow_trajectory(order, now, endings.append)
    return [ending.val for ending in endings]


def test_an_empty_trajectory_ends_the_way_home(bench):
    """It was refused as setpoints are, and the robot went on."""
    session = bench.session
    session.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    while bench.tick().state != State.IDLE:
        pass
    session.reset()
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
    session.begin_at(home, home.motors + 0.1, 0.0)
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
    session.begin_at(session.solver.current.equilibrium, motors, 0.0)


def test_another_solution_takes_the_place_of_one_that_commands_are_on_their_way_to(bench):
    """One that was applied by mistake: taken back as docs/node.md says."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 2.7, 0.5)
    assert bench.tick().state == State.ALIGNING
    apply(session, 2.5, 0.6)
    assert bench.tick().state == State.ALIGNING
    assert bench.commands[-1][0] < bench.commands[-2][0]
    session.pause(True)
    bench.tick()
    held = bench.commands[-1].copy()
    apply(session, *held, start=home)
    session.pause(False)
    for _ in range(3):
        assert bench.tick().state == State.IDLE
    np.testing.assert_array_equal(bench.commands[-1], held)
    where, expected = session.solver.current.equilibrium, solve_forward(session.robot, held)
    np.testing.assert_allclose(where.platform_position, expected.platform_position, atol=1e-9)


def test_a_solution_of_another_branch_is_applied_only_where_the_motors_are(bench):
    """They went there straight, and the robot came to the one that its own branch has there."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    other = stable_elsewhere(session.robot)
    commanded(session, home.motors)
    with pytest.raises(RequestError, match="leads to another equilibrium"):
        apply(session, 2.7, 0.5, start=other)
    for _ in range(3):
        assert bench.tick().state == State.IDLE
    assert bench.commands == []
    apply(session, *home.motors, start=other)
    assert bench.tick().state == State.IDLE
    where = session.solver.current.equilibrium.platform_position
    np.testing.assert_allclose(where, other.platform_position, atol=1e-9)
    assert bench.commands == []
    apply(session, 2.6, 0.5, start=other)  # straight on from there
    assert bench.tick().state == State.ALIGNING


def test_no_solution_beyond_a_stop_threshold_is_applied(bench):
    """629 commands led there at full speed, while the stream said HALT."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    target = PoseStamped()
    target.pose.position.y = 0.038
    with pytest.raises(RequestError, match=r"% of the way: margin would be .* below margin_stop"):
        session.solver.inverse(SolveInverse.Request(platform=target, apply=True))
    assert bench.tick().state == State.IDLE
    assert bench.commands == []


def test_the_way_to_a_solution_is_given_the_time_that_its_request_has_left(bench):
    session, home = bench.session, bench.session.solver.current
    commanded(session, home.equilibrium.motors)
    begun = session.solver.current
    # The clock stands still while it is solved.
    session.solver.clock = itertools.chain([0.0, 0.0], itertools.repeat(1e9)).__next__
    with pytest.raises(RequestError, match="before the way of the motors") as refused:
        apply(session, 2.9, 0.2)
    assert refused.value.val == ErrorCode.TIMED_OUT
    assert session.solver.current is begun


def test_commands_that_were_on_their_way_are_held_after_a_restart_until_they_are_released(
    bench, tmp_path
):
    """They set off by themselves: to where a mistake was to lead that had been paused before."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 3.2, -0.1)
    for _ in range(20):
        assert bench.tick().state == State.ALIGNING
    held = bench.commands[-1]
    kept = KeptState(tmp_path / "state", session.robot)
    kept.keep(session.solver.current.equilibrium, held)
    again = Bench()
    said = begin_at_last(again.session, kept.last())
    assert said.startswith(
        "where it was last, motors (3.2, -0.1); commands were on their way there"
    )
    assert said.endswith(HELD)
    again.session.stand()
    for _ in range(5):
        assert again.tick().state == State.PAUSED
    assert again.commands == []
    again.session.pause(False)
    assert again.tick().state == State.ALIGNING
    step = np.abs(again.commands[0] - held).max()
    assert 0.0 < step <= PERIOD * (1.0 + 1e-6)
    kept.close()


def test_no_solution_is_applied_while_the_robot_is_on_its_way_home(bench):
    """It dropped the way home that waited for the commands, too, without a word."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    apply(session, 2.7, 0.5)
    assert bench.tick().state == State.ALIGNING
    session.reset()
    for _ in range(2):
        with pytest.raises(RequestError, match="the robot is on its way"):
            apply(session, 2.6, 0.5)
        bench.tick()
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(bench.commands[-1], home)
    apply(session, 2.6, 0.5)


def test_no_solution_is_applied_while_paused(bench):
    """The motors set off to it as soon as the pause was over."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.pause(True)
    bench.tick()
    with pytest.raises(RequestError, match="paused"):
        apply(session, 2.7, 0.5)
    session.pause(False)
    assert bench.tick().state == State.IDLE
    assert bench.commands == []


def test_no_solution_is_applied_in_place_of_a_setpoint_that_has_just_come(bench):
    session = bench.session
    session.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    with pytest.raises(RequestError, match="the robot is on its way"):
        apply(session, 2.6, 0.5)
    stop(session, bench.now)  # as the message says
    apply(session, 2.6, 0.5)


def test_no_solution_is_applied_while_a_trajectory_is_being_solved(bench):
    """It ended the trajectory: the robot had been moved."""
    session, endings = bench.session, []
    home = session.solver.current.equilibrium.motors
    motion = still(session, home, bench.now, 300.0, endings.append)
    assert motion.goal is None
    with pytest.raises(RequestError, match="a trajectory is to be followed"):
        apply(session, 2.6, 0.5)
    assert not endings
    stop(session, bench.now)  # as the message says
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]
    apply(session, 2.6, 0.5)


def test_no_solution_is_applied_and_no_rest_had_while_somebody_waits_for_a_goal(bench):
    """One that waits to be measured where it is: ticks tell, and it went elsewhere without a word."""
    session = bench.session
    goal = MotorGoal(session.robot, [2.6, 0.55])
    session.follow(goal, bench.now, ages=False)
    session.admission.awaited = goal
    while bench.tick().state != State.IDLE:
        pass
    assert not session.at_rest
    with pytest.raises(RequestError, match="a goal of ~/move_to waits"):
        apply(session, 2.6, 0.5)
    session.follow(MotorGoal(session.robot, [2.6, 0.55]), bench.now, ages=False)  # nobody's
    bench.tick()
    assert session.at_rest
    apply(session, 2.6, 0.5)


def measured_for(bench, motors, seconds=1.0):
    """Measured motors ten times a second; whether the robot had to begin there."""
    begin = False
    for _ in range(round(10 * seconds)):
        bench.now += 0.1
        begin = begin or bench.session.take_measured(np.array(motors), bench.now)
        bench.tick()
    return begin


def test_motors_that_others_have_moved_are_not_sent_back(bench):
    """The last command was said again, and the next motion began there: at once, 0.5 rad away."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    assert not measured_for(bench, home.motors)
    np.testing.assert_array_equal(session.repeated_command(bench.now), home.motors)
    session.follow(MotorGoal(session.robot, home.motors), bench.now)
    bench.tick()
    elsewhere = home.motors + [0.1, -0.4]
    assert not measured_for(bench, elsewhere, 0.3)  # they may still be moved
    assert session.repeated_command(bench.now) is None
    assert session.follower.goal is None
    assert "somebody else has moved the motors" in session.follower.dropped
    for ask in (
        lambda: session.follow(MotorGoal(session.robot, home.motors), bench.now),
        lambda: still(session, home.motors, bench.now),
        lambda: apply(session, 2.6, 0.5),
        session.reset,
    ):
        with pytest.raises(RequestError, match="somebody else has moved the motors"):
            ask()
    assert measured_for(bench, elsewhere, 0.5)
    begin_at_measured(session, elsewhere)
    assert bench.commands == []
    assert not measured_for(bench, elsewhere)
    assert bench.commands == []
    held = session.repeated_command(bench.now)
    assert held is None  # nobody asked them to hold against what held them off
    session.follow(MotorGoal(session.robot, elsewhere + 0.01), bench.now)
    assert bench.tick().state == State.FOLLOWING
    assert np.abs(bench.commands[0] - elsewhere).max() <= PERIOD * (1.0 + 1e-5)
    np.testing.assert_array_equal(session.repeated_command(bench.now), bench.commands[0])


def lagging(bench, target, max_lead, time_constant, ticks):
    """Follow a setpoint with motors that lag; ways of commands from where they were measured last."""
    session, motors = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, max_lead=max_lead), bench.now)
    commanded(session, motors)
    session.take_measured(motors, bench.now)
    session.follow(MotorGoal(session.robot, target), bench.now)
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
    assert bench.session.outcome.state == State.IDLE


def test_commands_wait_for_a_motor_that_jams_and_say_so(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(80):
        session.take_measured(home, bench.now)
        bench.tick()
    lead = LIVE.max_lead * SETTINGS.max_speed
    np.testing.assert_allclose(bench.commands[-1] - home, [0.0, lead], rtol=2e-3, atol=1e-12)
    assert "the commands wait for a motor" in session.senses.unseen(bench.now)
    assert session.follower.waits
    sent, outcome = len(bench.commands), bench.tick()
    assert len(bench.commands) == sent
    assert (outcome.state, outcome.moved) == (State.FOLLOWING, False)
    assert not session.at_rest
    for _ in range(400):  # it goes on
        session.take_measured(bench.commands[-1], bench.now)
        bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], home + [0.0, 0.5])
    assert session.senses.unseen(bench.now) == ""


def test_what_is_held_off_farther_than_max_lead_does_not_hear_the_last_command_again(bench):
    """A controller that comes later would jump there."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, max_lead=PERIOD), bench.now)
    commanded(session, home)
    for way in (0.5, 1.0, 1.5, 15.0):
        session.take_measured(home + [0.0, way * PERIOD * SETTINGS.max_speed], bench.now)
        assert (session.repeated_command(bench.now) is not None) == (way <= 1.0)
    session.apply(replace(LIVE, max_lead=0.2), bench.now)
    assert session.repeated_command(bench.now) is not None


def test_there_is_a_way_back_from_a_motor_that_jams(bench):
    """Whatever is asked for that takes no motor farther from where it is measured."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, settings=replace(SETTINGS, max_speed=0.4)), bench.now)
    commanded(session, home)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for ask in (None, session.reset):
        if ask:
            ask()
        for _ in range(90):
            session.take_measured(home, bench.now)
            bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], home)
    assert session.outcome.state == State.IDLE
    assert not session.others.away


@pytest.mark.parametrize(("speed", "begins_there"), [(1.0, True), (0.2, False)])
def test_a_motor_that_stays_jammed_ends_what_waits_for_it(bench, speed, begins_there):
    """A setpoint of long ago would set off when it has power again; near its command it stays there."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, settings=replace(SETTINGS, max_speed=speed)), bench.now)
    commanded(session, home)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    ticks, begin = 0, False
    while session.follower.goal is not None:
        begin = session.take_measured(home, bench.now) or begin
        bench.tick()
        ticks += 1
    assert ticks == pytest.approx(0.5 / PERIOD, abs=3)
    assert "the motors do not follow: one was measured" in session.follower.dropped
    for _ in range(200):
        begin = session.take_measured(home, bench.now) or begin
        bench.tick()
    assert begin == begins_there
    assert np.abs(bench.commands[-1] - home).max() <= LIVE.max_lead * speed * (1.0 + 1e-5)


def jammed(bench):
    """Commands wait for a motor."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, measured_timeout=0.1), bench.now)
    commanded(session, home)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    while not session.follower.waits or bench.tick().moved:
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
    assert session.apply(replace(LIVE, **changed), bench.now)
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
    session.follow(MotorGoal(session.robot, bench.commands[-1] + 0.1), bench.now)
    bench.tick()
    assert len(bench.commands) == sent + 1  # who sends another one knows that


def test_a_jammed_motor_ends_what_waits_for_it_without_a_tolerance_too(bench):
    """No tolerance is for motors that are held off; a goal without end is for nobody."""
    session, home = jammed(bench)
    session.apply(replace(LIVE, moved_tolerance=0.0), bench.now)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    sent, begin = len(bench.commands), False
    for _ in range(200):
        begin = session.take_measured(home, bench.now) or begin
        bench.tick()
    assert session.follower.goal is None and not begin
    assert "the motors do not follow: one was measured" in session.left_behind
    assert len(bench.commands) == sent and not session.others.in_question


def test_motors_that_are_measured_once_hold_no_goal_up_for_ever(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.take_measured(home, bench.now)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(400):
        bench.tick()
    assert session.follower.goal is None
    assert "measured only once, max_lead has to be 0" in session.follower.dropped
    session.apply(replace(LIVE, max_lead=0.0), bench.now)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(400):
        bench.tick()
    np.testing.assert_array_equal(bench.commands[-1], home + [0.0, 0.5])


def test_what_is_told_of_a_robot_that_waits_is_that_it_is_not_seen(bench):
    session, _ = jammed(bench)
    told = session.told(bench.now)
    assert session.outcome.verdict.action == Action.NONE
    assert (told.action, told.speed_scale) == (Action.SLOW, BLIND)
    assert "the commands wait for a motor" in told.text


def test_a_trajectory_that_parameters_end_is_told_so(bench):
    session, endings = bench.session, waiting(bench, 0.0, [0.0, 0.4])
    home = session.solver.current.equilibrium.motors
    while not session.follower.waits:
        session.take_measured(home, bench.now)
        bench.tick()
    session.apply(replace(LIVE, max_lead=0.3), bench.now)
    bench.tick()
    [ending] = endings
    assert ending.val == ErrorCode.PREEMPTED and ending.message.startswith("parameters changed")


def test_a_trajectory_that_waits_for_motors_that_are_measured_no_more_fails(bench):
    session, endings = bench.session, waiting(bench, 0.0, [0.0, 0.4])
    home = session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, measured_timeout=0.1), bench.now)
    for _ in range(60):
        session.take_measured(home, bench.now)
        bench.tick()
    assert session.follower.waits
    assert not endings
    for _ in range(30):
        bench.tick()
    assert [ending.val for ending in endings] == [ErrorCode.CONTROL_FAILED]
    assert "the measured motors are older than" in endings[0].message


def test_commands_on_their_way_wait_too_and_a_parameter_lets_them_not_go_on(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    apply(session, 2.9, 0.5)
    for _ in range(60):
        session.take_measured(home, bench.now)
        bench.tick()
    sent = len(bench.commands)
    np.testing.assert_allclose(np.abs(bench.commands[-1] - home).max(), 0.2, rtol=1e-5)
    assert bench.session.outcome.state == State.ALIGNING
    assert "the commands wait for a motor" in session.senses.unseen(bench.now)
    session.apply(replace(LIVE, max_lead=0.0), bench.now)
    for _ in range(20):
        session.take_measured(home, bench.now)
        bench.tick()
    assert len(bench.commands) == sent
    assert session.outcome.state == State.PAUSED
    session.pause(False)
    session.take_measured(bench.commands[-1], bench.now)
    bench.tick()
    assert len(bench.commands) == sent + 1


def test_commands_on_their_way_are_held_where_motors_are_measured_no_more(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, measured_timeout=0.1), bench.now)
    commanded(session, home)
    apply(session, 2.9, 0.5)
    for number in range(100):
        if number < 60:
            session.take_measured(home, bench.now)
        bench.tick()
    np.testing.assert_allclose(np.abs(bench.commands[-1] - home).max(), 0.2, rtol=1e-5)
    assert session.outcome.state == State.PAUSED
    assert session.at_rest  # it is ended once, not in every tick
    sent = len(bench.commands)
    session.pause(False)  # who releases them knows that
    bench.tick()
    assert len(bench.commands) == sent + 1


def test_without_max_lead_commands_go_on_until_motors_are_found_not_to_follow(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    session.apply(replace(LIVE, max_lead=0.0), bench.now)
    commanded(session, home)
    session.follow(MotorGoal(session.robot, home + [0.0, 0.5]), bench.now)
    for _ in range(60):
        session.take_measured(home, bench.now)
        bench.tick()
    way = [0.0, 60 * PERIOD * SETTINGS.max_speed]
    np.testing.assert_allclose(bench.commands[-1] - home, way, rtol=1e-6, atol=1e-12)
    assert session.senses.unseen(bench.now) == ""


def test_what_a_goal_was_told_of_motors_elsewhere_stays_known(bench):
    """A goal that ended by it was told these words, and motors move on."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    told = []
    for way in (0.2, 0.4):
        session.follow(MotorGoal(session.robot, home), bench.now)
        bench.tick()
        measured_for(bench, home + way, 0.2)
        told.append(session.left_behind)
        assert told[-1] == session.follower.dropped == session.others.away != ""
        measured_for(bench, home + way + 0.05, 0.2)
        assert session.others.away != told[-1]
        assert session.left_behind == told[-1]
        measured_for(bench, home, 0.2)
        assert session.others.away == ""
    assert told[0] != told[1]


@pytest.fixture
def moved(bench):
    """A robot that others have moved, and that is measured no more."""
    motors = bench.session.solver.current.equilibrium.motors
    commanded(bench.session, motors)
    for way in np.arange(0.0, 0.4, 0.02):  # by a hand, at rest nowhere
        assert not measured_for(bench, motors + way, 0.1)
    assert bench.session.others.away
    return bench


def halted(bench):
    """Whether a supervisor is told that others have moved the motors; nothing is sent to them."""
    sent, outcome = len(bench.commands), bench.tick()
    assert len(bench.commands) == sent
    assert outcome is bench.session.outcome
    told = outcome.verdict
    assert bench.session.at_rest
    if told.action == Action.NONE:
        return False
    assert (told.action, told.speed_scale) == (Action.HALT, 0.0)
    assert told.text == bench.session.others.away != ""
    return True


def test_that_others_have_moved_the_motors_is_a_halt_until_they_are_measured_where_sent(moved):
    """Every setpoint was refused, and `action` was NONE."""
    session, home = moved.session, moved.session.solver.current.equilibrium
    assert session.known_place == (home, None)  # a node of later has to measure them
    for _ in range(3):
        moved.now += 100.0
        assert halted(moved)
        session.pause(True)
        assert halted(moved)
        session.pause(False)
    session.stand()
    assert halted(moved)
    with pytest.raises(RequestError, match="somebody else has moved the motors"):
        session.follow(MotorGoal(session.robot, home.motors), moved.now)
    session.take_measured(home.motors + 0.05, moved.now)
    assert not session.at_rest
    assert not halted(moved)
    np.testing.assert_array_equal(session.known_place[1], home.motors)
    session.follow(MotorGoal(session.robot, home.motors + 0.1), moved.now)
    assert moved.tick().state == State.FOLLOWING


def test_no_moved_tolerance_ends_it_and_sends_nothing_by_itself(moved):
    session, home = moved.session, moved.session.solver.current.equilibrium
    session.apply(replace(LIVE, moved_tolerance=0.0, max_lead=0.0), moved.now)
    assert not session.at_rest
    assert not halted(moved)
    assert session.repeated_command(moved.now) is None
    session.follow(MotorGoal(session.robot, home.motors + 0.1), moved.now)
    moved.tick()
    np.testing.assert_array_equal(session.repeated_command(moved.now), moved.commands[-1])


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
    assert session.others.away and bench.tick().state == State.ALIGNING
    sent = len(bench.commands)
    session.apply(replace(LIVE, moved_tolerance=0.0), bench.now)
    assert bench.tick().state == State.PAUSED
    assert len(bench.commands) == sent


def test_a_tracked_robot_is_remembered_where_it_is_measured_and_not_where_it_is_lost():
    bench = Bench(motor_source="measured")
    session, home = bench.session, bench.session.solver.current.equilibrium
    assert session.known_place is None
    session.tracking.take(home.motors + 0.05, bench.now)
    assert bench.tick().state == State.TRACKING
    equilibrium, motors = session.known_place
    assert equilibrium is session.solver.current.equilibrium
    np.testing.assert_array_equal(motors, home.motors + 0.05)
    for shift in np.linspace(0.0, 4.0, 200):
        session.tracking.take(home.motors + [shift, -shift], bench.now)
        state = bench.tick().state
    assert state == State.LOST
    assert session.known_place == (session.solver.current.equilibrium, None)


def test_a_trajectory_that_waits_ends_where_others_move_the_motors(bench):
    session, home, endings = bench.session, bench.session.solver.current.equilibrium, []
    commanded(session, home.motors)
    nothing = np.full(2, np.inf)
    points = np.array([home.motors, home.motors])
    order = TrajectoryOrder(
        np.array([0.0, 0.5]), points, None, None, 30.0, nothing, nothing, np.inf
    )
    session.follow_trajectory(order, bench.now, endings.append)
    measured_for(bench, home.motors + 0.3, 0.8)
    assert [ending.val for ending in endings] == [ErrorCode.CONTROL_FAILED]  # as goals of ~/move_to
    assert "somebody else has moved the motors" in endings[0].message


def waiting(bench, seconds, way=0.0):
    """A trajectory that begins later, and how it ends."""
    session, home, endings = bench.session, bench.session.solver.current.equilibrium, []
    commanded(session, home.motors)
    any_error, points = np.full(2, np.inf), np.array([home.motors, home.motors + way])
    times = np.array([0.0, 0.5])
    order = TrajectoryOrder(times, points, None, None, seconds, any_error, any_error, np.inf)
    session.follow_trajectory(order, bench.now, endings.append)
    return endings


def test_one_wrong_measurement_ends_nothing_and_halts_nothing(bench):
    """A glitch of an encoder ended a trajectory that waited for its time."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    endings = waiting(bench, 2.0)
    measured_for(bench, home.motors)
    bench.now += 0.1
    assert not session.take_measured(home.motors + 3.0, bench.now)
    assert bench.tick().verdict.action == Action.NONE
    assert session.repeated_command(bench.now) is None  # it may be true
    with pytest.raises(RequestError, match="the next measurements tell whether somebody has moved"):
        session.follow(MotorGoal(session.robot, home.motors), bench.now)
    measured_for(bench, home.motors)
    assert (endings, session.repeated_command(bench.now) is None) == ([], False)
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
        session.look_around(bench.now + age, False)
        assert endings == []
    session.look_around(bench.now + 0.5, False)
    assert "somebody else has moved the motors" in endings[0].message
    assert bench.tick().verdict.action == Action.HALT


def test_commands_that_a_pause_holds_do_not_go_on_where_others_have_moved_the_motors(bench):
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 2.7, 0.5)
    bench.tick()
    session.pause(True)
    sent = len(bench.commands)
    measured_for(bench, home.motors + 0.5, 0.8)
    session.pause(False)
    bench.tick()
    assert len(bench.commands) == sent


def test_motors_in_motion_are_not_compared(bench):
    """They are late: that is no reason to end the motion."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.apply(replace(LIVE, max_lead=0.0), bench.now)  # else commands wait for them
    commanded(session, home.motors)
    session.follow(MotorGoal(session.robot, home.motors + [0.5, -0.5]), bench.now)
    while bench.tick().state != State.IDLE:
        assert not session.take_measured(home.motors, bench.now)
    np.testing.assert_array_equal(bench.commands[-1], home.motors + [0.5, -0.5])


def test_motors_that_are_measured_no_more_are_missed(bench):
    """The action was NONE, whatever the motors did."""
    session = bench.session
    session.apply(replace(LIVE, measured_timeout=1.5), bench.now)
    assert session.senses.unseen(bench.now) == ""  # nobody has measured them
    session.measured.refuse("names: expected motor1 motor2")
    assert "no measured motors are of use: names" in session.senses.unseen(bench.now)
    session.take_measured(np.array([2.59, 0.55]), bench.now)
    assert session.senses.unseen(bench.now + 1.5) == ""
    for later in (1.51, 100.0):  # the same words, which are not a new message every time
        why = session.senses.unseen(bench.now + later)
        assert why == "the measured motors are older than measured_timeout 1.5 s"
    session.apply(replace(LIVE, measured_timeout=0.0), bench.now)
    assert session.senses.unseen(bench.now + 101.0) == ""
    tracked = Bench(motor_source="measured").session
    tracked.measured.refuse("names")
    assert tracked.senses.unseen(1.0) == ""  # of these the state tells


def test_what_is_not_seen_is_moved_at_half_the_speed(bench):
    """A supervisor was told of half the speed, and commands went out at the whole one."""
    session = bench.session
    home = session.solver.current.equilibrium
    session.begin_at(home, home.motors, 0.0)
    session.apply(replace(LIVE, measured_timeout=0.5), bench.now)
    session.take_measured(home.motors, bench.now)
    bench.now += 1.0
    session.follow(MotorGoal(session.robot, home.motors + 0.1), bench.now, ages=False)

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
    session.begin_at(home, home.motors, 0.0)
    session.apply(replace(LIVE, wrench_timeout=0.5), bench.now)
    session.follow(PoseGoal(session.robot, home.pose), bench.now, ages=False)
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
    session.follow(PoseGoal(session.robot, home.pose), bench.now, ages=False)
    while bench.tick().state != State.IDLE:  # who wants the pose all the same has it
        pass
    np.testing.assert_allclose(session.commands.newest, home.motors, atol=1e-7)
    bench.push(0.1, 0.0, 0.0)
    assert session.senses.unseen(bench.now + 1.0) == ""


def test_motors_that_are_measured_too_seldom_are_missed_all_along(bench):
    """The action was SLOW and NONE in turn, with every message, and the log told of each."""
    session = bench.session
    session.apply(replace(LIVE, measured_timeout=0.5), bench.now)
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
        monkeypatch.setattr(bench.session, "loop_status", lambda now, status=status: status)
        assert bench.session.senses.unseen(bench.now) == unseen
    monkeypatch.setattr(bench.session, "loop_status", lambda now: LoopStatus(Loop.CLOSED))
    assert bench.session.senses.unseen(bench.now + 0.5).startswith("the pose jumped; it came again")
    monkeypatch.setattr(bench.session, "loop_status", lambda now: LoopStatus(Loop.OPEN))
    assert bench.session.senses.unseen(bench.now + 0.5) == ""  # nobody asks where the platform is
    monkeypatch.setattr(bench.session, "loop_status", lambda now: LoopStatus(Loop.CLOSED))
    assert bench.session.senses.unseen(bench.now + 0.5) == ""


def test_a_robot_waits_for_a_measurement_until_it_moves(bench):
    session = bench.session
    session.unplaced = True
    bench.push(0.2, 0.0, 0.0)
    bench.tick()
    assert session.unplaced
    session.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    bench.tick()
    assert not session.unplaced


def test_the_command_of_a_tick_is_there_before_note_is_taken_of_it(bench):
    session = bench.session
    session.commands.place(session.solver.current.equilibrium.motors)
    session.follow(MotorGoal(session.robot, [2.60, 0.56]), bench.now)
    bench.tick()
    before, places = session.velocity, session.loop._history.newest
    bench.now += PERIOD
    assert session.move(bench.now).moved
    np.testing.assert_array_equal(
        session.next_command(bench.now), session.solver.current.equilibrium.motors
    )
    assert session.velocity is before and session.loop._history.newest is places
    session.take_note(bench.now)
    way = session.solver.current.equilibrium.motors - bench.commands[-1]
    np.testing.assert_allclose(session.velocity, way / PERIOD)
    assert session.loop._history.newest.equilibrium is session.solver.current.equilibrium


class Node(Bench):
    """As the node does it: what is judged already is commanded before it is solved."""

    def __init__(self, **parameters):
        super().__init__(**parameters)
        self.ahead = []

    def rest(self, seconds=0.2):
        end = self.now + seconds
        while self.now < end:
            self.now += PERIOD
            if not self.session.at_rest:
                self.do_tick()
            self.session.look_around(self.now, self.session.at_rest)

    def tick(self):
        self.now += PERIOD
        return self.do_tick()

    def do_tick(self):
        ahead = self.session.command_ahead(self.now)
        self.ahead += [] if ahead is None else [ahead]
        outcome = self.session.move(self.now)
        command = self.session.next_command(self.now)
        self.commands += [each for each in (ahead, command) if each is not None]
        self.session.take_note(self.now)
        return outcome


@pytest.fixture
def node():
    bench = Node()
    bench.session.commands.place(bench.session.solver.current.equilibrium.motors)
    bench.rest()
    return bench


def test_the_first_command_out_of_rest_is_ahead_of_its_solution_and_the_only_one(node):
    session, random = node.session, np.random.default_rng(11)
    for _ in range(20):
        target = session.solver.current.equilibrium.motors + random.uniform(-0.02, 0.02, 2)
        session.follow(MotorGoal(session.robot, target), node.now)
        before, sent = session.commands.newest, len(node.commands)
        assert node.tick().obeyed
        assert len(node.commands) == sent + 1
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
        session.follow(PoseGoal(robot, pose), node.now)
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
    session.follow(PoseGoal(session.robot, pose + 0.001), node.now)
    with monkeypatch.context() as patched:
        patched.setattr(session.loop, "at_rest", lambda goal: False)  # a correction is on its way
        assert session.command_ahead(node.now) is None
    assert session.command_ahead(node.now) is not None
    node.rest(1.0)
    twist = PlatformTwist(np.array([0.0, 0.0, 0.0, 0.01, 0.0, 0.0]), in_platform=False)
    session.jog(twist, node.now)
    assert session.command_ahead(node.now) is None


@pytest.mark.parametrize("behind", [0.0, PERIOD])
def test_a_first_command_that_motors_hold_up_is_solved_first(node, behind):
    """Half of it went out ahead, and the robot was then to wait until the other half could follow."""
    session, home = node.session, node.session.solver.current.equilibrium.motors
    session.commands.max_lead = 1.5 * PERIOD
    session.take_measured(home - behind * SETTINGS.max_speed, node.now)
    session.follow(MotorGoal(session.robot, home + 0.1), node.now)
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
        bench.session.follow(goals[given], bench.now)
        while bench.tick().state != State.IDLE:
            pass
    assert len(node.ahead) == 1
    np.testing.assert_array_equal(node.commands, plain.commands)


def test_a_first_step_that_is_refused_after_all_is_taken_back(node, monkeypatch):
    session, home = node.session, node.session.solver.current.equilibrium.motors
    session.follow(MotorGoal(session.robot, home + 0.1), node.now)
    refused = Undecided("not_converged", "for a test")
    with monkeypatch.context() as patched:
        patched.setattr(JudgedSteps, "_danger", lambda *_: refused)
        for _ in range(30):
            node.tick()
        np.testing.assert_array_equal(session.solver.current.equilibrium.motors, home)
        np.testing.assert_array_equal(session.commands.newest, home)
        assert session.outcome.state == State.HALTED
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
        lambda node: node.session.pause(True),
        lambda node: node.session.commands.place(None),
        lambda node: measured_for(node, node.session.commands.newest + 0.5, 0.4),
        lambda node: node.session.commands.place(node.session.commands.newest + 0.001),
        lambda node: node.session.apply(
            replace(LIVE, settings=replace(SETTINGS, max_speed=2.0)), node.now
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
    session.outcome = replace(session.outcome, refusal=Refusal("margin", "for a test"))
    session.follow(MotorGoal(session.robot, session.commands.newest + 0.01), node.now)
    node.tick()
    assert node.ahead == []


def test_who_tracks_motors_or_is_paused_does_not_look_around(node):
    tracked = Node(motor_source="measured")
    tracked.session.look_around(1.0, True)
    assert math.isinf(tracked.session.first_step.due)
    node.session.pause(True)
    node.session.look_around(node.now, True)
    assert math.isinf(node.session.first_step.due)
    node.session.pause(False)
    node.session.apply(replace(LIVE, settings=replace(SETTINGS, max_speed=2.0)), node.now)
    node.session.look_around(node.now, True)
    assert node.session.first_step.due > node.now
    node.session.look_around(node.now, False)  # it moves, or is not active
    assert math.isinf(node.session.first_step.due)


def timed(points, start_in):
    """A trajectory with a stamp, a point a second."""
    points, nothing = np.array(points), np.full(2, np.inf)
    times = np.arange(1.0, len(points) + 1.0)
    return TrajectoryOrder(times, points, None, None, start_in, nothing, nothing, np.inf)


def test_a_place_that_is_found_late_ends_a_setpoint_that_was_thought_reached(bench):
    """Any tick, after a change of parameters say, then sent the robot back to where it had been."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.begin_at(home, home.motors, 0.0)  # the last command, of a node before
    session.follow(MotorGoal(session.robot, home.motors), bench.now)
    bench.tick()
    found = solve_forward(session.robot, home.motors + [0.3, -0.2])
    session.begin_at(found, found.motors, 0.0)
    assert session.follower.goal is None
    assert "elsewhere" in session.follower.dropped
    session.apply(replace(LIVE, settings=replace(SETTINGS, hysteresis=0.2)), bench.now)
    for _ in range(5):
        assert bench.tick().state == State.IDLE
    assert bench.commands == []


def test_a_place_that_is_found_late_ends_a_trajectory_that_waits(bench):
    """It never began and never ended."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.begin_at(home, home.motors, 0.0)
    endings = []
    session.follow_trajectory(timed([home.motors + 0.1], 1.0), bench.now, endings.append)
    for _ in range(5):
        bench.tick()
    found = solve_forward(session.robot, home.motors + [0.3, -0.2])
    session.begin_at(found, found.motors, 0.0)
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]
    bench.tick()
    assert bench.commands == []
    assert session.at_rest


def test_a_trajectory_sends_nothing_before_its_stamp_to_motors_of_which_nothing_is_known(bench):
    """They were sent home at once, perhaps minutes before."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    points = [home.motors, home.motors + 0.01]
    session.follow_trajectory(timed(points, 0.5), bench.now, lambda _: None)
    while bench.now < 0.45:
        bench.tick()
    assert bench.commands == []
    while bench.now < 3.0:
        bench.tick()
    np.testing.assert_allclose(bench.commands[0], home.motors, atol=1e-3)
    np.testing.assert_allclose(bench.commands[-1], home.motors + 0.01, atol=1e-12)


def test_a_return_that_a_wrench_holds_up_can_be_replaced(bench):
    session = bench.session
    session.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    while bench.tick().state != State.IDLE:
        pass
    session.reset()
    bench.tick()
    with pytest.raises(RequestError, match="on its way home"):
        session.follow(MotorGoal(session.robot, [2.65, 0.52]), bench.now)
    bench.push(-1e4, 0.0, 0.0)
    assert bench.tick().state == State.HALTED
    session.follow(MotorGoal(session.robot, [2.65, 0.52]), bench.now)
    assert not session.follower.returning


def test_a_setpoint_that_is_dropped_while_commands_are_on_their_way_holds_them(bench):
    """Cancelled goals were said to hold, and the motors went on."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    session.begin_at(home, home.motors + 0.1, 0.0)
    session.follow(MotorGoal(session.robot, home.motors + 0.2), bench.now)
    assert bench.tick().state == State.ALIGNING
    held = bench.commands[-1]
    session.drop()
    for _ in range(5):
        assert bench.tick().state == State.PAUSED
    np.testing.assert_array_equal(bench.commands[-1], held)
