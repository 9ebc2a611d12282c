# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories: in time, within the speed limit, halted, cancelled, ended where motors arrive."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD, SETTINGS, THRESHOLDS, robot
from helpers.followed_trajectories import PUSH, WATCHED, Follower
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cpr_core.model.assessment import Threshold
from cpr_ros.following.external_wrench import ExternalWrench
from cpr_ros.following.motor_path import MotorPath
from cpr_ros.following.supervision import State
from cpr_ros.following.trajectory_order import TrajectoryRefused
from cpr_ros.following.trajectory_plan import TrajectoryPlan


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
        np.testing.assert_allclose(rfrfr.motors, path.at(rfrfr.now - begin).positions, atol=1e-12)
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


def test_a_trajectory_does_not_become_stale_between_two_ticks(rfrfr):
    """All of it has come: parameters that changed then ended it as if it were an old setpoint."""
    rfrfr.begin([1.0], [[0.2, -0.2]])
    rfrfr.tick()
    rfrfr.follower.settings = replace(SETTINGS, setpoint_timeout=0.5 * PERIOD)
    assert not rfrfr.follower.stale(rfrfr.now + 0.9 * PERIOD)
