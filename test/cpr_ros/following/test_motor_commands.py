# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motor commands: none is farther from the one before, or from measured motors, than it may be."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cpr_core import load_robot, solve_home
from cpr_ros.following.motor_commands import MotorCommands
from cpr_ros.following.motor_ways import motor_steps

ROBOT, PERIOD, SPEED = load_robot("gough_stewart"), 0.005, 1.5
STEPS = motor_steps(ROBOT, SPEED, PERIOD)
anywhere = arrays(float, 6, elements=st.floats(-1e3, 1e3))


@settings(max_examples=200, deadline=None)
@given(st.lists(anywhere, min_size=2, max_size=30))
def test_no_step_is_longer_than_a_tick_allows(wanted):
    commands = MotorCommands(ROBOT, PERIOD)
    commands.place(wanted[0])
    last = wanted[0]
    for motors in wanted[1:]:
        command = commands.step_to(motors, SPEED)
        assert np.all(np.abs(command - last) <= STEPS * (1.0 + 2e-5))
        # Straight: every motor the same part of its way.
        way = motors - last
        np.testing.assert_allclose(
            (command - last) * np.abs(way).max(), way * np.abs(command - last).max(), atol=1e-9
        )
        last = command


def test_the_end_is_met_exactly_and_then_nothing_is_new():
    commands = MotorCommands(ROBOT, PERIOD)
    home = solve_home(ROBOT).motors
    commands.place(home)
    target, count = home + 10.5 * STEPS, 0
    while not commands.aligned_with(target):
        commands.step_to(target, SPEED)
        count += 1
    assert count == 11
    np.testing.assert_array_equal(commands.newest, target)


def test_where_nothing_is_known_commands_begin_anywhere():
    commands = MotorCommands(ROBOT, PERIOD)
    assert commands.aligned_with(np.zeros(6))
    np.testing.assert_array_equal(commands.step_to(np.ones(6), SPEED), np.ones(6))
    np.testing.assert_allclose(commands.step_to(np.zeros(6), SPEED), np.ones(6) - STEPS.min())


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(1e-3, 2.0 * SPEED), min_size=2, max_size=6))
def test_another_speed_holds_from_the_next_step_on(speeds):
    """Slower or faster, up to the motors' own: it is a parameter that changes while the robot moves."""
    commands = MotorCommands(ROBOT, PERIOD)
    commands.place(np.zeros(6))
    for speed in speeds:
        before = commands.newest
        step = commands.step_to(np.full(6, 1e3), speed) - before
        np.testing.assert_allclose(step, motor_steps(ROBOT, speed, PERIOD), rtol=1e-9)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.tuples(anywhere, anywhere), min_size=2, max_size=30),
    st.sampled_from([1e-9, PERIOD, 0.05, 0.2]),
)
def test_no_command_is_farther_from_measured_motors_than_they_may_be_behind(course, max_lead):
    """Whatever is asked for and measured; motors that are farther already get no farther."""
    commands = MotorCommands(ROBOT, PERIOD, max_lead)
    commands.place(course[0][0])
    lead = STEPS * max(1.0, max_lead / PERIOD)
    for scale, (target, place) in enumerate(course):
        last = commands.newest
        measured = last + place * 10.0 ** (-scale % 6 - 3)  # from far off to near
        part = commands.part_in_reach(target, SPEED, measured)
        assert 0.0 <= part <= 1.0
        command = commands.step_to(target, SPEED, measured)
        if command is None:
            np.testing.assert_array_equal(commands.newest, last)
            assert part * np.abs((target - last) / STEPS).max() < 2e-5
            continue
        assert np.all(np.abs(command - last) <= STEPS * (1.0 + 2e-5))
        before, after = np.abs(last - measured), np.abs(command - measured)
        assert np.all(after <= np.maximum(lead, before) * (1.0 + 2e-5) + 1e-9)
        assert np.any(command != last) or np.array_equal(target, last)


def test_commands_go_as_far_as_there_is_room():
    commands = MotorCommands(ROBOT, PERIOD, 10 * PERIOD)
    commands.place(np.zeros(6))
    for _ in range(30):
        commands.step_to(np.full(6, 1e3), SPEED, np.zeros(6))
    np.testing.assert_allclose(commands.newest, 10 * STEPS, rtol=1e-9)
    assert commands.part_in_reach(np.full(6, 1e3), SPEED, np.zeros(6)) == 0.0
    assert commands.in_reach(np.zeros(6), SPEED)
    assert not commands.in_reach(-0.1 * STEPS, SPEED)
    assert commands.step_to(np.full(6, 1e3), SPEED, np.zeros(6)) is None
    assert commands.waits
    commands.place(10 * STEPS, repeatable=False)
    assert (commands.waits, commands.repeatable) == (False, False)
    one_behind = 10 * STEPS  # but for one motor, that has moved by half a tick's way
    one_behind[3] = 0.5 * STEPS[3]
    further = commands.step_to(np.full(6, 1e3), SPEED, one_behind)
    np.testing.assert_allclose(further - 10 * STEPS, 0.5 * STEPS, rtol=1e-9)  # all wait for it
    back = commands.step_to(np.zeros(6), SPEED, np.zeros(6))
    np.testing.assert_allclose(back, 9.5 * STEPS, rtol=1e-9)  # nearer is always allowed
    assert commands.repeatable


def test_as_far_as_they_may_be_ahead_commands_meet_the_end_exactly():
    for ticks in range(1, 60):
        commands, end = MotorCommands(ROBOT, PERIOD, ticks * PERIOD), 0.3 + ticks * STEPS
        commands.place(np.full(6, 0.3))
        for _ in range(ticks):
            assert not commands.aligned_with(end)
            commands.step_to(end, SPEED, np.full(6, 0.3))
        assert commands.aligned_with(end) and commands.in_reach(np.full(6, 0.3), SPEED)


def test_a_tick_is_always_in_reach():
    commands = MotorCommands(ROBOT, PERIOD, 1e-9)
    commands.place(np.zeros(6))
    for _ in range(3):
        commands.step_to(np.full(6, 1e3), SPEED, np.zeros(6))
    np.testing.assert_allclose(commands.newest, STEPS, rtol=1e-9)


@pytest.mark.parametrize("tolerance", [0.0, 1e-4, 0.1])
@pytest.mark.parametrize(("goes", "ahead"), [(0.0, 1.0), (1.0, 2.0), (1.0, -1.0)])
def test_all_wait_for_a_motor_that_is_measured_beside_its_way(tolerance, goes, ahead):
    """One that stays, or is ahead of its way; where motors may be anywhere, only for one behind."""
    allowed = np.maximum(10.0 * STEPS, tolerance * ROBOT.motor_units)
    for number, part in itertools.product(range(6), (-1.001, -1.00005, 1.00005, 1.001)):
        commands = MotorCommands(ROBOT, PERIOD, 10 * PERIOD, tolerance)
        commands.place(np.zeros(6))
        target, measured = np.full(6, 1e3), np.zeros(6)
        target[number] = np.copysign(1e3 * goes, part)
        measured[number] = ahead * part * allowed[number]
        beside = ahead > 0.0 and tolerance > 0.0 and abs(part) > 1.0005
        waits = beside or ahead < 0.0
        assert (commands.step_to(target, SPEED, measured) is None) == commands.waits == waits
        assert commands.beside == (ROBOT.motor_names[number] if beside else "")
        assert commands.step_to(target, SPEED, np.zeros(6)) is not None
        assert (commands.beside, commands.waits) == ("", False)
