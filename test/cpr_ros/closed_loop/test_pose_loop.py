# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Platform setpoints met in the measured pose of a robot that is not as described."""

import types

import numpy as np
import pytest
from helpers.closed_loop import PERIOD, SLACK, TARGET, ClosedLoop, live
from helpers.drive import robot
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cpr_ros.closed_loop.loop_status import Loop
from cpr_ros.closed_loop.pose_loop import PoseLoop
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.motor_commands import MotorCommands
from cpr_ros.following.supervision import State


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
    bench.next_picture = bench.now
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
@example(  # a platform that goes three times as far as the model's
    gain=100.0,
    every=1,
    delay=0,
    told=True,
    response=3.0,
    limit=0.3,
    rate=10.0,
    offsets=[0.02] * 6,
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
