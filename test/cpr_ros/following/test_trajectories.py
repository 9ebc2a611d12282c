# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories: solved ahead, followed in time, replaced, refused and halted."""

import math
import re
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD, SETTINGS, THRESHOLDS, Drive, robot
from helpers.pendulum import pendulum
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from cpr_core import InvalidRequest, NonFiniteInput, solve_forward, trace_through
from cpr_core.model.assessment import MEASURES, Assessment, Threshold
from cpr_ros.following import trajectory_plan
from cpr_ros.following.external_wrench import ExternalWrench
from cpr_ros.following.goals import MotorGoal, motor_steps
from cpr_ros.following.measured_motors import MeasuredMotors
from cpr_ros.following.motor_path import MotorPath
from cpr_ros.following.supervision import State
from cpr_ros.following.trajectory_following import Trajectories
from cpr_ros.following.trajectory_order import TrajectoryOrder, TrajectoryRefused
from cpr_ros.following.trajectory_plan import TrajectoryPlan
from cpr_ros.messages.trajectory_messages import trajectory_order

WATCHED = [name for name in MEASURES if name != "inverse_singularity"]
#: A force on it that it bears where it is, but not on this way [N].
PUSH = -3.0
#: A way of the RFRFR robot straight into its instability.
DOWN = [4.0, -4.0]


class Follower(Drive):
    """A follower with trajectories."""

    def __init__(self, robot, **changed):
        super().__init__(robot, **changed)
        self.measured = MeasuredMotors(0.5)
        self.trajectories = Trajectories(robot, self.follower, PERIOD, self.measured)
        self.endings = []

    def order(self, times, ways, velocities=None, start_in=None, **given):
        """Points by the way of the motors from where they are."""
        free = np.full(self.robot.motor_count, np.inf)
        return TrajectoryOrder(
            np.array(times, float),
            self.motors + np.array(ways, float),
            velocities if velocities is None else np.array(velocities, float),
            given.get("accelerations"),
            start_in,
            given.get("path_tolerance", free),
            given.get("goal_tolerance", free),
            given.get("goal_time_tolerance", np.inf),
        )

    def take(self, *points, **given):
        endings = []
        order = self.order(*points, **given)
        motion = self.trajectories.take(order, self.current, self.now, endings.append)
        return motion, endings

    def begin(self, *points, **given):
        """The same, until it is solved, however long that takes; nothing has moved then."""
        motion, endings = self.take(*points, **given)
        while motion.goal is None:
            assert not endings
            self.tick()
        return motion, endings

    def tick(self, late=0.0):
        self.now += PERIOD + late
        self.trajectories.before_tick(self.current, self.now)
        outcome = self.follower.tick(self.current, self.loads, self.now)
        self.current = outcome.assessment
        self.outcomes.append(outcome)
        self.trajectories.after_tick(outcome, self.now)
        return outcome

    def until_ended(self, endings, ticks=4000):
        for _ in range(ticks):
            if endings:
                return endings[0]
            self.tick()
        raise AssertionError("it did not end")

    @property
    def steps(self):
        motors = [outcome.assessment.equilibrium.motors for outcome in self.outcomes]
        return np.abs(np.diff(motors, axis=0)) / motor_steps(
            self.robot, self.follower.settings.max_speed, PERIOD
        )


@pytest.fixture
def rfrfr():
    return Follower(robot("rfrfr"))


def test_it_is_where_it_should_be_at_every_tick_and_ends_exactly(rfrfr):
    home = rfrfr.motors.copy()
    motion, endings = rfrfr.begin([0.5, 1.0], [[0.1, -0.1], [0.2, 0.1]], np.zeros((2, 2)))
    path = MotorPath.through(
        [0.0, 0.5, 1.0],
        home + np.array([[0, 0], [0.1, -0.1], [0.2, 0.1]]),
        np.zeros((3, 2)),
    )
    begin = rfrfr.now - motion.goal.due(rfrfr.now)
    while not endings:
        rfrfr.tick()
        np.testing.assert_allclose(rfrfr.motors, path.at(rfrfr.now - begin)[0], atol=1e-12)
    assert endings[0].val == ErrorCode.SUCCESS
    assert endings[0].time == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_array_equal(rfrfr.motors, home + [0.2, 0.1])
    assert rfrfr.tick().state == State.IDLE


@pytest.mark.parametrize("older", [0.5, 2.0, 3.5])  # two have ended when it begins
@pytest.mark.parametrize("part", [0.0, 0.3, 0.9])  # of a period since the last tick
def test_one_with_a_stamp_is_in_time_behind_another_whenever_it_comes(rfrfr, part, older):
    rfrfr.begin([older], [[0.05, -0.02]])
    for _ in range(20):
        rfrfr.tick()
    rfrfr.now += part * PERIOD
    motion, endings = rfrfr.take([1.0], [[0.1, 0.1]], start_in=3.0)
    stamp = rfrfr.now + 3.0
    rfrfr.now -= part * PERIOD
    while not endings:
        rfrfr.tick()
        if rfrfr.now > stamp and not endings:
            assert motion.goal.time == pytest.approx(rfrfr.now - stamp, abs=1e-9)
    assert endings[0].val == ErrorCode.SUCCESS


def test_ticks_that_come_late_do_not_make_it_late(rfrfr):
    _, endings = rfrfr.begin([1.0], [[0.5, 0.5]])
    begin = rfrfr.now
    for number in range(1000):
        rfrfr.tick(late=0.4 * PERIOD * (number % 3))
        if endings:
            break
    assert rfrfr.now - begin == pytest.approx(1.0, abs=2.0 * PERIOD)
    assert rfrfr.steps.max() <= 1.0 + 1e-6


def test_at_the_speed_limit_late_ticks_take_a_whole_step(rfrfr):
    _, endings = rfrfr.begin([1.0], [[0.999, 0.0]])
    ticks = 0
    while not endings:
        rfrfr.tick(late=0.8 * PERIOD * (ticks % 2))
        ticks += 1
    assert ticks <= 205
    assert rfrfr.steps.max() <= 1.0 + 1e-6


@pytest.mark.parametrize("field", ["positions", "velocities", "accelerations"])
@pytest.mark.parametrize("motor", [0, 1])
@pytest.mark.parametrize("size", [1e300, 1e307, 1e308])
def test_what_is_beyond_all_numbers_is_too_fast(rfrfr, field, motor, size, recwarn):
    """It was an internal error, with a traceback in the log."""
    rows = {name: np.zeros((2, 2)) for name in ("positions", "velocities", "accelerations")}
    rows[field][:, motor] = [size, -size]
    with pytest.raises(TrajectoryRefused, match=f"expected motor{motor + 1} at no more") as told:
        rfrfr.take([1.0, 2.0], rows.pop("positions"), **rows)
    assert told.value.measure == "speed"
    assert not recwarn.list


def test_one_under_way_that_is_beyond_all_numbers_is_not_near_the_motors(rfrfr):
    rows = [[1e308, 0.0], [-1e308, 0.0], [0.0, 0.0]]
    with pytest.raises(TrajectoryRefused, match="begins where the motors are commanded to"):
        rfrfr.take([0.0, 1.0, 2.0], rows, start_in=-0.5)


def test_a_stall_delays_it_and_skips_nothing(rfrfr):
    _, endings = rfrfr.begin([1.0], [[0.9, 0.9]])
    for _ in range(50):
        rfrfr.tick()
    rfrfr.tick(late=3.0)
    ending = rfrfr.until_ended(endings)
    assert ending.time == pytest.approx(4.0, abs=0.05)
    assert rfrfr.steps.max() <= 1.0 + 1e-6


@pytest.mark.parametrize("ticks", [3, 100])
def test_a_stall_is_made_up_for_by_four_ticks_at_most(rfrfr, ticks):
    _, endings = rfrfr.begin([1.0], [[0.1, 0.1]])
    for _ in range(20):
        rfrfr.tick()
    rfrfr.tick(late=(ticks - 1) * PERIOD)
    behind = rfrfr.until_ended(endings).time - 1.0 - max(0, ticks - 4) * PERIOD
    assert -0.1 * PERIOD < behind < 1.1 * PERIOD  # rounding may ask for a last tick


def test_two_ticks_behind_at_the_end_are_within_every_tolerance(rfrfr):
    """At the speed limit nothing makes up for a tick that was late."""
    _, endings = rfrfr.begin([1.0], [[0.999, 0.0]], goal_time_tolerance=0.0)
    for _ in range(195):
        rfrfr.tick()
    rfrfr.tick(late=1.5 * PERIOD)
    ending = rfrfr.until_ended(endings)
    assert ending.val == ErrorCode.SUCCESS
    assert 1.0 + PERIOD < ending.time < 1.0 + 2.0 * PERIOD


way = st.floats(-0.4, 0.4)


@settings(max_examples=12, deadline=None)
@given(
    arrays(float, (3, 2), elements=way),
    arrays(float, 3, elements=st.floats(0.02, 0.3)),
    st.booleans(),
    st.integers(0, 30),
    st.lists(st.floats(0.0, 3.0), min_size=4, max_size=4),
)
def test_no_command_is_farther_than_the_speed_limit(ways, spans, smooth, replaced_at, late):
    """However the trajectory is, when another one comes and when ticks come."""
    follower = Follower(robot("rfrfr"))
    zeros = np.zeros((3, 2)) if smooth else None
    for _ in range(2):
        try:
            follower.take(np.cumsum(spans), ways, zeros)
        except TrajectoryRefused:
            assert ways.any()
        for number in range(replaced_at):
            follower.tick(late=late[number % 4] * PERIOD)
    follower.tick()
    follower.tick()
    assert follower.steps.max() <= 1.0 + 1e-6


def test_a_newer_one_goes_on_with_the_velocity_of_the_one_before(rfrfr):
    _, first = rfrfr.begin([2.0], [[0.8, -0.8]], np.zeros((1, 2)))
    for _ in range(150):
        rfrfr.tick()
    _, second = rfrfr.take([1.0, 2.0], [[-0.1, 0.1], [0.0, 0.0]], np.zeros((2, 2)))
    rfrfr.until_ended(second)
    assert [first[0].val, second[0].val] == [ErrorCode.PREEMPTED, ErrorCode.SUCCESS]
    motors = np.array([outcome.assessment.equilibrium.motors for outcome in rfrfr.outcomes])
    velocities = np.diff(motors, axis=0) / PERIOD
    # The largest change in a tick of both alone is below this; a stop would be 0.6 at once.
    assert np.abs(np.diff(velocities, axis=0)).max() < 0.05
    assert np.abs(velocities).max() > 0.5


def test_positions_alone_are_joined_without_a_jump_of_velocity_too(rfrfr):
    _, first = rfrfr.begin([2.0], [[0.8, -0.8]])
    for _ in range(100):
        rfrfr.tick()
    before = rfrfr.motors.copy()
    rfrfr.tick()
    velocity = (rfrfr.motors - before) / PERIOD
    _, second = rfrfr.take([0.5], [[0.1, -0.1]])
    while not first:
        rfrfr.tick()
    ticks = [rfrfr.motors.copy()]
    while rfrfr.trajectories.running.goal.time < 0.05:
        rfrfr.tick()
        ticks.append(rfrfr.motors.copy())
    found = np.diff(ticks, axis=0) / PERIOD
    assert np.abs(np.diff(np.vstack([velocity, found]), axis=0)).max() < 0.05
    assert rfrfr.until_ended(second).val == ErrorCode.SUCCESS


def test_one_that_starts_later_waits_and_one_under_way_is_joined(rfrfr):
    home = rfrfr.motors.copy()
    _, endings = rfrfr.take([1.0], [[0.5, 0.0]], start_in=0.5)
    begin = rfrfr.now
    while rfrfr.now - begin < 0.49:
        rfrfr.tick()
    np.testing.assert_array_equal(rfrfr.motors, home)
    rfrfr.until_ended(endings)
    assert rfrfr.now - begin == pytest.approx(1.5, abs=2.0 * PERIOD)
    rfrfr = Follower(robot("rfrfr"))
    begin = rfrfr.now
    _, endings = rfrfr.take([0.0, 1.0], [[0.0, 0.0], [-0.4, 0.0]], start_in=-0.3)
    rfrfr.until_ended(endings)
    assert rfrfr.now - begin == pytest.approx(0.7, abs=2.0 * PERIOD)
    np.testing.assert_allclose(rfrfr.motors, home + [-0.4, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("points", "given", "measure", "words"),
    [
        (([0.0, 1.0], [[0.3, 0.0], [0.3, 0.0]]), {}, "points", "motor1 would be at"),
        (([0.1], [[0.2, 0.0]]), {}, "speed", "motor1 at no more than 1 rad/s"),
        (([1.0], [[0.2, 0.0]]), {"start_in": -1.0}, "header.stamp", "still to come"),
        (([1.0], [[0.9, 0.0]]), {"start_in": -0.5}, "speed", "no more than"),
        (([0.0, 1.0], [[0.0, 0.0], [0.9, 0.0]]), {"start_in": 600.0}, "points", "within 600 s"),
        (([0.0], [[0.0, 0.0]]), {}, "points", "still to come"),
    ],
)
def test_what_cannot_be_followed_is_refused_with_the_reason(rfrfr, points, given, measure, words):
    with pytest.raises(TrajectoryRefused, match=words) as refused:
        rfrfr.take(*points, **given)
    assert refused.value.measure == measure
    assert rfrfr.follower.goal is None


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (
            ([0.3], [[0.3 * (1.0 + 2e-6), 0.0]]),
            r"than 1 rad/s, between 0 and 0\.3 s .* 1\.000002\Z",
        ),
        (([-6.9e-18, 1.0], [[0.3, 0.0], [0.3, 0.0]]), "at 0 s motor1 would be at"),
        (([-6.9e-18], [[0.0, 0.0]]), r"due at 0 s and now it is 0 s since"),
        (([1.0], [[0.2, 0.0]]), r"due at 1 s and now it is 1\.0000001 s since"),
    ],
)
def test_refusals_show_what_is_compared_in_enough_digits(rfrfr, points, words):
    # Under way for 0.925 s already, and joined 0.075 s later.
    start_in = -0.9250001 if points[0] == [1.0] else None
    with pytest.raises(TrajectoryRefused, match=words):
        rfrfr.take(*points, start_in=start_in)


def swung(velocity):
    """A trajectory of the RFRFR whose motor1 ends with a velocity."""
    message = JointTrajectory(joint_names=["motor2", "motor1"])
    for second, speeds in ((1, [0.0, 0.1]), (2, [0.0, velocity])):
        point = JointTrajectoryPoint(positions=[0.5, 2.6], velocities=speeds)
        point.time_from_start.sec = second
        message.points.append(point)
    return message


@pytest.mark.parametrize("velocity", [0.1 * math.sin(math.pi), -0.9e-6, 0.0])
def test_a_velocity_that_rounding_left_at_the_end_is_rest(velocity):
    order = trajectory_order(robot("rfrfr"), swung(velocity), Time())
    np.testing.assert_array_equal(order.velocities, [[0.1, 0.0], [0.0, 0.0]])


@pytest.mark.parametrize("velocity", [1.1e-6, -0.1])
def test_a_motor_that_moves_at_the_end_is_named(velocity):
    words = rf"ends at rest, at its last point motor1 has a velocity of {velocity:g}\Z"
    with pytest.raises(TrajectoryRefused, match=words):
        trajectory_order(robot("rfrfr"), swung(velocity), Time())


@pytest.mark.parametrize(
    ("given", "told"),
    [(1.5000001, r"1\.5000001"), (math.nextafter(1.5, 2.0), r"1\.5000000000000002")],
)
def test_motors_a_little_beyond_their_ranges_are_told_from_them(given, told):
    made = robot("planar_body")
    point = JointTrajectoryPoint(positions=[0.5, 0.5, given], time_from_start=Duration(sec=1))
    message = JointTrajectory(joint_names=list(made.motor_names), points=[point])
    words = rf"motor3 within \[-1\.5, 1\.5\] rad, got {told}\Z"
    with pytest.raises(TrajectoryRefused, match=words):
        trajectory_order(made, message, Time())


def test_an_end_a_little_too_late_is_told_from_the_latest(rfrfr):
    with pytest.raises(TrajectoryRefused, match=r"within 600 s from now, got 600\.0001 s"):
        rfrfr.take([600.0001], [[0.1, 0.0]], start_in=0.0)


def test_times_that_do_not_grow_are_told_apart():
    made = robot("rfrfr")
    points = [
        JointTrajectoryPoint(
            positions=[0.5, 0.5], time_from_start=Duration(sec=1000, nanosec=nanoseconds)
        )
        for nanoseconds in (2, 1)
    ]
    message = JointTrajectory(joint_names=list(made.motor_names), points=points)
    words = r"more than the 1000\.000000002 s of the point before, got 1000\.000000001 s"
    with pytest.raises(TrajectoryRefused, match=words):
        trajectory_order(made, message, Time())


def test_one_into_the_instability_is_refused_before_its_first_step(rfrfr):
    home = rfrfr.motors.copy()
    motion, endings = rfrfr.take([8.0], [DOWN])
    ending = rfrfr.until_ended(endings)
    assert (ending.val, ending.measure) == (ErrorCode.INVALID_MOTION_PLAN, "margin")
    assert "below margin_stop 0.05" in ending.message
    np.testing.assert_array_equal(rfrfr.motors, home)
    # It is right: there the margin is below, a tick before it is not.
    path = motion.plan.path
    before, after = (
        solve_forward(rfrfr.robot, path.at(time)[0]).margin
        for time in (ending.time - 1.001 * PERIOD, ending.time)
    )
    assert after < THRESHOLDS["margin"].stop <= before


def test_what_dips_below_its_threshold_between_two_looks_is_refused(rfrfr):
    """There and a little back in fewer ticks than lie between two looks at the margin."""
    target = rfrfr.motors + [0.2, -0.2]
    margins = [
        solve_forward(rfrfr.robot, rfrfr.motors + part * (target - rfrfr.motors)).margin
        for part in (1.0, 0.95, 0.9)
    ]
    assert margins == sorted(margins)
    for stop, refused in ((margins[1], True), (margins[0] - 1e-3, False)):
        plan = TrajectoryPlan(
            MotorPath.through(
                [0.0, 0.2, 0.22], [rfrfr.motors, target, 0.9 * target + 0.1 * rfrfr.motors]
            ),
            rfrfr.current,
            PERIOD,
            THRESHOLDS | {"margin": Threshold(0.999, stop)},
            WATCHED,
        )
        plan.advance()
        assert plan.done != refused
        assert (plan.refused is not None) == refused


@settings(max_examples=25, deadline=None)
@given(st.floats(-np.pi, np.pi), st.floats(0.3, 3.0), st.floats(0.1, 0.9))
@example(0.0, 2.5, 0.8)  # as near to the instability at its end as at its beginning, nearer between
def test_one_is_refused_if_and_only_if_a_measure_falls_below_its_threshold_in_a_tick(
    middle, angle, part
):
    """On arcs, which come near to the instability and go away again between two looks."""
    rfrfr = Follower(robot("rfrfr"))
    angles = middle + np.linspace(-0.5 * angle, 0.5 * angle, 60)
    arc = 0.25 * np.column_stack([np.cos(angles), np.sin(angles)])
    path = MotorPath.through(np.linspace(0.0, 0.295, 60), rfrfr.motors + arc - arc[0])
    every_tick = trace_through(rfrfr.robot, motors=path.positions(path.breaks[1:]))
    margins = [rfrfr.current.margin] + [found.margin for found in every_tick.equilibria]
    stop = part * min(margins) + (1.0 - part) * max(margins)
    falls = any(after < stop and after < before - 1e-9 for before, after in pairwise(margins))
    thresholds = THRESHOLDS | {"margin": Threshold(1.1, stop)}
    plan = TrajectoryPlan(path, rfrfr.current, PERIOD, thresholds, WATCHED)
    plan.advance()
    assert (plan.refused is not None) == falls


def test_a_motor_that_turns_back_by_noise_only_is_not_looked_at_oftener(rfrfr, monkeypatch):
    """Points of an encoder or an inverse solution: every tick was looked at by itself."""
    in_long_strides(monkeypatch)
    looks, may_fall = [], TrajectoryPlan._may_fall
    monkeypatch.setattr(
        TrajectoryPlan, "_may_fall", lambda *given: looks.append(1) or may_fall(*given)
    )
    noise, counts = np.random.default_rng(0), []
    for size in (0.0, 1e-7):
        looks.clear()
        points = np.column_stack([np.linspace(0.0, 0.2, 201), noise.normal(0.0, 1.0, 201) * size])
        path = MotorPath.through(np.linspace(0.0, 1.0, 201), rfrfr.motors + points - points[0])
        plan = TrajectoryPlan(path, rfrfr.current, PERIOD, THRESHOLDS, WATCHED)
        plan.advance()
        assert plan.done
        counts.append(len(looks))
    assert counts[1] == counts[0]


def test_what_is_not_defined_between_two_looks_is_looked_at_down_to_every_tick(rfrfr):
    plan = TrajectoryPlan(
        MotorPath.rest(0.0, 1.0, rfrfr.motors), rfrfr.current, PERIOD, THRESHOLDS, WATCHED
    )
    looks = [SimpleNamespace(value=lambda name, size=size: size) for size in (1.0, np.nan, 1.0)]
    assert plan._may_fall("margin", looks)
    assert not plan._may_fall("margin", looks[::2])


def test_a_robot_with_many_modes_is_solved_in_shorter_strides(monkeypatch):
    """Sixty ticks were solved in one, whatever that took, and nothing else was done meanwhile."""
    strides, seconds = [], iter(np.linspace(0.0, 1000.0, 5001))

    def traced(*arguments, motors, **given):
        strides.append(len(motors))
        return trace_through(*arguments, motors=motors, **given)

    rfrfr = Follower(robot("rfrfr"))
    way = MotorPath.through([0.0, 1.0], [rfrfr.motors, rfrfr.motors + [0.2, -0.2]])
    plan = TrajectoryPlan(way, rfrfr.current, PERIOD, THRESHOLDS, WATCHED)
    monkeypatch.setattr(trajectory_plan, "trace_through", traced)
    # Every look at the clock is a fifth of a second later.
    clock = SimpleNamespace(perf_counter=lambda: next(seconds), thread_time=lambda: 0.0)
    monkeypatch.setattr(trajectory_plan, "time", clock)
    plan.advance()
    assert plan.done
    assert strides[:2] == [10, 1]
    assert sum(strides) == plan.ticks == 200


def test_one_along_which_a_measure_is_not_defined_is_refused():
    """What nobody can compare with its threshold may be anything."""
    swinging = Follower(pendulum())
    assert np.isnan(swinging.current.margin)
    _, endings = swinging.take([1.0], [[0.1]])
    ending = swinging.until_ended(endings)
    assert (ending.val, ending.measure) == (ErrorCode.INVALID_MOTION_PLAN, "margin")
    np.testing.assert_array_equal(swinging.motors, [0.0])


def test_a_refused_one_changes_nothing_for_the_one_that_runs(rfrfr):
    _, first = rfrfr.begin([3.0], [[0.3, 0.3]])
    for _ in range(20):
        rfrfr.tick()
    _, second = rfrfr.take([8.0], [DOWN])
    assert rfrfr.until_ended(second).val == ErrorCode.INVALID_MOTION_PLAN
    assert rfrfr.until_ended(first).val == ErrorCode.SUCCESS


def test_what_gets_better_is_not_refused(rfrfr):
    rfrfr.follow(MotorGoal(rfrfr.robot, rfrfr.motors + [1.0, -1.0]))
    rfrfr.until_state(State.IDLE)
    margin = rfrfr.current.margin
    thresholds = THRESHOLDS | {"margin": Threshold(0.99, margin + 0.01)}
    rfrfr.follower.settings = replace(SETTINGS, thresholds=thresholds)
    with_margin = TrajectoryPlan(
        MotorPath.through([0.0, 2.0], [rfrfr.motors, rfrfr.motors + [-0.5, 0.5]]),
        rfrfr.current,
        PERIOD,
        thresholds,
        WATCHED,
    )
    with_margin.advance()
    assert with_margin.done
    worse = TrajectoryPlan(
        MotorPath.through([0.0, 2.0], [rfrfr.motors, rfrfr.motors + [0.5, -0.5]]),
        rfrfr.current,
        PERIOD,
        thresholds,
        WATCHED,
    )
    worse.advance()
    assert worse.refused.measure == "margin"


def test_a_wrench_on_the_way_halts_it_and_the_robot_holds():
    rfrfr = Follower(robot("rfrfr"), thresholds=THRESHOLDS | {"margin": Threshold(0.41, 0.4)})
    _, endings = rfrfr.begin([2.5], [[2.0, -2.0]])
    for _ in range(100):
        rfrfr.tick()
    wrench = ExternalWrench(rfrfr.robot, 0.0)
    push = [0.0, 0.0, 0.0, 0.0, PUSH, 0.0]
    wrench.take(rfrfr.loads.with_(wrench_world=push), rfrfr.now)
    rfrfr.loads = wrench.loads(rfrfr.loads, rfrfr.now)
    ending = rfrfr.until_ended(endings)
    assert ending.val == ErrorCode.CONTROL_FAILED
    assert ending.measure == "margin"
    assert 0.5 <= ending.time < 2.5
    assert rfrfr.current.index == 0
    held = rfrfr.motors.copy()
    for _ in range(20):
        rfrfr.tick()
    np.testing.assert_array_equal(rfrfr.motors, held)


@pytest.mark.parametrize("wanted", [True, False])
def test_it_ends_where_measured_motors_arrive_if_that_is_asked_for(rfrfr, wanted):
    """Motors a tenth of a second behind their commands."""
    given = {"goal_tolerance": np.full(2, 1e-3)} if wanted else {}
    _, endings = rfrfr.begin([1.0], [[0.2, -0.2]], **given)
    while not endings:
        sent = [outcome.assessment.equilibrium.motors for outcome in rfrfr.outcomes[-20:]]
        rfrfr.measured.take(sent[0] if sent else rfrfr.motors, rfrfr.now)
        rfrfr.tick()
    (ending,) = endings
    assert ending.val == ErrorCode.SUCCESS
    assert (ending.time >= 1.0 + 10 * PERIOD) == wanted


@pytest.mark.parametrize("tolerance", ["path_tolerance", "goal_tolerance"])
def test_a_measured_motor_that_stands_still_ends_it(rfrfr, tolerance):
    stuck = rfrfr.motors.copy()
    _, endings = rfrfr.begin([1.0], [[0.2, -0.2]], **{tolerance: np.full(2, 0.05)})
    while not endings:
        rfrfr.measured.take(stuck, rfrfr.now)
        rfrfr.tick()
    (ending,) = endings
    assert (ending.val, ending.measure) == (ErrorCode.CONTROL_FAILED, tolerance)
    assert "motor1 is measured" in ending.message
    assert ending.time < 1.0 if tolerance == "path_tolerance" else ending.time > 1.5
    held = rfrfr.motors.copy()
    rfrfr.tick()
    np.testing.assert_array_equal(rfrfr.motors, held)


@pytest.mark.parametrize("tolerance", ["path_tolerance", "goal_tolerance", None])
def test_motors_that_are_measured_no_more_end_it_where_a_tolerance_is_about_them(rfrfr, tolerance):
    """It succeeded with encoders that were dead."""
    given = {tolerance: np.full(2, 0.05)} if tolerance else {}
    _, endings = rfrfr.begin([1.0], [[0.2, -0.2]], **given)
    rfrfr.measured.take(rfrfr.motors, rfrfr.now)
    ending = rfrfr.until_ended(endings)
    if tolerance is None:
        assert ending.val == ErrorCode.SUCCESS
        return
    assert (ending.val, ending.measure) == (ErrorCode.CONTROL_FAILED, tolerance)
    assert "more than measured_timeout 0.5 s" in ending.message
    assert ending.time < 0.6 if tolerance == "path_tolerance" else ending.time > 1.5


def test_a_warning_makes_it_slower_on_the_same_path_and_tolerances_forbid_that(rfrfr):
    thresholds = THRESHOLDS | {"margin": Threshold(0.999, 0.01)}
    slow = Follower(rfrfr.robot, thresholds=thresholds)
    _, endings = slow.take([1.0], [[0.4, -0.4]])
    ending = slow.until_ended(endings)
    assert ending.val == ErrorCode.SUCCESS
    assert ending.time > 1.02
    for outcome in slow.outcomes:
        ways = outcome.assessment.equilibrium.motors - rfrfr.motors
        np.testing.assert_allclose(ways[0], -ways[1], atol=1e-12)
    for tolerance, measure in (
        ({"path_tolerance": np.array([1e-3, np.inf])}, "path_tolerance"),
        ({"goal_time_tolerance": 0.011}, "goal_time_tolerance"),
    ):
        slow = Follower(rfrfr.robot, thresholds=thresholds)
        _, endings = slow.take([1.0], [[0.4, -0.4]], **tolerance)
        ending = slow.until_ended(endings)
        assert (ending.val, ending.measure) == (ErrorCode.CONTROL_FAILED, measure)
        if measure == "goal_time_tolerance":
            told = re.search(
                r"is (\S+) from the end (\S+) s after .* is (\S+), .* are (\S+) s", ending.message
            )
            away, late, tolerance, allowed = map(float, told.groups())
            assert away > tolerance == 0.0 and late > allowed == 0.011
        held = slow.motors.copy()
        slow.tick()
        np.testing.assert_array_equal(slow.motors, held)


def test_cancelled_it_holds_from_the_next_tick_on(rfrfr):
    motion, endings = rfrfr.begin([2.0], [[0.8, -0.8]])
    for _ in range(50):
        rfrfr.tick()
    held = rfrfr.motors.copy()
    rfrfr.trajectories.cancel(motion)
    rfrfr.tick()
    np.testing.assert_array_equal(rfrfr.motors, held)
    assert (endings[0].val, endings[0].time) == (ErrorCode.PREEMPTED, motion.goal.time)
    assert 0.2 < motion.goal.time <= 0.26


def test_its_end_is_told_whatever_fails_meanwhile(rfrfr, monkeypatch):
    """Its action waited for a result for ever, and whoever cancelled it too."""
    motion, endings = rfrfr.begin([2.0], [[0.8, -0.8]])
    rfrfr.tick()

    def fails(*_):
        raise ArithmeticError("forced by a test")

    monkeypatch.setattr(rfrfr.follower, "drop", fails)
    with pytest.raises(ArithmeticError):
        rfrfr.trajectories.cancel(motion)
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]


@pytest.mark.parametrize("start_in", [None, 0.6])
@pytest.mark.parametrize("ended_by", ["cancelled", "tolerance"])
def test_when_the_older_one_ends_early_the_newer_one_goes_on_from_where_that_holds(
    rfrfr, monkeypatch, start_in, ended_by
):
    """It ended too, and said that a setpoint, a pause or a return had come."""
    motion, older = rfrfr.begin([2.0], [[0.8, -0.8]], path_tolerance=np.full(2, 0.1))
    for _ in range(50):
        rfrfr.tick()
    end, begin = rfrfr.motors + [0.05, -0.05], rfrfr.now
    solved_slowly(monkeypatch, every=10)
    _, newer = rfrfr.take([1.0], [[0.05, -0.05]], start_in=start_in)
    rfrfr.tick()
    if ended_by == "cancelled":
        rfrfr.trajectories.cancel(motion)
    else:
        motion.order = replace(motion.order, path_tolerance=np.full(2, -1.0))
        rfrfr.tick()
    assert older and not newer
    held = rfrfr.motors.copy()
    rfrfr.tick()
    np.testing.assert_array_equal(rfrfr.motors, held)
    assert rfrfr.until_ended(newer).val == ErrorCode.SUCCESS
    np.testing.assert_allclose(rfrfr.motors, end, atol=1e-12)
    assert rfrfr.steps.max() <= 1.0 + 1e-6
    if start_in is not None:
        assert rfrfr.now - begin == pytest.approx(1.6, abs=2.0 * PERIOD)


def test_a_newer_one_that_cannot_begin_where_the_older_one_ended_says_so(rfrfr, monkeypatch):
    motion, _ = rfrfr.begin([2.0], [[0.8, -0.8]])
    for _ in range(50):
        rfrfr.tick()
    solved_slowly(monkeypatch, every=40)
    _, newer = rfrfr.take([0.1], [[0.09, -0.09]], start_in=0.05)
    for _ in range(4):
        rfrfr.tick()
    rfrfr.trajectories.cancel(motion)
    rfrfr.tick(late=1.0)
    ending = rfrfr.until_ended(newer)
    assert ending.val == ErrorCode.INVALID_MOTION_PLAN
    assert ending.message.startswith("the trajectory it was to go on from has ended: ")


def test_a_setpoint_that_came_before_it_was_cancelled_is_followed(rfrfr):
    """Both came between two ticks, and the setpoint was forgotten with the trajectory."""
    motion, endings = rfrfr.begin([2.0], [[0.8, -0.8]])
    rfrfr.tick()
    newer = MotorGoal(rfrfr.robot, rfrfr.motors + [0.1, -0.1])
    rfrfr.follow(newer)
    rfrfr.trajectories.cancel(motion)
    assert rfrfr.follower.goal is newer
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]
    rfrfr.until_state(State.IDLE)
    np.testing.assert_array_equal(rfrfr.motors, newer.motors)


def test_a_setpoint_replaces_one_that_runs_and_one_that_is_solved(rfrfr):
    _, running = rfrfr.begin([2.0], [[0.2, -0.2]])
    rfrfr.tick()
    _, coming = rfrfr.take([100.0], [[0.2, -0.2]])
    rfrfr.tick()
    assert not running
    assert not coming
    rfrfr.follow(MotorGoal(rfrfr.robot, rfrfr.motors))
    rfrfr.tick()
    assert running[0].val == coming[0].val == ErrorCode.PREEMPTED


def test_a_long_one_is_solved_in_slices_between_ticks(rfrfr):
    motion, endings = rfrfr.take([300.0], [[0.2, -0.2]])
    assert not motion.plan.done
    rfrfr.tick()
    assert not motion.plan.done
    assert rfrfr.tick().state == State.IDLE
    rfrfr.trajectories.cancel(motion)
    assert endings[0].val == ErrorCode.PREEMPTED


def in_long_strides(monkeypatch):
    """Strides of plans depend on the number of ticks only, not on how busy the machine is just then."""
    monkeypatch.setattr(trajectory_plan, "_LONGEST", 1e6)


def solved_slowly(monkeypatch, every):
    """A plan goes on by the least it can, once in so many calls; what the calls were allowed [s]."""
    in_long_strides(monkeypatch)
    allowed, advance = [], TrajectoryPlan.advance

    def slow(plan, seconds=np.inf):
        allowed.append(seconds)
        if len(allowed) % every == 0:
            advance(plan, 0.0)

    monkeypatch.setattr(TrajectoryPlan, "advance", slow)
    return allowed


def test_one_that_is_not_solved_when_it_is_due_is_joined_later(rfrfr, monkeypatch):
    """What was left was solved in one go, for seconds, and nothing else was done meanwhile."""
    allowed, begin = solved_slowly(monkeypatch, every=4), rfrfr.now
    home = rfrfr.motors.copy()
    motion, endings = rfrfr.take([2.0], [[0.2, -0.2]], start_in=0.05)
    first = motion.join
    assert rfrfr.until_ended(endings).val == ErrorCode.SUCCESS
    assert max(allowed[1:]) <= PERIOD  # the first one is that of a robot at rest
    assert motion.join > 1.5 * first
    assert rfrfr.now - begin == pytest.approx(2.05, abs=2.0 * PERIOD)
    np.testing.assert_allclose(rfrfr.motors, home + [0.2, -0.2], atol=1e-12)
    assert rfrfr.steps.max() <= 1.0 + 1e-6


def test_one_that_is_solved_in_the_tick_in_which_it_is_late_is_joined_later_too(rfrfr, monkeypatch):
    """Ticks come late: it was said that the robot had been moved."""
    advance = TrajectoryPlan.advance
    monkeypatch.setattr(TrajectoryPlan, "advance", lambda plan, seconds: None)
    _, endings = rfrfr.take([0.0, 2.0], [[0.0, 0.0], [0.8, -0.8]], start_in=0.02)
    begin = rfrfr.now
    monkeypatch.setattr(TrajectoryPlan, "advance", lambda plan, seconds: advance(plan))
    rfrfr.tick(late=0.3)
    assert not endings
    assert rfrfr.until_ended(endings).val == ErrorCode.SUCCESS
    assert rfrfr.now - begin == pytest.approx(2.02, abs=2.0 * PERIOD)
    assert rfrfr.steps.max() <= 1.0 + 1e-6


def test_one_that_is_not_solved_when_it_is_due_and_cannot_be_joined_is_refused(rfrfr, monkeypatch):
    allowed, home = solved_slowly(monkeypatch, every=40), rfrfr.motors.copy()
    _, endings = rfrfr.take([0.3], [[0.2, 0.0]], start_in=0.02)
    ending = rfrfr.until_ended(endings)
    assert (ending.val, ending.measure) == (ErrorCode.INVALID_MOTION_PLAN, "header.stamp")
    assert ending.message.startswith("it was not solved when it was due: expected a point still")
    assert max(allowed[1:]) <= PERIOD
    np.testing.assert_array_equal(rfrfr.motors, home)


def test_until_a_newer_one_is_solved_the_older_one_goes_on(rfrfr, monkeypatch):
    _, first = rfrfr.begin([2.0], [[0.8, -0.8]], np.zeros((1, 2)))
    for _ in range(50):
        rfrfr.tick()
    allowed = solved_slowly(monkeypatch, every=4)
    motion, second = rfrfr.take([2.0], [[0.1, -0.1]], np.zeros((1, 2)))
    while not first:
        rfrfr.tick()
        assert not second
    assert motion is rfrfr.trajectories.running
    assert rfrfr.until_ended(second).val == ErrorCode.SUCCESS
    assert first[0].val == ErrorCode.PREEMPTED
    assert max(allowed) <= PERIOD
    motors = np.array([outcome.assessment.equilibrium.motors for outcome in rfrfr.outcomes])
    assert np.abs(np.diff(motors, 2, axis=0)).max() / PERIOD < 0.05  # no jump of velocity


def test_judging_what_is_solved_holds_up_no_tick_either(rfrfr):
    """Near a stop threshold ticks between are looked at too, and those of a stride were at once."""
    margins = THRESHOLDS | {"margin": Threshold(0.999, rfrfr.current.margin - 1e-5)}
    way = MotorPath.through([0.0, 0.3], [rfrfr.motors, rfrfr.motors + [-0.2, 0.2]])
    plan = TrajectoryPlan(way, rfrfr.current, PERIOD, margins, WATCHED)
    steps = 0
    while not plan.done:
        plan.advance(0.0)
        steps += 1
    assert plan.refused is None
    assert steps > 3 + 5  # solved, judged and done; and in between


@pytest.mark.parametrize(
    ("measure", "field"),
    [("margin", "margin"), ("forward_singularity", "forward.smallest_singular_value")],
)
def test_a_measure_and_its_stop_are_told_apart_by_their_own_names(rfrfr, measure, field):
    """The margin was said to be 0.05, below its stop threshold 0.05."""
    target = rfrfr.motors + 0.01 * np.array(DOWN)
    last = Assessment(solve_forward(rfrfr.robot, target)).value(measure)
    near = THRESHOLDS | {measure: Threshold(1.0, last + 1e-9)}
    way = MotorPath.through([0.0, 0.1], [rfrfr.motors, target])
    plan = TrajectoryPlan(way, rfrfr.current, PERIOD, near, WATCHED)
    plan.advance()
    words = rf"{re.escape(field)} would be (\S+), below {measure}_stop (\S+)"
    value, stop = map(float, re.fullmatch(words, plan.refused.why).groups())
    assert value < stop


@pytest.mark.parametrize(("in_vain", "measure"), [(3, ""), (100, "time_limit")])
def test_time_that_others_take_from_it_is_no_reason_to_refuse_one(
    rfrfr, monkeypatch, in_vain, measure
):
    limits = iter([0.0] * in_vain)

    def traced(*arguments, time_limit, **given):
        return trace_through(*arguments, time_limit=next(limits, time_limit), **given)

    monkeypatch.setattr(trajectory_plan, "trace_through", traced)
    way = MotorPath.through([0.0, 0.3], [rfrfr.motors, rfrfr.motors + [-0.2, 0.2]])
    plan = TrajectoryPlan(way, rfrfr.current, PERIOD, THRESHOLDS, WATCHED)
    plan.advance()
    assert plan.done == (measure == "")
    assert (plan.refused.measure if plan.refused else "") == measure


def test_one_with_a_stamp_is_in_time_though_the_one_before_has_ended(rfrfr, monkeypatch):
    """Its time stood still from then on until it was solved."""
    _, first = rfrfr.begin([0.3], [[0.1, -0.1]])
    solved_slowly(monkeypatch, every=6)
    begin = rfrfr.now
    _, second = rfrfr.take([1.0], [[0.0, 0.0]], start_in=3.0)
    rfrfr.until_ended(first)
    assert not second
    assert rfrfr.until_ended(second).val == ErrorCode.SUCCESS
    assert rfrfr.now - begin == pytest.approx(4.0, abs=2.0 * PERIOD)


@pytest.mark.parametrize("interruption", ["pause", "setpoint", "return"])
def test_what_came_and_went_between_two_ticks_ends_one_that_is_solved(
    rfrfr, monkeypatch, interruption
):
    """A pause that was released before the next tick left it alive: the robot set off by itself."""
    solved_slowly(monkeypatch, every=20)
    home = rfrfr.motors.copy()
    _, endings = rfrfr.take([1.0], [[0.2, -0.2]])
    rfrfr.tick()
    if interruption == "pause":
        rfrfr.follower.pause(True)
        rfrfr.follower.pause(False)
    elif interruption == "setpoint":
        rfrfr.follow(MotorGoal(rfrfr.robot, home + 0.1))
        rfrfr.follower.drop("cancelled")
    else:
        rfrfr.follower.reset()
        rfrfr.follower.drop("cancelled")
    for _ in range(200):
        rfrfr.tick()
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]
    np.testing.assert_array_equal(rfrfr.motors, home)


@pytest.mark.parametrize("interruption", ["pause", "setpoint"])
def test_one_goes_on_from_nothing_that_was_replaced_since_the_last_tick(rfrfr, interruption):
    """It was planned on from the one that had ended, and the robot set off again along that."""
    _, older = rfrfr.begin([1.0], [[0.5, -0.5]])
    for _ in range(60):
        rfrfr.tick()
    held = rfrfr.motors.copy()
    if interruption == "pause":
        rfrfr.follower.pause(True)
        rfrfr.follower.pause(False)
    else:
        rfrfr.follow(MotorGoal(rfrfr.robot, held))
    _, newer = rfrfr.take([0.0, 1.0], [[0.0, 0.0], [0.0, 0.0]])
    assert [ending.val for ending in older] == [ErrorCode.PREEMPTED]
    while not newer:
        rfrfr.tick()
        np.testing.assert_allclose(rfrfr.motors, held, atol=1e-12)
    assert newer[0].val == ErrorCode.SUCCESS


@pytest.mark.parametrize("allowed", [np.inf, 0.05])
def test_tolerances_count_from_the_stamp_also_where_the_older_one_is_slowed_down(rfrfr, allowed):
    """It began as much later as the older one was, and was said to be on time."""
    settings = rfrfr.follower.settings
    slow = dict(settings.thresholds) | {"margin": Threshold(1.0, 0.9)}
    rfrfr.follower.settings = replace(settings, thresholds=slow)
    rfrfr.begin([4.0], [[0.4, -0.4]])
    for _ in range(100):
        rfrfr.tick()
    given = {"goal_tolerance": np.zeros(2), "goal_time_tolerance": allowed}
    stamp = rfrfr.now + 2.0
    ways = [[0.0, 0.0], [-0.05, 0.05]]
    _, endings = rfrfr.take([1.0, 2.0], ways, start_in=2.0, **given)
    ending = rfrfr.until_ended(endings)
    assert rfrfr.now > stamp + 2.0 + 0.05
    if np.isfinite(allowed):
        assert (ending.val, ending.measure) == (ErrorCode.CONTROL_FAILED, "goal_time_tolerance")
    else:
        assert ending.val == ErrorCode.SUCCESS
        assert ending.time == pytest.approx(rfrfr.now - stamp, abs=1e-9)


def test_until_one_with_a_stamp_begins_the_older_one_goes_on_and_is_watched(rfrfr):
    """It was said to be replaced once the newer one was solved, and was driven to its end."""
    home = rfrfr.motors.copy()
    _, first = rfrfr.begin([1.0], [[0.1, -0.1]])
    begin = rfrfr.now
    _, second = rfrfr.take([1.0], [[0.2, -0.2]], start_in=3.0)
    assert rfrfr.until_ended(first).val == ErrorCode.SUCCESS
    np.testing.assert_allclose(rfrfr.motors, home + [0.1, -0.1], atol=1e-12)
    assert rfrfr.now - begin == pytest.approx(1.0, abs=2.0 * PERIOD)
    assert rfrfr.until_ended(second).val == ErrorCode.SUCCESS
    assert rfrfr.now - begin == pytest.approx(4.0, abs=2.0 * PERIOD)
    assert rfrfr.steps.max() <= 1.0 + 1e-6


def test_one_with_a_stamp_replaces_one_that_is_still_under_way_then(rfrfr):
    older, first = rfrfr.begin([4.0], [[0.4, -0.4]])
    begin = rfrfr.now
    newer, second = rfrfr.take([1.0], [[0.2, -0.2]], start_in=2.0)
    while not first:
        assert rfrfr.trajectories.running is older
        rfrfr.tick()
    assert first[0].val == ErrorCode.PREEMPTED
    assert rfrfr.now - begin == pytest.approx(2.0, abs=5.0 * PERIOD)
    assert rfrfr.trajectories.running is newer
    assert rfrfr.until_ended(second).val == ErrorCode.SUCCESS
    assert rfrfr.now - begin == pytest.approx(3.0, abs=2.0 * PERIOD)
    assert rfrfr.steps.max() <= 1.0 + 1e-6


def test_an_older_one_is_cancelled_while_one_with_a_stamp_waits(rfrfr):
    older, first = rfrfr.begin([4.0], [[0.4, -0.4]])
    begin = rfrfr.now
    _, second = rfrfr.take([1.0], [[0.2, -0.2]], start_in=2.0)
    for _ in range(20):
        rfrfr.tick()
    rfrfr.trajectories.cancel(older)
    held = rfrfr.motors.copy()
    assert first[0].val == ErrorCode.PREEMPTED
    while rfrfr.now - begin < 1.9:
        rfrfr.tick()
    np.testing.assert_array_equal(rfrfr.motors, held)
    assert rfrfr.until_ended(second).val == ErrorCode.SUCCESS
    assert rfrfr.now - begin == pytest.approx(3.0, abs=2.0 * PERIOD)


@pytest.mark.parametrize("stalls", [[0.5], [0.05] * 5])
def test_stalls_do_not_delay_one_that_waits_for_its_stamp(rfrfr, stalls):
    begin = rfrfr.now
    _, endings = rfrfr.begin([1.0], [[0.2, -0.2]], start_in=2.0)
    for late in stalls:
        rfrfr.tick(late)
        rfrfr.tick()
    assert rfrfr.until_ended(endings).val == ErrorCode.SUCCESS
    assert rfrfr.now - begin == pytest.approx(3.0, abs=2.0 * PERIOD)


def test_a_trajectory_does_not_become_stale_between_two_ticks(rfrfr):
    """All of it has come: parameters that changed then ended it as if it were an old setpoint."""
    rfrfr.begin([1.0], [[0.2, -0.2]])
    rfrfr.tick()
    rfrfr.follower.settings = replace(SETTINGS, setpoint_timeout=0.5 * PERIOD)
    assert not rfrfr.follower.stale(rfrfr.now + 0.9 * PERIOD)


@pytest.mark.parametrize(
    ("field", "numbers", "error"),
    [
        ("positions", [2.6, np.nan], NonFiniteInput),
        ("positions", [2.6], InvalidRequest),
        ("positions", [], InvalidRequest),
        ("velocities", [np.inf, 0.0], NonFiniteInput),
        ("velocities", [], InvalidRequest),
        ("accelerations", [1.0, 0.0, 0.0], InvalidRequest),
    ],
)
def test_the_point_whose_numbers_are_wrong_is_named(field, numbers, error):
    """Among others that are right, with which it is read."""
    message = JointTrajectory(joint_names=["motor2", "motor1"])
    for number in range(5):
        zeros = [0.0, 0.0]
        point = JointTrajectoryPoint(positions=[0.5, 2.6], velocities=zeros, accelerations=zeros)
        point.time_from_start.sec = number + 1
        message.points.append(point)
    order = trajectory_order(robot("rfrfr"), message, Time())
    np.testing.assert_array_equal(order.positions, [[2.6, 0.5]] * 5)
    setattr(message.points[3], field, numbers)
    with pytest.raises(error, match=rf"points\[3\].{field}: expected 2 numbers"):
        trajectory_order(robot("rfrfr"), message, Time())
