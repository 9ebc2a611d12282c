# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A goal of ``~/move_to`` that ends, on a clock of the test."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from cpr_msgs.action import MoveTo
from cpr_msgs.msg import ErrorCode
from geometry_msgs.msg import PoseStamped
from helpers.closed_loop import FRAMES, PERIOD, ClosedLoop, live
from helpers.session_bench import ticked
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cpr_core import InvalidRequest
from cpr_ros.following.goals import PoseGoal
from cpr_ros.following.moved_by_others import SETTLING
from cpr_ros.following.supervision import State
from cpr_ros.interface.move_action import MoveAction, goal_of
from cpr_ros.operation.between_ticks import BetweenTicks
from cpr_ros.operation.live_changes import apply_live
from cpr_ros.operation.starting_place import begin_at, begin_at_measured


def test_out_of_patience_it_holds_commands_that_a_wrench_held_back(bare_node, monkeypatch):
    """They went out as soon as the wrench was gone, of a goal that had failed."""
    bench = ClosedLoop("rfrfr")
    session, home = bench.session, bench.model
    apply_live(session, live(wrench_timeout=2.0), bench.now)
    begin_at(session, home, home.motors + 0.1, 0.0)
    pushed = home.loads.with_(wrench_world=[0, 0, 0, -500.0, 0, 0])
    session.wrench.take(pushed, bench.now)
    action, results = MoveAction(bare_node, FRAMES, lambda: session), []
    monkeypatch.setattr(action, "_finish", lambda handle, val, result: results.append(result))
    motors = JointState(name=[*session.robot.motor_names], position=home.motors.tolist())
    request = MoveTo.Goal(given=MoveTo.Goal.GIVEN_MOTORS, motors=motors, patience=0.5)
    told = SimpleNamespace(
        request=request, is_cancel_requested=False, publish_feedback=lambda feedback: None
    )
    action._begin(told)
    states, commands = [], []
    for _ in range(int(3.0 / PERIOD)):
        bench.now += PERIOD
        outcome, command = ticked(session, bench.now)
        states.append(outcome.state)
        commands.append(command)
        action.after_tick(session, bench.now)
    assert states[0] == State.ALIGNING
    assert [result.error_code.val for result in results] == [ErrorCode.CONTROL_FAILED]
    assert states[-1] == State.PAUSED
    assert all(command is None for command in commands)


@pytest.mark.parametrize(
    ("filled", "field", "words"),
    [
        ({}, "platform", "expected a pose, got none"),
        ({"motors": JointState(name=["motor1"])}, "given", "or GIVEN_MOTORS, 1"),
        ({"motors": JointState(position=[2.6, 0.5])}, "given", "or GIVEN_MOTORS, 1"),
    ],
)
def test_a_goal_that_does_not_say_what_it_is_is_refused(filled, field, words):
    """GIVEN_POSE is what nobody has written: it went to the origin of the world, up to a limit."""
    with pytest.raises(InvalidRequest, match=f"{field}: .*{words}"):
        goal_of(ClosedLoop("rfrfr").session, MoveTo.Goal(**filled), FRAMES)


def test_the_origin_is_a_pose_where_its_frame_is_named():
    request = MoveTo.Goal(platform=PoseStamped(header=Header(frame_id=FRAMES.base)))
    goal = goal_of(ClosedLoop("rfrfr").session, request, FRAMES)
    assert isinstance(goal, PoseGoal)


class Machine:
    """A session and the motors it commands, which are measured where they are."""

    def __init__(self, bare_node, monkeypatch, **parameters):
        self.bench = ClosedLoop("rfrfr", **parameters)
        self.session, self.home = self.bench.session, self.bench.model.motors.copy()
        self.action, self.results, self.feedback = (
            MoveAction(bare_node, FRAMES, lambda: self.session),
            [],
            [],
        )
        self.action.arrived_tolerance = live(**parameters).arrived_tolerance
        monkeypatch.setattr(
            self.action, "_finish", lambda handle, val, result: self.results.append(result)
        )
        self.motors = self.home
        self.begun = math.nan

    def send(self, motors, patience=0.0):
        names = [*self.session.robot.motor_names]
        state = JointState(name=names, position=np.asarray(motors, float).tolist())
        self._begin(MoveTo.Goal(given=MoveTo.Goal.GIVEN_MOTORS, motors=state, patience=patience))

    def send_pose(self, x, y):
        request = MoveTo.Goal(given=MoveTo.Goal.GIVEN_POSE)
        request.platform.pose.position.x, request.platform.pose.position.y = x, y
        self._begin(request)

    def _begin(self, request):
        self.begun = self.bench.now
        self.action._begin(
            SimpleNamespace(
                request=request,
                is_cancel_requested=False,
                publish_feedback=self.feedback.append,
            )
        )

    def run(self, seconds, moved, every=1):
        """Go on until there is a result; ``moved`` is where motors go in a tick, by their commands.

        Returns:
            How long it took [s].
        """
        for number in range(round(seconds / PERIOD)):
            self.bench.now += PERIOD
            self.motors = moved(self.motors, self.session.commands.newest)
            measured = bool(every) and number % every == 0
            if measured and self.session.take_measured(self.motors, self.bench.now):
                begin_at_measured(self.session, self.motors)
            ticked(self.session, self.bench.now)
            self.action.after_tick(self.session, self.bench.now)
            BetweenTicks(self.session, lambda: False).look(self.bench.now)
            if self.results:
                break
        return self.bench.now - self.begun

    @property
    def told(self):
        """Number and message of the only result."""
        (result,) = self.results
        return result.error_code.val, result.error_code.message


def lagging(seconds):
    share = -math.expm1(-PERIOD / seconds)
    return lambda motors, commands: motors + share * (commands - motors)


def without_power(motors, commands):
    return motors


@pytest.fixture
def machine(bare_node, monkeypatch):
    return Machine(bare_node, monkeypatch)


@pytest.mark.parametrize("pose", [False, True])
@pytest.mark.parametrize("lag", [0.05, 0.15])
def test_motors_that_lag_behind_are_waited_for(machine, pose, lag):
    if pose:
        machine.send_pose(0.1, 0.7)
    else:
        machine.send(machine.home + [0.4, -0.4])
    machine.run(5.0, lagging(lag))
    assert machine.told == (ErrorCode.SUCCESS, "")
    left = np.abs(machine.motors - machine.session.commands.newest).max()
    assert 0.5 * machine.action.arrived_tolerance < left <= machine.action.arrived_tolerance
    assert machine.results[0].remaining == 0.0


@pytest.mark.parametrize(("max_lead", "way_left"), [(0.0, 0.4), (0.2, 0.2)])
@pytest.mark.parametrize("every", [1, 50])
def test_motors_without_power_do_not_succeed(machine, every, max_lead, way_left):
    """They were said to be there as soon as their commands were, with all of the way to go.

    However seldom they are measured: one message may tell that they rest elsewhere, and place the robot.
    """
    machine.session.measured.watchdog.timeout = 0.0
    machine.session.commands.max_lead = max_lead
    machine.send(machine.home + [0.4, -0.4], patience=2.0)
    machine.run(3.0, without_power, every)
    val, message = machine.told
    assert val == ErrorCode.CONTROL_FAILED
    assert "moved_tolerance" in message
    assert "motor1 is measured at 2.59 rad, its command is 2." in message
    assert "motor2 is measured at 0.55 rad, its command is " in message
    assert machine.results[0].remaining == pytest.approx(way_left, abs=0.01)


@pytest.mark.parametrize(("patience", "longest"), [(0.0, SETTLING), (2.0, 2.0)])
def test_motors_that_stay_near_their_commands_do_not_succeed_either(machine, patience, longest):
    """Nearer than moved_tolerance nobody ever found out."""
    machine.send(machine.home + [0.0, -0.05], patience)
    took = machine.run(5.0, without_power)
    assert took == pytest.approx(0.05 + longest, abs=0.03 + PERIOD)
    val, message = machine.told
    assert val == ErrorCode.CONTROL_FAILED
    assert message == (
        f"the motors were not measured where they were sent for {longest:g} s: motor2 is measured at "
        "0.55 rad, its command is 0.5: 0.05 (rad or rod lengths) away, more than arrived_tolerance 0.02"
    )
    assert machine.results[0].remaining == pytest.approx(0.05)
    assert machine.feedback[-1].remaining == pytest.approx(0.05)
    assert machine.session.follower.goal is None
    assert not machine.session.follower.moving


def test_where_nobody_measures_commands_count(machine):
    machine.send(machine.home + [0.1, -0.1])
    assert machine.run(3.0, without_power, every=0) == pytest.approx(0.1, abs=1.5 * PERIOD)
    assert machine.told == (ErrorCode.SUCCESS, "")


def test_motors_that_are_measured_no_more_are_nobody_knows_where(machine):
    machine.session.take_measured(machine.home, machine.bench.now)
    machine.send(machine.home + [0.6, -0.6])
    machine.run(3.0, without_power, every=0)
    val, message = machine.told
    assert val == ErrorCode.CONTROL_FAILED
    assert "more than measured_timeout 0.5 s" in message
    assert math.isnan(machine.results[0].remaining)


@pytest.mark.parametrize("tolerance", [0.0, 0.05])
def test_motors_that_a_load_holds_off_their_commands_want_a_larger_tolerance(
    bare_node, monkeypatch, tolerance
):
    machine = Machine(bare_node, monkeypatch, arrived_tolerance=tolerance)
    machine.send(machine.home + [0.2, -0.2])
    machine.run(3.0, lambda motors, commands: commands + 0.04)
    assert machine.told == (ErrorCode.SUCCESS, "")


def test_a_goal_that_a_pause_ends_was_not_missed_by_the_motors(machine):
    machine.send(machine.home + [0.4, -0.4])
    machine.run(0.2, without_power)
    machine.session.orders.pause(True)
    machine.run(0.1, without_power)
    assert machine.told == (ErrorCode.PREEMPTED, "the node was paused")
