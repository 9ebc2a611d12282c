# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured poses that are old, jump, hang or are none: the correction freezes, and it is told why."""

from itertools import cycle

import numpy as np
import pytest
from helpers.closed_loop import SLACK, TARGET, ClosedLoop, frozen, live

from cpr_ros.closed_loop.loop_status import Loop
from cpr_ros.operation.live_changes import apply_live


def test_a_measurement_that_ends_freezes_the_correction(bench):
    bench.seen = lambda pose: None
    bench.run(0.6)
    frozen(bench, 1.0, "old, more than measured_pose_timeout 0.5 s")
    assert bench.status.age == pytest.approx(1.6, abs=0.05)
    bench.seen = lambda pose: pose
    bench.run(3.0)
    assert bench.error(TARGET) < 1e-6


@pytest.mark.parametrize("problem", ["", "pose: a NaN"])
def test_poses_that_were_measured_before_an_activation_are_forgotten(bench, problem):
    """A setpoint was FROZEN, and the robot SLOW, for want of a camera that nobody had meanwhile."""
    if problem:
        bench.session.loop.refuse(problem, bench.now)
    bench.seen = lambda pose: None
    bench.session.stand()
    bench.now += 10.0
    bench.follow(TARGET + [0.01, 0.01])
    bench.run(1.0)
    assert (bench.status.loop, bench.status.age, bench.status.blind) == (Loop.OPEN, -1.0, False)
    bench.seen = lambda pose: pose + 0.2  # another camera: nothing has jumped
    bench.run(0.1)
    assert "loop_max_correction" in bench.status.text
    bench.seen = lambda pose: pose
    bench.session.stand()
    bench.follow(TARGET)
    bench.run(3.0)
    assert bench.status.loop == Loop.CLOSED
    assert bench.error(TARGET) < 1e-6


def test_what_is_too_old_or_too_far_away_is_told_apart_from_its_limit(bench):
    """A pose was said to be 0.5 s old, more than 0.5 s."""
    bench.every = 0.0
    loop, age = bench.session.loop, bench.status.age
    told = loop.status(bench.session.follower.goal, bench.now + 0.50001 - age).text
    assert told == "the measured pose is 0.50001 s old, more than measured_pose_timeout 0.5 s"
    loop.forget_poses()
    bench.run(1.0)
    away = loop.coordinates.moved(bench.model.pose, np.array([0.100001, 0.0]))
    loop.take(away, bench.now)
    assert "measured 0.100001 rod lengths or rad from where" in bench.status.text
    assert bench.status.text.endswith("more than loop_max_correction 0.1")


def test_a_jump_freezes_until_measurements_agree_for_a_while(bench):
    for way in (0.1, 0.2, 0.0):  # the last time it is back, after so long that nobody knows
        bench.seen = lambda pose, way=way: pose + [way, 0.0]
        bench.run(0.14)
        frozen(bench, 0.8, "jumped by 0.")
    assert "3 times in the last 10 s" in bench.status.text
    bench.run(3.5)
    assert bench.error(TARGET) < 1e-6


def test_measurements_that_come_back_soon_are_believed_at_once(bench):
    bench.seen = lambda pose: pose + [0.1, 0.0]
    bench.run(0.14)
    frozen(bench, 0.6, "jumped by 0.1")
    bench.seen = lambda pose: pose
    bench.run(0.02)
    assert bench.status.loop == Loop.CLOSED
    bench.run(3.0)
    assert bench.error(TARGET) < 1e-6


def outliers(every, way=0.1, in_a_row=1):
    """Wrong pictures, again and again."""
    count = iter(range(10**9))
    return lambda pose: pose + (way if next(count) % every < in_a_row else 0.0)


@pytest.mark.parametrize(("every", "in_a_row"), [(40, 1), (40, 5), (5, 1), (2, 1)])
def test_outliers_again_and_again_are_left_aside_and_told(bench, every, in_a_row):
    """One every 0.8 s froze the correction for ever."""
    bench.seen = outliers(every, in_a_row=in_a_row)
    bench.follow(TARGET + [0.02, 0.01])
    told = set()
    for _ in range(250):
        bench.tick()
        status = bench.status
        told.add((status.loop, status.blind, bool(status.text)))
        if "on its way" not in status.text:
            assert status.loop == Loop.CLOSED
            assert status.position_error < 0.02  # nobody is told of what is left aside
    assert bench.error(TARGET + [0.02, 0.01]) < 1e-6
    assert "left aside: the measured pose jumped" in bench.status.text
    assert "times in the last 10 s, the last time by 0.141 rod lengths" in bench.status.text
    assert not any(blind for _, blind, _ in told)
    bench.seen = lambda pose: pose
    bench.run(11.0)
    assert (bench.status.loop, bench.status.text) == (Loop.CLOSED, "")
    assert bench.longest_step <= SLACK


def in_turn(*cameras):
    """Several cameras, one picture each."""
    turns = cycle(cameras)
    return lambda pose: next(turns)(pose)


@pytest.mark.parametrize("way", [0.03, 0.06, 0.2])
def test_a_camera_that_hangs_beside_another_one_freezes_the_correction(bench, way):
    """Its numbers were believed in turn: the robot was led away by the largest correction there is."""
    bench.run(3.0)
    hung, bench.several = bench.real.equilibrium.pose.copy(), True
    bench.seen = in_turn(lambda pose: pose, lambda pose: hung)
    bench.follow(TARGET + [way, 0.0])
    bench.run(2.0)
    frozen(bench, 5.0, "in two places in turn, " if way > 0.05 else "the same again and again, ")
    assert bench.error(TARGET + [way, 0.0]) < 0.05
    bench.seen = lambda pose: pose
    bench.run(5.0)
    assert bench.status.loop == Loop.CLOSED
    assert bench.error(TARGET + [way, 0.0]) < 1e-6


def test_two_cameras_that_contradict_each_other_freeze_the_correction(bench):
    """The one that came first was believed, right or wrong, and a goal reached by it."""
    bench.several = True
    bench.seen = in_turn(lambda pose: pose + 0.05, lambda pose: pose, lambda pose: pose)
    bench.run(1.0)
    frozen(bench, 3.0, "in two places in turn, 0.071 rod lengths or rad apart, by several who")


def test_several_cameras_that_agree_may_mistake_a_picture_now_and_then(bench):
    noise, bench.several = np.random.default_rng(0), True
    bench.seen = in_turn(
        *[lambda pose: pose, lambda pose: pose + noise.normal(0.0, 1e-7, 2)] * 20,
        lambda pose: pose + noise.normal(0.0, 0.3, 2),
    )
    bench.follow(TARGET + [0.02, 0.01])
    for _ in range(250):
        bench.tick()
        assert bench.status.loop == Loop.CLOSED or "on its way" in bench.status.text
    assert bench.error(TARGET + [0.02, 0.01]) < 1e-6


def test_an_outlier_is_not_followed(bench):
    bench.run(3.0)
    pictures = iter([lambda pose: pose + 0.1])
    bench.seen = lambda pose: next(pictures, lambda same: same)(pose)
    before = bench.session.loop.correction
    for _ in range(50):
        bench.tick()
        assert bench.status.loop == Loop.CLOSED
        np.testing.assert_allclose(bench.session.loop.correction, before, atol=1e-8)
    assert bench.error(TARGET) < 1e-6


def test_nothing_is_corrected_while_the_pose_jumps(bench):
    """In the middle of a correction, also before it is told to be frozen."""
    bench.run(1.0)
    apply_live(bench.session, live(loop_max_rate=0.002), bench.now)
    bench.seen = lambda pose: pose + [0.004, 0.0]
    loop = bench.session.loop
    for _ in range(4):
        bench.tick()
        before = loop.correction
    bench.tick()
    assert np.abs(loop.correction - before).max() > 1e-6
    bench.seen = lambda pose: pose + 0.1
    bench.tick()
    held = loop.correction
    for _ in range(20):
        bench.tick()
        np.testing.assert_array_equal(loop.correction, held)
    assert bench.status.loop == Loop.FROZEN
    bench.seen = lambda pose: pose
    bench.run(6.0)
    assert np.abs(loop.correction - held).max() > 1e-6
    assert bench.error(TARGET) < 1e-6


def test_outliers_of_a_slow_camera_freeze_and_are_told_by_how_many_they_are(bench):
    """Where a pose of before is too old to tell which one is wrong."""
    bench.every, bench.next_picture = 0.6, bench.now
    apply_live(bench.session, live(measured_pose_timeout=2.0), bench.now)
    bench.follow(TARGET)
    bench.run(2.4)
    bench.seen = outliers(4, in_a_row=2)
    bench.run(6.0)
    assert bench.status.loop == Loop.FROZEN
    assert "times in the last 10 s, the platform moved by" in bench.status.text


def test_a_robot_far_from_its_model_is_not_corrected():
    bench = ClosedLoop("rfrfr")
    bench.seen = lambda pose: 1e3 * pose  # millimetres
    bench.follow(TARGET)
    bench.run(1.0)
    frozen(bench, 1.0, "more than loop_max_correction 0.1")
    np.testing.assert_array_equal(bench.session.loop.correction, 0.0)


def test_a_measurement_that_does_not_change_is_none(bench):
    """A camera that hangs, and says so by nothing; the correction is not wound up."""
    hung = bench.real.equilibrium.pose.copy()
    bench.seen = lambda pose: hung
    bench.follow(TARGET + [0.02, 0.0])
    bench.run(1.0)
    frozen(bench, 1.0, "does not change")
    bench.seen = lambda pose: pose
    bench.run(4.0)
    assert bench.error(TARGET + [0.02, 0.0]) < 1e-6


def test_what_is_no_pose_freezes_until_the_next_one(bench):
    bench.seen = lambda pose: bench.session.loop.refuse("pose: a NaN", bench.now)
    bench.run(0.1)
    frozen(bench, 0.3, "pose: a NaN")
    bench.seen = lambda pose: pose
    bench.run(0.1)
    assert bench.status.loop == Loop.CLOSED


def test_what_was_no_pose_is_told_as_old_when_nothing_comes_any_more(bench):
    """The stream spoke of a NaN for ever, of a camera that was switched off after it."""
    bench.seen = lambda pose: bench.session.loop.refuse("pose: a NaN", bench.now)
    bench.run(1.0)
    assert bench.status.text == "pose: a NaN"  # however long such messages come
    bench.seen = lambda pose: None
    bench.run(0.4)
    assert bench.status.text == "pose: a NaN"
    bench.run(0.6)
    silent = "no measured pose came for 1 s, more than measured_pose_timeout 0.5 s"
    assert bench.status.text == f"{silent} (the last: pose: a NaN)"
    assert bench.status.blind
    bench.seen = lambda pose: pose
    bench.run(0.1)
    assert bench.status.loop == Loop.CLOSED


def test_a_stamp_of_long_ago_is_old_on_arrival(bench):
    bench.run(0.01)
    bench.session.loop.take(TARGET, bench.now, 3600.0)
    assert "was 3.6e+03 s old when it came" in bench.status.text


def test_a_stamp_ahead_of_the_clock_is_told_and_far_ahead_it_is_not_believed(bench):
    """Cameras whose clock is ahead counted as without delay, without a word."""
    bench.run(0.1)
    loop = bench.session.loop
    loop.take(TARGET, bench.now, -0.005)  # as clocks that are kept together may differ
    assert (bench.status.loop, bench.status.text) == (Loop.CLOSED, "")
    loop.take(TARGET, bench.now, -0.3)
    assert bench.status.loop == Loop.CLOSED
    assert "was stamped 0.3 s ahead of the clock here" in bench.status.text
    loop.take(TARGET, bench.now, -0.6)
    assert bench.status.loop == Loop.FROZEN
    assert "was stamped 0.6 s ahead of the clock here" in bench.status.text
    loop.take(TARGET, bench.now, 0.0)
    assert (bench.status.loop, bench.status.text) == (Loop.CLOSED, "")
