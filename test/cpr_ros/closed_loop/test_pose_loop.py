# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Platform setpoints met in the measured pose of a robot that is not as described."""

import types

import numpy as np
import pytest
from helpers.closed_loop import PERIOD, ClosedLoop, live
from helpers.drive import robot
from hypothesis import given, settings
from hypothesis import strategies as st

from cpr_ros.closed_loop.pose_loop import Loop, PoseLoop
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.motor_commands import MotorCommands
from cpr_ros.following.supervision import State
from cpr_ros.operation.live_changes import apply_live

TARGET = np.array([0.05, 0.75])
SLACK = 1.0 + 2e-5


@pytest.fixture
def bench():
    """The planar robot, met at its setpoint within some 1e-3."""
    made = ClosedLoop("rfrfr", loop_gain=4.0, loop_max_rate=1.0)
    made.follow(TARGET)
    made.run(1.5)
    assert made.status.loop == Loop.CLOSED
    assert made.error(TARGET) < 2e-3
    return made


@pytest.mark.parametrize("name", ["planar_body", "three_rfs", "six_rfs", "four_rfr"])
def test_the_measured_pose_is_met_exactly(name):
    bench = ClosedLoop(name, loop_gain=5.0)
    bench.every = 0.0
    space, home = bench.session.loop.coordinates, bench.model.pose
    way = 0.02 * np.cos(np.arange(len(space.way(home, home))))
    target = space.moved(home, way)
    bench.follow(target)
    bench.run(0.5)
    off = bench.error(target)
    assert bench.status.loop == Loop.OPEN
    assert np.isnan([bench.status.position_error, bench.status.rotation_error]).all()
    bench.every = 0.02
    bench._next = bench.now
    bench.run(3.5)
    print(f"{name}: open {off:.3g}, closed {bench.error(target):.1e} rod lengths or rad")
    assert off > 2e-3
    assert bench.error(target) < 1e-7
    assert bench.longest_step <= SLACK
    assert bench.status.loop == Loop.CLOSED
    assert np.nanmax([bench.status.position_error, bench.status.rotation_error]) < 1e-7


@pytest.mark.parametrize(
    ("every", "delay", "stamped", "gain"),
    [
        (1.0, 0.0, True, 1.0),
        (1.0, 0.3, False, 1.0),
        (
            0.02,
            0.4,
            True,
            5.0,
        ),  # an integral of wanted minus measured swings up from pi / 2 / 0.4 s on
        (0.02, 0.2, False, 1.0),
    ],
)
def test_slow_fast_and_late_measurements_are_borne(every, delay, stamped, gain):
    bench = ClosedLoop("rfrfr", loop_gain=gain)
    bench.every, bench.delay, bench.stamped = every, delay, stamped
    bench.follow(TARGET)
    errors = []
    for _ in range(9):
        bench.run(1.0)
        errors.append(bench.error(TARGET))
    assert errors[-1] < 5e-4
    assert max(errors) <= 1.02 * errors[0]  # it never swings beyond what it began with
    assert bench.longest_step <= SLACK


@pytest.mark.parametrize("delay", [0.0, 0.1])
@pytest.mark.parametrize("way", [1e-3, 0.2], ids=["one tick", "many ticks"])
def test_only_what_is_measured_since_the_setpoint_is_reached_is_measured_at_it(bench, way, delay):
    """A picture of before told of a goal that was reached in one tick that it was measured."""
    bench.delay = delay
    bench.run(1.0)
    assert bench.status.at_setpoint
    bench.follow(TARGET + [way, 0.0])
    ticks, follower = 0, bench.session.follower
    while not ticks or not follower.arrived(bench.model):
        bench.tick()
        ticks += 1
        assert not bench.status.at_setpoint
    assert (ticks == 1) == (way < 0.01)
    arrived = bench.now
    while not bench.status.at_setpoint:
        bench.tick()
    # The first picture since then is that of the next tick.
    assert bench.now - arrived == pytest.approx(delay + PERIOD, abs=0.5 * PERIOD)


def test_noise_is_not_followed(bench):
    noise, bench.every = np.random.default_rng(1), PERIOD
    bench.seen = lambda pose: pose + noise.normal(0.0, 1e-3, 2)
    bench.run(1.0)
    errors = []
    for _ in range(200):
        bench.tick()
        errors.append(bench.error(TARGET))
    assert np.sqrt(np.mean(np.square(errors))) < 3e-4
    assert bench.status.loop == Loop.CLOSED
    assert bench.longest_step <= SLACK


def frozen(bench, seconds, text):
    """Nothing is corrected for a time, and the stream says why."""
    bench.tick()
    before, motors = bench.session.loop.correction, bench.model.motors
    bench.run(seconds)
    np.testing.assert_array_equal(bench.session.loop.correction, before)
    np.testing.assert_allclose(bench.model.motors, motors, rtol=0.0, atol=1e-8)
    assert bench.status.loop == Loop.FROZEN
    assert text in bench.status.text
    assert bench.status.blind == (not text.startswith("loop_"))
    assert bench.longest_step <= SLACK


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
    bench.every, bench._next = 0.6, bench.now
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


def test_nothing_is_wound_up_on_the_way():
    bench = ClosedLoop("rfrfr", loop_gain=4.0, max_speed=0.05)
    bench.seen = lambda pose: pose + [0.03, 0.0]
    bench.follow(TARGET)
    bench.run(1.0)
    assert bench.status.text == "the robot is on its way"
    np.testing.assert_array_equal(bench.session.loop.correction, 0.0)
    bench.seen = lambda pose: None
    bench.follow(bench.model.pose)
    bench.run(0.2)  # what was measured on the way is not made up for on arrival
    assert bench.status.loop == Loop.CLOSED
    np.testing.assert_array_equal(bench.session.loop.correction, 0.0)
    assert bench.longest_step <= SLACK


def test_it_halts_where_it_halts_without():
    """On the way down through the instability at y = 0.036 m; and it can go back."""
    bench = ClosedLoop(
        "rfrfr",
        payload=[0.0, 0.0, 0.0, 0.1, 0.5, 0.0],  # pulls: it is the model that halts
        loop_gain=4.0,
        loop_max_rate=1.0,
        max_speed=4.0,
    )
    bench.follow([0.0, 0.4])
    bench.run(2.0)
    assert bench.error([0.0, 0.4]) < 1e-4
    bench.follow([0.0, -0.2])
    for _ in range(4000):
        bench.tick()
        if bench.states[-1] == State.HALTED:
            break
    assert bench.states[-1] == State.HALTED
    bench.run(0.1)
    assert 0.05 <= bench.session.solver.current.margin < 0.06
    correction = bench.session.loop.correction
    bench.run(1.0)
    assert (bench.status.loop, bench.status.text) == (Loop.FROZEN, "the robot is halted")
    np.testing.assert_array_equal(bench.session.loop.correction, correction)
    bench.follow([0.0, 0.4])
    bench.run(6.0)
    assert bench.error([0.0, 0.4]) < 1e-4
    assert bench.longest_step <= SLACK


def test_the_correction_stays_for_the_next_setpoint_and_ends_with_a_return(bench):
    bench.run(2.0)
    correction = bench.session.loop.correction
    bench.seen = lambda pose: None
    bench.follow(TARGET + [0.01, 0.01])
    bench.run(1.0)
    np.testing.assert_array_equal(bench.session.loop.correction, correction)
    assert bench.error(TARGET + [0.01, 0.01]) < 5e-3  # 0.04 without
    bench.session.orders.follow(MotorGoal(bench.robot, [2.6, 0.5]), bench.now)
    bench.run(0.5)
    assert bench.status.loop == Loop.OPEN
    np.testing.assert_array_equal(bench.model.motors, [2.6, 0.5])
    bench.session.orders.reset()
    np.testing.assert_array_equal(bench.session.loop.correction, 0.0)


def test_a_gain_of_zero_holds_what_there_is(bench):
    apply_live(bench.session, live(loop_gain=0.0), bench.now)
    frozen(bench, 0.5, "loop_gain is 0")


@pytest.mark.parametrize("seen", [True, False])
def test_a_rate_that_was_zero_sets_nothing_in_motion(bench, seen):
    """What was wound up meanwhile was let go: the motors set off by themselves."""
    apply_live(bench.session, live(loop_gain=4.0, loop_max_rate=0.0), bench.now)
    bench.follow(TARGET + [0.0, 0.01])
    bench.run(1.0)
    frozen(bench, 0.5, "loop_max_rate is 0")
    if not seen:
        bench.every = 0.0
        bench.run(0.3)
    before = bench.session.commands.newest
    assert apply_live(bench.session, live(loop_gain=4.0, loop_max_rate=1.0), bench.now)
    bench.run(0.5)
    np.testing.assert_array_equal(bench.session.commands.newest, before)


def test_a_correction_beyond_a_new_limit_is_forgotten_and_the_robot_holds(bench):
    """It stayed, frozen, above what loop_max_correction allowed."""
    size = bench.session.loop.coordinates.size(bench.session.loop.correction)
    motors = bench.model.motors
    assert apply_live(bench.session, live(loop_max_correction=0.5 * size), bench.now)
    np.testing.assert_array_equal(bench.session.loop.correction, 0.0)
    bench.run(0.5)
    np.testing.assert_array_equal(bench.model.motors, motors)


def test_one_on_its_way_beyond_a_new_limit_goes_no_farther():
    """It went on to where the last picture had wanted it."""
    bench = ClosedLoop("rfrfr", loop_gain=100.0, loop_max_rate=0.02)
    bench.follow([0.05, 0.75])
    bench.run(1.0)
    bench.every, bench._next = 1.0, bench.now
    bench.run(0.1)
    loop = bench.session.loop
    size = loop.coordinates.size(loop.correction)
    limit = 1.05 * size
    changed = live(loop_gain=100.0, loop_max_rate=0.02, loop_max_correction=limit)
    apply_live(bench.session, changed, bench.now)
    for _ in range(12):
        bench.run(0.1)
        assert loop.coordinates.size(loop.correction) <= limit


def test_no_parameter_sets_a_frozen_correction_free(bench):
    apply_live(bench.session, live(loop_gain=0.0), bench.now)
    bench.run(0.5)
    goal, motors = bench.session.follower.goal, bench.model.motors
    assert goal is not None
    assert apply_live(bench.session, live(loop_gain=4.0), bench.now)
    assert bench.session.follower.goal is None
    bench.run(0.5)
    np.testing.assert_array_equal(bench.model.motors, motors)


def test_the_goal_is_that_of_who_sent_it(bench):
    goal = PoseGoal(bench.robot, TARGET)
    bench.session.orders.follow(goal, bench.now)
    bench.run(0.2)
    assert bench.session.follower.goal is goal
    np.testing.assert_array_equal(goal.pose, TARGET)
    assert bench.session.follower.arrived(bench.model)
    assert goal.remaining(bench.model) > 1e-2  # the model is elsewhere, so that the robot is there


@settings(deadline=None, max_examples=15)
@given(
    gain=st.floats(0.0, 100.0),
    every=st.integers(1, 120),
    delay=st.integers(0, 90),
    told=st.booleans(),
    response=st.floats(0.5, 1.8),
    limit=st.floats(0.0, 0.3),
    rate=st.floats(1e-3, 10.0),
    offsets=st.lists(st.floats(-0.2, 0.2), min_size=6, max_size=6),
)
def test_whatever_is_measured_the_correction_keeps_its_limits(
    gain, every, delay, told, response, limit, rate, offsets
):
    """Any gain, rate of measurements, delay (told, or below a picture), and model."""
    if not told:
        delay = min(delay, every - 1)
    given = live(
        loop_gain=gain,
        loop_max_correction=limit,
        loop_max_rate=rate,
        measured_pose_jump=10.0,
        measured_pose_timeout=0.0,
    )
    arm = robot("six_rfs")
    loop = PoseLoop(arm, PERIOD, given.loop)
    space = loop.coordinates
    goal = PoseGoal(arm, space.nowhere)
    offset, poses, first, before = np.array(offsets), [], None, loop.correction
    for tick in range(600):
        now = tick * PERIOD
        loop.advance(now)
        model = loop.corrected(goal).pose
        # Where the model is at its goal this is all of an equilibrium that the loop looks at.
        loop.note(types.SimpleNamespace(pose=model), goal, State.IDLE, True, now)
        moved = space.way(space.nowhere, model)
        poses.append(space.moved(space.nowhere, offset + response * moved))
        if tick % every == 0 and tick >= delay:
            loop.take(poses[tick - delay], now, told * delay * PERIOD)
        step = space.size(
            space.way(
                space.moved(space.nowhere, before), space.moved(space.nowhere, loop.correction)
            )
        )
        assert step <= rate * PERIOD * (1.0 + 1e-6) + 1e-12
        assert space.size(loop.correction) <= limit * (1.0 + 1e-9)
        before = loop.correction
        error = space.size(space.way(poses[-1], goal.pose))
        first = error if first is None else first
        assert error <= 2.0 * first + 1e-9


def test_commands_of_a_corrected_robot_are_a_tick_apart():
    """The guard of the commands is behind the loop: the model alone could jump."""
    commands = MotorCommands(robot("rfrfr"), PERIOD)
    commands.place(np.array([2.59, 0.55]))
    assert (
        np.abs(commands.step_to(np.array([3.0, 0.0]), 1.0) - [2.59, 0.55]).max() <= PERIOD * SLACK
    )
