# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories one after the other: no jump of velocity, whenever the newer one is solved."""

from dataclasses import replace

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from helpers.drive import PERIOD, robot
from helpers.followed_trajectories import DOWN, Follower, solved_slowly

from cpr_core.model.assessment import Threshold
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import State
from cpr_ros.following.trajectory_plan import TrajectoryPlan


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


def test_a_refused_one_changes_nothing_for_the_one_that_runs(rfrfr):
    _, first = rfrfr.begin([3.0], [[0.3, 0.3]])
    for _ in range(20):
        rfrfr.tick()
    _, second = rfrfr.take([8.0], [DOWN])
    assert rfrfr.until_ended(second).val == ErrorCode.INVALID_MOTION_PLAN
    assert rfrfr.until_ended(first).val == ErrorCode.SUCCESS


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
    assert not motion.joining.plan.done
    rfrfr.tick()
    assert not motion.joining.plan.done
    assert rfrfr.tick().state == State.IDLE
    rfrfr.trajectories.cancel(motion)
    assert endings[0].val == ErrorCode.PREEMPTED


def test_one_that_is_not_solved_when_it_is_due_is_joined_later(rfrfr, monkeypatch):
    """What was left was solved in one go, for seconds, and nothing else was done meanwhile."""
    allowed, begin = solved_slowly(monkeypatch, every=4), rfrfr.now
    home = rfrfr.motors.copy()
    motion, endings = rfrfr.take([2.0], [[0.2, -0.2]], start_in=0.05)
    first = motion.joining.join
    assert rfrfr.until_ended(endings).val == ErrorCode.SUCCESS
    assert max(allowed[1:]) <= PERIOD  # the first one is that of a robot at rest
    assert motion.joining.join > 1.5 * first
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
