# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The state machine of setpoint following."""

import re
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.branches import stable_elsewhere
from helpers.drive import PERIOD, SETTINGS, THRESHOLDS, Drive, changed_robot, robot
from helpers.geared_robots import geared
from helpers.shipped_steps import STEPS

from cpr_core import Equilibrium, load_robot, solve_forward, solve_home, solve_inverse
from cpr_core.model.assessment import Assessment, Threshold
from cpr_core.solving.deadline import Deadline
from cpr_ros.following import borne_loads, judged_steps, pose_steps, steps
from cpr_ros.following.external_wrench import ExternalWrench
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.supervision import Action, State, Status


def to(drive, *pose):
    drive.follow(PoseGoal(drive.robot, pose))


def steps_of(drive):
    motors = np.array([outcome.assessment.equilibrium.motors for outcome in drive.outcomes])
    return np.abs(np.diff(motors, axis=0))


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


@pytest.mark.parametrize("modes", [5, 12])
def test_straight_through_an_instability_it_slows_halts_before_and_returns(modes):
    """The crossing of the continuous rods with motors locked lies at y = 0.03571."""
    rfrfr = Drive(load_robot("rfrfr", modes))
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    to(rfrfr, 0.0, -0.2)
    halted = rfrfr.until_state(State.HALTED)
    assert halted.verdict.status == Status.HALT_FOR_STABILITY
    assert (halted.verdict.action, halted.verdict.speed_scale) == (Action.HALT, 0.0)
    assert 0.0357 < rfrfr.position[1] < 0.06
    assert THRESHOLDS["margin"].stop <= rfrfr.current.margin < 1.02 * THRESHOLDS["margin"].stop
    assert all(outcome.assessment.index == 0 for outcome in rfrfr.outcomes)
    statuses = [outcome.verdict.status for outcome in rfrfr.outcomes]
    assert statuses.index(Status.DECELERATE_FOR_STABILITY) < statuses.index(
        Status.HALT_FOR_STABILITY
    )
    # What is compared is told apart, by the names of the message and the parameters.
    words = re.fullmatch(
        r"the next margin, (\S+), is below margin_stop 0.05; here it is (\S+)",
        halted.verdict.text,
    )
    assert float(words[1]) < 0.05 < float(words[2])
    # It stays there however long it is pushed ...
    at_halt = rfrfr.current
    for _ in range(100):
        assert rfrfr.tick().state == State.HALTED
    assert rfrfr.current is at_halt
    # ... and is not trapped.
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    np.testing.assert_allclose(rfrfr.position[:2], [0.0, 0.8], atol=1e-9)
    assert rfrfr.outcomes[-1].verdict.action == Action.NONE


def test_speed_falls_with_the_margin_on_the_way_in_and_not_on_the_way_out(rfrfr):
    def fastest(outcomes):
        """Largest motor step by speed scale before it, where the margin warns."""
        pairs = []
        for before, after in pairwise(outcomes):
            step = np.abs(
                after.assessment.equilibrium.motors - before.assessment.equilibrium.motors
            ).max()
            level = THRESHOLDS["margin"].level(before.assessment.margin)
            if 0.1 < level < 0.9:
                pairs.append((step / PERIOD, level))
        return np.array(pairs)

    to(rfrfr, 0.0, -0.2)
    rfrfr.until_state(State.HALTED)
    inward = fastest(rfrfr.outcomes)
    assert len(inward) > 10
    assert np.all(inward[:, 0] <= inward[:, 1] * (1.0 + 1e-6))
    rfrfr.outcomes.clear()
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    outward = fastest(rfrfr.outcomes)
    assert np.median(outward[:, 0]) > 0.8


def test_a_setpoint_stream_into_the_instability_does_not_get_through(rfrfr):
    """New setpoints at every tick must not start the search for the way anew."""
    for _ in range(2500):
        to(rfrfr, 0.0, -0.2)
        rfrfr.tick()
    assert rfrfr.outcomes[-1].state == State.HALTED
    assert all(outcome.assessment.index == 0 for outcome in rfrfr.outcomes)
    assert rfrfr.current.margin >= THRESHOLDS["margin"].stop


def test_motors_straight_through_an_instability_are_halted_as_well(rfrfr):
    rfrfr.follow(MotorGoal(rfrfr.robot, rfrfr.motors + [4.0, -4.0]))
    halted = rfrfr.until_state(State.HALTED)
    assert halted.verdict.status == Status.HALT_FOR_STABILITY
    assert rfrfr.current.margin >= THRESHOLDS["margin"].stop


def test_what_is_below_the_stop_threshold_already_may_get_better_and_not_worse(rfrfr):
    """Thresholds raised at run time leave the robot free to come back."""
    to(rfrfr, 0.0, 0.15)
    rfrfr.until_state(State.IDLE)
    thresholds = THRESHOLDS | {"margin": Threshold(0.9, 0.8)}
    rfrfr.follower.settings = replace(SETTINGS, thresholds=thresholds)
    margin = rfrfr.current.margin
    assert margin < 0.8
    to(rfrfr, 0.0, 0.1)
    rfrfr.until_state(State.HALTED)
    assert rfrfr.current.margin == margin
    to(rfrfr, 0.0, 0.8)
    rfrfr.until_state(State.IDLE)
    assert rfrfr.current.margin > 0.9


def test_it_halts_before_an_inverse_singularity_on_a_platform_way_only():
    """Stretched out, the motors cannot lift the point any more."""
    thresholds = THRESHOLDS | {"inverse_singularity": Threshold(0.03, 0.015)}
    drive = Drive(robot("rfrfr"), thresholds=thresholds)
    to(drive, 0.0, 1.1)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.HALT_FOR_SINGULARITY
    assert 0.015 <= drive.current.inverse_singularity < 0.016
    assert 0.9 < drive.position[1] < 0.98
    statuses = {outcome.verdict.status for outcome in drive.outcomes}
    assert Status.DECELERATE_FOR_APPROACHING_SINGULARITY in statuses
    # Motors know no inverse problem.
    drive.follow(MotorGoal(drive.robot, drive.motors + [-0.1, 0.1]))
    drive.until_state(State.IDLE)
    assert drive.current.inverse_singularity < 0.015
    drive.outcomes.clear()
    to(drive, 0.0, 0.8)
    drive.until_state(State.IDLE)
    statuses = {outcome.verdict.status for outcome in drive.outcomes}
    assert Status.DECELERATE_FOR_LEAVING_SINGULARITY in statuses


@pytest.mark.parametrize("far", [1e6, 1e100, 1e200, 1e300])
def test_a_pose_beyond_all_robots_halts(rfrfr, far):
    """The square of its distance was infinite: it was followed for ever, by steps of nothing."""
    to(rfrfr, far, 0.7)
    outcome = rfrfr.until_state(State.HALTED)
    assert outcome.verdict.action == Action.HALT


def test_it_stops_at_the_range_of_a_motor(rfrfr):
    def limit(content):
        for leg in content["legs"]:
            leg["motor"]["limits"] = {"position": [-0.5, 2.8]}

    drive = Drive(changed_robot("rfrfr", limit))
    drive.follow(MotorGoal(drive.robot, [3.5, 0.55]))
    drive.until_state(State.IDLE)
    assert drive.motors[0] == 2.8
    assert drive.outcomes[-1].verdict.status == Status.JOINT_BOUND
    # The other motor is not held up by it, and the way back is free.
    drive.follow(MotorGoal(drive.robot, [3.5, 0.60]))
    drive.until_state(State.IDLE)
    np.testing.assert_array_equal(drive.motors, [2.8, 0.60])
    drive.follow(MotorGoal(drive.robot, [2.59, 0.60]))
    drive.until_state(State.IDLE)
    assert drive.outcomes[-1].verdict.status == Status.NO_WARNING
    # A platform way that would need more is halted.
    to(drive, 0.0, 0.7)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.JOINT_BOUND
    assert drive.motors[0] <= 2.8


def test_it_halts_before_the_effort_of_a_motor_is_reached():
    def limit(content):
        for leg in content["legs"]:
            leg["motor"]["limits"] = {"effort": 1.0}

    drive = Drive(changed_robot("rfrfr", limit))
    to(drive, 0.0, 0.3)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.JOINT_BOUND
    assert 0.9 < np.abs(drive.current.equilibrium.efforts).max() <= 0.98 + 1e-9


def test_it_halts_before_a_rod_yields():
    def limit(content):
        content["rod"]["yield_strain"] = 0.006

    drive = Drive(changed_robot("rfrfr", limit))
    to(drive, 0.0, 0.3)
    halted = drive.until_state(State.HALTED)
    assert halted.verdict.status == Status.STRAIN_BOUND
    assert drive.current.strain_reserve == pytest.approx(
        THRESHOLDS["strain_reserve"].stop, abs=0.01
    )


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


def test_a_solver_that_fails_holds_the_robot_and_it_goes_on_when_it_works_again(rfrfr):
    class Failing(MotorGoal):
        broken = True

        def solve(self, start: Equilibrium, fraction, loads, time_limit=None):
            if self.broken:
                raise ZeroDivisionError("forced")
            return super().solve(start, fraction, loads, time_limit)

    goal = Failing(rfrfr.robot, rfrfr.motors + 0.05)
    rfrfr.follow(goal)
    halted = rfrfr.until_state(State.HALTED, ticks=20)
    assert halted.verdict.status == Status.NOT_CONVERGED
    assert "ZeroDivisionError: forced" in halted.verdict.text
    assert rfrfr.current.equilibrium is solve_home(rfrfr.robot)
    goal.broken = False
    rfrfr.until_state(State.IDLE)
    np.testing.assert_array_equal(rfrfr.motors, goal.motors)


def test_measures_that_cannot_be_had_hold_the_robot(rfrfr, monkeypatch):
    rfrfr.tick()

    def fail(_equilibrium):
        raise np.linalg.LinAlgError("forced")

    monkeypatch.setattr("cpr_core.model.assessment.kinemato_statics", fail)
    rfrfr.follow(MotorGoal(rfrfr.robot, rfrfr.motors + 0.05))
    halted = rfrfr.until_state(State.HALTED, ticks=20)
    assert halted.verdict.status == Status.NOT_CONVERGED
    assert "LinAlgError: forced" in halted.verdict.text
    assert rfrfr.current.equilibrium is solve_home(rfrfr.robot)


def test_a_solver_that_jumps_is_not_believed(rfrfr):
    elsewhere = Drive(rfrfr.robot)
    to(elsewhere, 0.0, 0.3)
    elsewhere.until_state(State.IDLE)

    class Jumping(MotorGoal):
        def solve(self, start, fraction, loads, time_limit=None):
            return elsewhere.current.equilibrium

    rfrfr.follow(Jumping(rfrfr.robot, rfrfr.motors + 0.05))
    halted = rfrfr.until_state(State.HALTED, ticks=20)
    assert halted.verdict.status == Status.BRANCH_JUMP
    assert rfrfr.current.equilibrium is solve_home(rfrfr.robot)


def test_the_platform_is_held_against_a_wrench(six_rfs):
    wrench = ExternalWrench(six_rfs.robot, timeout=0.0)
    pose = [*(six_rfs.position + [0, 0, -0.01]), *six_rfs.current.equilibrium.platform_quaternion]
    to(six_rfs, *pose)
    six_rfs.until_state(State.IDLE)
    motors = six_rfs.motors
    wrench.take(six_rfs.loads.with_(wrench_world=[0, 0, 0, 0.1, 0, -0.2]), six_rfs.now)
    six_rfs.loads = wrench.loads(six_rfs.loads, six_rfs.now)
    six_rfs.until_state(State.FOLLOWING)
    six_rfs.until_state(State.IDLE)
    np.testing.assert_allclose(six_rfs.position, pose[:3], atol=1e-9)
    assert np.abs(six_rfs.motors - motors).max() > 1e-3


class Solves:
    """How often `attempt` is asked, and how long it is allowed to take instead of as it is."""

    def __init__(self, monkeypatch, module, time_limit=None):
        self.count, self._attempt, self.time_limit = 0, module.attempt, time_limit
        monkeypatch.setattr(module, "attempt", self)

    def __call__(self, current, goal, fraction, loads, time_limit=steps.LONGEST_SOLVE):
        self.count += 1
        limit = time_limit if self.time_limit is None else self.time_limit
        return self._attempt(current, goal, fraction, loads, limit)


def test_a_wrench_that_is_not_borne_is_tried_again_only_where_something_is_new(rfrfr, monkeypatch):
    """Every tick tried, and took so long that nothing else was heard."""
    solves = Solves(monkeypatch, borne_loads, time_limit=1e3)  # however busy the computer
    rfrfr.loads = rfrfr.loads.with_(wrench_world=[0, 0, 0, 0, -10.0, 0])
    told = [rfrfr.tick().verdict.text for _ in range(20)]
    assert solves.count == 1
    assert set(told) == {told[0]}
    assert told[0].startswith("the external wrench is not borne: ")
    rfrfr.loads = rfrfr.loads.with_(wrench_world=[0, 0, 0, 0, -11.0, 0])
    rfrfr.tick()
    assert solves.count == 2
    rfrfr.loads = rfrfr.loads.with_(wrench_world=[0, 0, 0, 0, -0.1, 0])
    assert rfrfr.tick().verdict.action == Action.NONE
    assert rfrfr.current.equilibrium.loads is rfrfr.loads


def test_a_wrench_that_takes_long_to_be_followed_is_followed_from_tick_to_tick(monkeypatch):
    drive, whole = Drive(robot("six_rfs")), Drive(robot("six_rfs"))
    wrench = drive.loads.with_(wrench_world=[0, 0, 0, 0.4, 0, -1.0])
    drive.loads = whole.loads = wrench
    whole.tick()
    solved = []

    def over(deadline):
        """There is time for one step of a walk."""
        solved.append(deadline)
        return solved.count(deadline) > 1

    monkeypatch.setattr(Deadline, "over", property(over))
    home = drive.current
    while drive.current is home:
        assert len(drive.outcomes) < 100
        outcome = drive.tick()
        if drive.current is home:
            assert outcome.verdict.action == Action.HALT
            assert "not borne yet: no equilibrium is found within 0.1 s" in outcome.verdict.text
    assert len(drive.outcomes) > 2
    assert outcome.verdict.action == whole.outcomes[-1].verdict.action
    one, other = drive.current.equilibrium, whole.current.equilibrium
    assert one.loads is wrench
    np.testing.assert_allclose(one.state, other.state, rtol=0.0, atol=1e-9)


def test_a_step_for_which_there_is_no_time_is_not_taken(rfrfr, monkeypatch):
    for module in (judged_steps, pose_steps):
        Solves(monkeypatch, module, time_limit=0.0)
    to(rfrfr, *(rfrfr.position[:2] + [0.02, 0.0]))
    halted = rfrfr.until_state(State.HALTED, ticks=20)
    assert halted.verdict.text == "no equilibrium is found within 0 s"
    assert rfrfr.current.equilibrium is solve_home(rfrfr.robot)


@pytest.mark.parametrize("problem", ["pose", "motors"])
def test_a_halted_robot_asks_again_only_where_something_is_new(rfrfr, monkeypatch, problem):
    """What is refused took up to 60 ms, of every tick of 5 ms."""
    there = (0.0, -0.2) if problem == "pose" else (-4.0, 4.0)

    def ask():
        rfrfr.follow({"pose": PoseGoal, "motors": MotorGoal}[problem](rfrfr.robot, there))

    modules = (judged_steps, pose_steps)
    solves = [Solves(monkeypatch, module, time_limit=1e3) for module in modules]

    def solved():
        return sum(each.count for each in solves)

    ask()
    halted = rfrfr.until_state(State.HALTED)
    for _ in range(200):  # towards the threshold, in steps that become shorter
        rfrfr.tick()
    told, before = rfrfr.outcomes[-1], solved()
    assert before > 0
    for _ in range(100):
        ask()  # the same, as whoever sends setpoints does it
        outcome = rfrfr.tick()
        assert (outcome.state, outcome.verdict.text) == (State.HALTED, told.verdict.text)
        assert not outcome.moved
    assert solved() == before
    assert halted.verdict.status == told.verdict.status

    rfrfr.follower.settings = replace(SETTINGS)  # as good as new ones
    rfrfr.tick()
    assert solved() > before


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


def test_a_solver_without_time_is_asked_again_but_not_all_the_time(rfrfr, monkeypatch):
    def late(*_arguments, **_options):
        asked.append(rfrfr.now)
        time.sleep(0.01)
        return steps.Undecided("not_converged", "no equilibrium is found within 0.1 s")

    asked = []
    monkeypatch.setattr(judged_steps, "attempt", late)
    rfrfr.follow(MotorGoal(rfrfr.robot, rfrfr.motors + 0.05))
    rfrfr.until_state(State.HALTED, ticks=20)
    first = len(asked)
    for _ in range(2000):
        rfrfr.tick()
    gaps = np.diff(asked[first - 1 :])
    assert len(gaps) > 2
    assert gaps.min() >= 0.1
    monkeypatch.undo()
    rfrfr.until_state(State.IDLE)
    np.testing.assert_allclose(rfrfr.motors, solve_home(rfrfr.robot).motors + 0.05)


def test_a_wrench_for_which_there_was_no_time_is_tried_again(rfrfr, monkeypatch):
    """A busy computer takes time away; so does a solver that fails."""
    solves = Solves(monkeypatch, borne_loads, time_limit=0.0)
    rfrfr.loads = rfrfr.loads.with_(wrench_world=[0, 0, 0, 0, -0.1, 0])
    for _ in range(3):
        told = rfrfr.tick().verdict
        assert told.action == Action.HALT
        assert told.text.startswith("the external wrench is not borne yet: no equilibrium is found")
    assert solves.count == 3
    solves.time_limit = None
    assert rfrfr.tick().verdict.action == Action.NONE
    assert rfrfr.current.equilibrium.loads is rfrfr.loads


@pytest.mark.parametrize("caution", [0.5, 1.0])
@pytest.mark.parametrize("ask", [to, lambda drive, *way: drive.follow(MotorGoal(drive.robot, way))])
def test_what_is_not_seen_is_moved_slowly(rfrfr, ask, caution):
    """A supervisor was told of half the speed, and the robot went at its full one."""
    rfrfr.follower.caution = caution
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


def test_a_wrench_that_is_not_borne_halts_and_changes_nothing(rfrfr):
    rfrfr.tick()
    rfrfr.loads = rfrfr.loads.with_(wrench_world=[0, 0, 0, 0, -1000.0, 0])
    outcome = rfrfr.tick()
    assert outcome.verdict.action == Action.HALT
    assert outcome.verdict.text.startswith("the external wrench is not borne: no equilibrium")
    assert "could be" not in outcome.verdict.text
    assert rfrfr.current.equilibrium is solve_home(rfrfr.robot)
    rfrfr.loads = solve_home(rfrfr.robot).loads
    assert rfrfr.tick().verdict.status == Status.NO_WARNING


def test_a_robot_that_may_have_snapped_is_halted_long_enough_to_be_told(monkeypatch):
    """No message was made in a single tick; and without a tick more it would be halted for ever."""
    drive = Drive(robot("gough_stewart"))
    pose = solve_home(drive.robot).pose + [0.0664, 0, 0, 0, 0, 0, 0]
    start = solve_inverse(drive.robot, pose, start=solve_home(drive.robot))
    Solves(monkeypatch, borne_loads, time_limit=1e3)  # however busy the computer
    drive.current = Assessment(start)
    for force in ([-0.75, 1.3, 0.4], [-1.6, -1.45, -0.5]):
        drive.loads = start.loads.with_(wrench_world=[0, 0, 0, *force])
        assert drive.tick().refusal is None
    drive.loads = start.loads.with_(wrench_world=np.zeros(6))
    for _ in range(round(0.3 / PERIOD) - 1):
        told = drive.tick().verdict
        assert (told.status, told.action) == (Status.BRANCH_JUMP, Action.HALT)
        assert not drive.follower.at_rest
    np.testing.assert_allclose(drive.position, start.platform_position, rtol=0.0, atol=1e-12)
    outcome = drive.until(lambda outcome: outcome.refusal is None, ticks=3)
    assert outcome.verdict.status == Status.HALT_FOR_STABILITY  # which the margin is there
    assert drive.follower.at_rest
