# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories that cannot be followed: refused before their first step, with the reason."""

import math
import re
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD, SETTINGS, THRESHOLDS, robot, unstable_robot
from helpers.followed_trajectories import DOWN, WATCHED, Follower, in_long_strides
from helpers.pendulum import pendulum
from hypothesis import example, given, settings
from hypothesis import strategies as st
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from cpr_core import InvalidRequest, NonFiniteInput, solve_forward, trace_through
from cpr_core.kernels.limit_kernel import ROUNDING
from cpr_core.model.assessment import Assessment, Threshold
from cpr_ros.following import trajectory_plan
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.measured_range import BESIDE
from cpr_ros.following.motor_path import MotorPath
from cpr_ros.following.supervision import State
from cpr_ros.following.trajectory_order import TrajectoryRefused
from cpr_ros.following.trajectory_plan import TrajectoryPlan
from cpr_ros.messages.trajectory_messages import trajectory_order

DEGREES = "looks like degrees, expected radians"


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
    [(1.5000001, r"1\.5000001"), (1.5 + 1.001 * ROUNDING, r"1\.500000001")],
)
def test_motors_a_little_beyond_their_ranges_are_told_from_them(given, told):
    made = robot("planar_body")
    point = JointTrajectoryPoint(positions=[0.5, 0.5, given], time_from_start=Duration(sec=1))
    message = JointTrajectory(joint_names=list(made.motor_names), points=[point])
    words = rf"motor3 within \[-1\.5, 1\.5\] rad, got {told}\Z"
    with pytest.raises(TrajectoryRefused, match=words):
        trajectory_order(made, message, Time())


def test_a_trajectory_may_begin_where_a_pose_has_left_a_motor():
    """Poses are solved with motors beyond their ranges by the accuracy of a solution, and published."""
    made = robot("three_prs")
    points = [[0.2, 0.25 + 0.9 * ROUNDING * made.motor_units[1], 0.2], [0.2, 0.25, 0.21]]
    message = JointTrajectory(joint_names=list(made.motor_names))
    for second, positions in enumerate(points):
        time = Duration(sec=second)
        message.points.append(JointTrajectoryPoint(positions=positions, time_from_start=time))
    order = trajectory_order(made, message, Time())
    np.testing.assert_array_equal(order.positions, [[0.2, 0.25, 0.2], points[1]])


def begun_beyond(part, *seconds):
    """A trajectory whose first point has a motor beyond its range by a part of what encoders may see."""
    made = robot("three_prs")
    message = JointTrajectory(joint_names=list(made.motor_names))
    at = [0.2, 0.25 + part * BESIDE * made.motor_units[1], 0.2]
    for second, positions in zip(seconds, (at, [0.2, 0.24, 0.21]), strict=True):
        time = Duration(sec=second)
        message.points.append(JointTrajectoryPoint(positions=positions, time_from_start=time))
    return made, message


def test_a_trajectory_may_begin_where_encoders_see_a_motor_at_its_end():
    """Who begins where the robot is measured says nothing else: no motor is sent there."""
    order = trajectory_order(*begun_beyond(0.9, 0, 1), Time())
    np.testing.assert_array_equal(order.positions, [[0.2, 0.25, 0.2], [0.2, 0.24, 0.21]])


@pytest.mark.parametrize(("part", "seconds"), [(1.1, (0, 1)), (0.9, (1, 2))])
def test_motors_are_sent_nowhere_beyond_their_range(part, seconds):
    with pytest.raises(TrajectoryRefused, match=r"points\[0\]\.positions: expected motor2 within"):
        trajectory_order(*begun_beyond(part, *seconds), Time())


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (([1.0], [[145.8, 30.9]]), "at no more than 1 rad/s, .*"),
        (([0.0, 1.0], [[145.8, 30.9], [145.8, 30.9]]), "begins where .* its command is 2.59"),
    ],
)
def test_what_looks_like_degrees_is_said_of_what_is_refused_for_something_else(
    rfrfr, points, words
):
    with pytest.raises(TrajectoryRefused, match=rf"{words}; motor1 at 148\.39 {DEGREES}\Z"):
        rfrfr.take(*points)


def test_what_looks_like_degrees_is_said_of_a_way_that_is_slow_enough(rfrfr):
    ending = rfrfr.until_ended(rfrfr.take([300.0], [[145.8, 0.0]])[1])
    assert ending.val == ErrorCode.INVALID_MOTION_PLAN
    assert re.search(rf"below margin_stop 0\.05; motor1 at 148\.39 {DEGREES}\Z", ending.message)


def test_what_looks_like_degrees_is_said_of_points_beyond_a_range():
    made = robot("planar_body")
    point = JointTrajectoryPoint(positions=[30.0, 0.5, 0.5], time_from_start=Duration(sec=1))
    message = JointTrajectory(joint_names=list(made.motor_names), points=[point])
    words = rf"motor1 within \[-1\.5, 1\.5\] rad, got 30; motor1 at 30 {DEGREES}\Z"
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
    path = motion.joining.plan.path
    before, after = (
        solve_forward(rfrfr.robot, path.at(time).positions).margin
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


def test_no_trajectory_begins_at_an_unstable_home():
    saddle = Follower(unstable_robot())
    motors = saddle.current.equilibrium.motors.copy()
    _, endings = saddle.take([1.0], [[0.0, 0.05]])  # the margin of there, negative, gets better
    ending = saddle.until_ended(endings)  # not at once where somebody else has the processor
    assert (ending.val, ending.measure) == (ErrorCode.INVALID_MOTION_PLAN, "margin")
    assert "unstable with the motors held" in ending.message
    np.testing.assert_array_equal(saddle.current.equilibrium.motors, motors)
