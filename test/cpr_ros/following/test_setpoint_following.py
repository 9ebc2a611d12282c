# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Setpoints are followed straight and at the speed there is, until reached, stale, paused or reset."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.branches import stable_elsewhere
from helpers.drive import PERIOD, SETTINGS, Drive, robot, steps_of, to
from helpers.geared_robots import geared
from helpers.shipped_steps import STEPS

from cpr_core import solve_forward, solve_home
from cpr_core.model.assessment import Assessment
from cpr_ros.following.external_wrench import ExternalWrench
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.supervision import State, Status


def test_idle_stays_at_home(rfrfr):
    for _ in range(5):
        outcome = rfrfr.tick()
        assert not outcome.moved
        assert (outcome.state, outcome.verdict.status) == (State.IDLE, Status.NO_WARNING)
    assert rfrfr.current.equilibrium is solve_home(rfrfr.robot)


def test_motors_reach_a_setpoint_at_their_speed(rfrfr):
    rfrfr.follow(MotorGoal(rfrfr.robot, [2.69, 0.50]))
    rfrfr.until_state(State.IDLE)
    np.testing.assert_array_equal(rfrfr.motors, [2.69, 0.50])
    assert steps_of(rfrfr).max() <= PERIOD * (1.0 + 1e-6)
    assert len(rfrfr.outcomes) == pytest.approx(0.1 / PERIOD, abs=2)


@pytest.mark.parametrize("name", ["three_prs", "six_rus", "gough_stewart"])
def test_gears_and_screws_make_a_robot_neither_faster_nor_slower(name):
    """The speed limit is that of what the motor moves; the same ticks, the same places."""
    plain, moved, ratios = geared(name)
    target = solve_forward(plain, solve_home(plain).motors + STEPS[name])
    for goals in (
        [MotorGoal(plain, target.motors), MotorGoal(moved, target.motors / ratios)],
        [PoseGoal(plain, target.pose), PoseGoal(moved, target.pose)],
    ):
        drives = [Drive(plain), Drive(moved)]
        for drive, goal in zip(drives, goals, strict=True):
            drive.follow(goal)
            drive.until_state(State.IDLE)
        ways = [
            [outcome.assessment.equilibrium.motors for outcome in drive.outcomes]
            for drive in drives
        ]
        assert len(ways[0]) == len(ways[1]) > 5
        np.testing.assert_allclose(np.array(ways[1]) * ratios, ways[0], atol=1e-8)


def test_the_newest_setpoint_wins(rfrfr):
    rfrfr.follow(MotorGoal(rfrfr.robot, [3.0, 0.2]))
    for _ in range(5):
        rfrfr.tick()
    rfrfr.follow(MotorGoal(rfrfr.robot, [2.59, 0.60]))
    rfrfr.until_state(State.IDLE)
    np.testing.assert_array_equal(rfrfr.motors, [2.59, 0.60])


def test_the_platform_goes_straight_and_no_motor_beyond_its_speed(six_rfs):
    first = six_rfs.position.copy()
    last = first + [0.03, -0.02, -0.04]
    to(six_rfs, *last, *six_rfs.current.equilibrium.platform_quaternion)
    six_rfs.until_state(State.IDLE)
    np.testing.assert_allclose(six_rfs.position, last, atol=1e-9)
    assert steps_of(six_rfs).max() <= PERIOD * (1.0 + 1e-6)
    along = (last - first) / np.linalg.norm(last - first)
    for outcome in six_rfs.outcomes:
        way = outcome.assessment.equilibrium.platform_position - first
        assert np.linalg.norm(way - (way @ along) * along) < 1e-8
    # The motors are used: it does not take much longer than the slowest of them needs.
    needed = np.abs(six_rfs.motors - solve_home(six_rfs.robot).motors).max() / PERIOD
    assert len(six_rfs.outcomes) < 1.5 * needed + 20


def test_a_stale_setpoint_is_not_followed_further():
    drive = Drive(robot("rfrfr"), setpoint_timeout=0.05)
    to(drive, 0.0, 0.5)
    outcome = drive.until_state(State.STALE)
    assert outcome.verdict.status == Status.STALE_COMMAND
    assert drive.now == pytest.approx(0.055, abs=0.006)
    held = drive.current
    drive.tick()
    assert drive.current is held
    to(drive, 0.0, 0.5)
    assert drive.tick().state == State.FOLLOWING


def test_a_goal_that_does_not_age_is_not_stale():
    drive = Drive(robot("rfrfr"), setpoint_timeout=0.05)
    drive.follower.follow(MotorGoal(drive.robot, drive.motors + 0.2), drive.now, ages=False)
    drive.until_state(State.IDLE)
    assert {outcome.state for outcome in drive.outcomes} == {State.FOLLOWING, State.IDLE}
    drive.follow(MotorGoal(drive.robot, drive.motors - 0.2))
    drive.until_state(State.STALE)


def test_a_reached_setpoint_does_not_become_stale():
    drive = Drive(robot("rfrfr"), setpoint_timeout=0.05)
    drive.follow(MotorGoal(drive.robot, drive.motors + 0.01))
    drive.until_state(State.IDLE)
    for _ in range(50):
        assert drive.tick().state == State.IDLE


def test_a_pose_that_was_reached_in_time_is_held_against_a_wrench_of_later():
    """It was too old by then, and the robot stayed where the wrench had moved it."""
    drive = Drive(robot("rfrfr"), setpoint_timeout=0.5)
    pose = drive.current.equilibrium.pose + [0.005, 0.0]
    drive.follow(PoseGoal(drive.robot, pose))
    drive.until_state(State.IDLE)
    drive.now += 1.0
    drive.loads = drive.loads.with_(wrench_world=[0, 0, 0, 0.05, 0, 0])
    drive.until_state(State.IDLE)
    assert {outcome.state for outcome in drive.outcomes} == {State.FOLLOWING, State.IDLE}
    np.testing.assert_allclose(drive.position[:2], pose, atol=1e-9)


def test_a_pause_holds_and_nothing_moves_by_itself_when_it_ends(rfrfr):
    to(rfrfr, 0.0, 0.5)
    for _ in range(10):
        rfrfr.tick()
    rfrfr.follower.pause(True)
    held = rfrfr.current
    assert held.equilibrium is not solve_home(rfrfr.robot)
    for _ in range(10):
        outcome = rfrfr.tick()
        assert (outcome.state, outcome.moved) == (State.PAUSED, False)
    rfrfr.follower.pause(False)
    assert rfrfr.tick().state == State.IDLE
    assert rfrfr.current is held


def test_a_reset_walks_home_along_the_branch(rfrfr):
    to(rfrfr, 0.1, 0.4)
    rfrfr.until_state(State.IDLE)
    rfrfr.outcomes.clear()
    rfrfr.follower.reset()
    assert rfrfr.tick().state == State.RETURNING
    done = rfrfr.until_state(State.IDLE)
    assert not done.home_missed
    home = solve_home(rfrfr.robot)
    np.testing.assert_array_equal(rfrfr.motors, home.motors)
    np.testing.assert_allclose(rfrfr.position, home.platform_position, atol=1e-9)
    assert steps_of(rfrfr).max() <= PERIOD * (1.0 + 1e-6)


def test_a_reset_that_ends_on_another_branch_is_told_also_after_a_wrench(rfrfr):
    """Loads that are those of the description again are so by their numbers, not as an object."""
    home = solve_home(rfrfr.robot)
    other = stable_elsewhere(rfrfr.robot)
    wrench = ExternalWrench(rfrfr.robot, timeout=0.5)
    pushed = home.loads.with_(wrench_world=[0, 0, 0, 0.1, 0, 0])
    wrench.take(pushed, 0.0)
    released = wrench.loads(pushed, 0.6)
    assert released is not home.loads
    for loads, missed in ((home.loads, True), (released, True), (pushed, False)):
        at_home = solve_forward(rfrfr.robot, home.motors, start=other, loads=loads)
        rfrfr.current, rfrfr.loads = Assessment(at_home), loads
        rfrfr.follower.reset()
        assert rfrfr.until_state(State.IDLE).home_missed == missed


def test_a_reset_gets_the_robot_out_of_a_halt(rfrfr):
    to(rfrfr, 0.0, -0.2)
    rfrfr.until_state(State.HALTED)
    rfrfr.follower.reset()
    rfrfr.until_state(State.IDLE)
    np.testing.assert_array_equal(rfrfr.motors, solve_home(rfrfr.robot).motors)


def test_one_that_became_stale_is_halted_for_its_reason_when_it_comes_again(rfrfr):
    rfrfr.follower.settings = replace(SETTINGS, setpoint_timeout=0.1)
    goal = PoseGoal(rfrfr.robot, (0.0, -0.2))
    while not (rfrfr.outcomes and rfrfr.outcomes[-1].state == State.HALTED):
        rfrfr.follow(goal)
        told = rfrfr.tick().verdict
    for _ in range(200):
        rfrfr.follow(goal)
        told = rfrfr.tick().verdict
    rfrfr.until_state(State.STALE)
    rfrfr.follow(goal)
    again = rfrfr.tick()
    assert (again.state, again.verdict.text) == (State.HALTED, told.text)


@pytest.mark.parametrize("caution", [0.5, 1.0])
@pytest.mark.parametrize("ask", [to, lambda drive, *way: drive.follow(MotorGoal(drive.robot, way))])
def test_what_is_not_seen_is_moved_slowly(rfrfr, ask, caution):
    """A supervisor was told of half the speed, and the robot went at its full one."""
    rfrfr.follower.pace.caution = caution
    way = [0.0, 0.75] if ask is to else rfrfr.motors + [0.2, 0.1]
    ask(rfrfr, *way)
    before, speeds = rfrfr.motors, []
    aim = rfrfr.follower.aim(rfrfr.current, rfrfr.now)
    if aim is not None:
        assert np.abs(aim - before).max() <= caution * PERIOD * (1.0 + 1e-6)
    for _ in range(10):
        rfrfr.tick()
        speeds.append(np.abs(rfrfr.motors - before).max() / PERIOD)
        before = rfrfr.motors
    assert max(speeds) == pytest.approx(caution * SETTINGS.max_speed, rel=0.15)
    assert max(speeds) <= caution * SETTINGS.max_speed * (1.0 + 1e-6)
