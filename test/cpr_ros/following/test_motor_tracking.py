# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Following measured motors."""

import numpy as np
from helpers.drive import SETTINGS, robot

from cpr_core import solve_home
from cpr_core.model.assessment import Assessment
from cpr_ros.following import motor_tracking
from cpr_ros.following.judged_steps import LARGEST_CHANGE
from cpr_ros.following.motor_tracking import LONGEST_WAY, MotorTracking
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.following.steps import attempt, change_between
from cpr_ros.following.supervision import Action, State, Status


class Tracking:
    def __init__(self, name, timeout=0.5, period=0.005):
        self.robot, self.period = robot(name), period
        judge = SetpointFollower(self.robot, period, SETTINGS)
        self.tracker = MotorTracking(self.robot, timeout, judge)
        self.current, self.now = Assessment(solve_home(self.robot)), 0.0

    def tick(self, motors=None):
        self.now += self.period
        if motors is not None:
            self.tracker.take(motors, self.now, tolerance=0.1)
        outcome = self.tracker.tick(self.current, self.current.equilibrium.loads, self.now)
        self.current = outcome.assessment
        return outcome


def test_the_equilibrium_is_at_the_measured_motors():
    tracking = Tracking("six_rfs")
    home = solve_home(tracking.robot).motors
    for k in range(50):
        motors = home + 0.05 * np.sin(0.1 * k + np.arange(6))
        for _ in range(3):
            outcome = tracking.tick(motors)
        assert outcome.state == State.TRACKING
        np.testing.assert_array_equal(tracking.current.equilibrium.motors, motors)


def test_motors_far_from_home_are_walked_to():
    tracking = Tracking("rfrfr")
    motors = solve_home(tracking.robot).motors + [1.0, -1.0]
    ticks = 0
    while np.any(tracking.current.equilibrium.motors != motors):
        before = tracking.current.equilibrium.motors
        tracking.tick(motors)
        step = np.abs(tracking.current.equilibrium.motors - before).max()
        assert step <= LONGEST_WAY * (1.0 + 1e-9)
        ticks += 1
        assert ticks < 20


def test_motors_are_caught_up_with_in_every_tick_however_seldom_ticks_come(monkeypatch):
    """At 5 Hz motors that went 1 rad/s were told to be 0.6 rad behind, TRACKING with NONE."""
    monkeypatch.setattr(
        motor_tracking.time, "perf_counter", lambda: 0.0
    )  # however busy the computer
    tracking = Tracking("rfrfr", timeout=1.0, period=0.2)
    home = solve_home(tracking.robot).motors
    for way in np.arange(0.0, 1.0, 0.2):
        motors = home + [way, -way]
        outcome = tracking.tick(motors)
        assert (outcome.state, outcome.moved) == (State.TRACKING, way > 0.0)
        np.testing.assert_array_equal(outcome.assessment.equilibrium.motors, motors)


def test_what_is_lost_on_a_way_of_several_steps_is_told_in_the_tick(monkeypatch):
    monkeypatch.setattr(
        motor_tracking.time, "perf_counter", lambda: 0.0
    )  # however busy the computer
    tracking = Tracking("rfrfr", timeout=1.0, period=0.5)
    before = tracking.current
    outcome = tracking.tick([2.59 + 4.0, 0.55 - 4.0])
    assert (outcome.state, outcome.verdict.action) == (State.LOST, Action.HALT)
    assert outcome.moved and outcome.assessment is not before and outcome.assessment.index == 0


def test_a_tick_does_not_walk_for_longer_than_streams_can_wait(monkeypatch):
    tracking = Tracking("rfrfr", timeout=1.0, period=0.2)
    monkeypatch.setattr(motor_tracking, "LONGEST_SOLVE", 0.0)
    monkeypatch.setattr(motor_tracking, "attempt", lambda *given: attempt(*given[:4], 1e3))
    home = solve_home(tracking.robot).motors
    outcome = tracking.tick(home + [0.5, -0.5])
    assert outcome.state == State.TRACKING
    way = np.abs(outcome.assessment.equilibrium.motors - home).max()
    np.testing.assert_allclose(way, LONGEST_WAY)


def test_a_margin_that_vanishes_is_told_and_not_refused():
    tracking = Tracking("rfrfr")
    for turn in np.linspace(1.02, 4.16, 200):  # symmetric, down to y = 0.042
        outcome = tracking.tick([0.5 * np.pi + turn, 0.5 * np.pi - turn])
        assert outcome.state == State.TRACKING
    assert tracking.current.margin < 0.05
    assert outcome.verdict.status == Status.HALT_FOR_STABILITY


def test_where_a_robot_is_soft_a_jump_of_the_motors_is_followed_in_smaller_steps():
    tracking = Tracking("rfrfr")
    for turn in np.linspace(1.02, 4.16, 200):
        tracking.tick([0.5 * np.pi + turn, 0.5 * np.pi - turn])
    motors = tracking.current.equilibrium.motors + [-LONGEST_WAY, LONGEST_WAY]
    ticks = 0
    while np.any(tracking.current.equilibrium.motors != motors):
        before = tracking.current.equilibrium
        assert tracking.tick(motors).state == State.TRACKING
        assert change_between(before, tracking.current.equilibrium) <= LARGEST_CHANGE
        ticks += 1
        assert ticks < 20
    assert ticks > 1


def test_motors_no_stable_equilibrium_explains_are_lost_until_they_come_back():
    tracking = Tracking("rfrfr")
    for shift in np.linspace(0.0, 4.0, 200):
        outcome = tracking.tick([2.59 + shift, 0.55 - shift])
    assert outcome.state == State.LOST
    assert outcome.verdict.action == Action.HALT
    assert tracking.current.index == 0
    for shift in np.linspace(4.0, 0.5, 200):
        outcome = tracking.tick([2.59 + shift, 0.55 - shift])
    assert outcome.state == State.TRACKING


def test_measurements_that_stop_coming_are_stale():
    tracking = Tracking("rfrfr", timeout=0.02)
    unknown = tracking.tick()
    assert (unknown.state, unknown.verdict.action) == (State.IDLE, Action.HALT)
    assert "no measured motors" in unknown.verdict.text
    known = tracking.tick([2.6, 0.55])
    assert (known.state, known.verdict.action) == (State.TRACKING, Action.NONE)
    for _ in range(5):
        outcome = tracking.tick()
    assert (outcome.state, outcome.verdict.status) == (State.STALE, Status.STALE_COMMAND)
    assert (outcome.verdict.action, outcome.verdict.speed_scale) == (Action.HALT, 0.0)
    assert "too old" in outcome.verdict.text
    assert tracking.tick([2.6, 0.55]).verdict.action == Action.NONE


def test_a_wrench_that_is_not_borne_is_a_halt():
    tracking = Tracking("rfrfr")
    tracking.tick([2.6, 0.55])
    loads = tracking.current.equilibrium.loads.with_(wrench_world=[0, 0, 0, 0, -1000.0, 0])
    outcome = tracking.tracker.tick(tracking.current, loads, tracking.now)
    assert (outcome.state, outcome.verdict.action) == (State.LOST, Action.HALT)
    assert "could be" not in outcome.verdict.text


def test_a_motor_measured_beyond_its_range_is_named():
    tracking = Tracking("planar_body")
    motors = solve_home(tracking.robot).motors.copy()
    motors[1] = 1.6
    outcome = tracking.tick(motors)
    assert outcome.state == State.LOST
    assert outcome.verdict.status == Status.JOINT_BOUND
    assert tracking.robot.motor_names[1] in outcome.verdict.text


def test_noise_at_a_stop_does_not_lose_a_robot_and_a_place_beyond_it_is_told():
    """155 of 280 ticks were LOST, between others that were not."""
    tracking, random = Tracking("planar_body"), np.random.default_rng(0)
    motors = solve_home(tracking.robot).motors.copy()
    name, stop = tracking.robot.motor_names[1], tracking.robot.description.motors[1].limits.upper
    for place in np.linspace(motors[1], stop, 40):
        motors[1] = place
        tracking.tick(motors)
    for noise in 3e-4 * random.normal(size=(200, 3)):
        assert tracking.tick(motors + noise).state == State.TRACKING
        assert tracking.current.equilibrium.motors[1] <= stop
    motors[1] = stop + 0.01
    outcome = tracking.tick(motors)
    assert outcome.state == State.LOST
    assert f"{name} is measured at {stop + 0.01:.3g} rad, beyond its range" in outcome.verdict.text


def test_motors_that_nothing_explains_are_not_tried_again_while_they_stay(monkeypatch):
    """Every tick tried, and took so long that nothing else was heard."""
    tracking, solves = Tracking("rfrfr"), []

    def counted(*given):
        solves.append(given)
        return attempt(*given[:4], 1e3)  # however busy the computer

    monkeypatch.setattr(motor_tracking, "attempt", counted)
    for shift in np.linspace(0.0, 4.0, 200):
        outcome = tracking.tick([2.59 + shift, 0.55 - shift])
    assert outcome.state == State.LOST
    solves.clear()
    texts = {tracking.tick([2.59 + 4.0, 0.55 - 4.0]).verdict.text for _ in range(20)}
    assert (solves, texts) == ([], {outcome.verdict.text})
    tracking.tick([2.59 + 4.0, 0.55 - 3.999])
    assert solves


def test_motors_for_which_there_was_no_time_are_tried_again(monkeypatch):
    tracking = Tracking("rfrfr")
    tracking.tick([2.59, 0.55])
    with monkeypatch.context() as patch:
        patch.setattr(motor_tracking, "attempt", lambda *given: attempt(*given[:4], 0.0))
        outcome = tracking.tick([2.60, 0.54])
    assert outcome.state == State.LOST
    assert outcome.verdict.text == "no equilibrium is found within 0 s"
    assert tracking.tick([2.60, 0.54]).state == State.TRACKING


def test_what_is_measured_in_two_places_is_lost_until_it_is_in_one():
    """It was TRACKING with NONE, at the one place and the other."""
    tracking = Tracking("rfrfr")
    home = solve_home(tracking.robot).motors
    for number in range(200):
        outcome = tracking.tick(home + [0.3 * (number % 2), 0.0])
        if number > 20:
            assert (outcome.state, outcome.verdict.action) == (State.LOST, Action.HALT)
            assert "measured in two places in turn, 0.3" in outcome.verdict.text
    states = [tracking.tick(home).state for _ in range(700)]
    assert states[0] == State.LOST and states[-1] == State.TRACKING
    assert states == sorted(states, key=lambda state: state == State.TRACKING)


def test_no_tolerance_ends_it():
    """It was LOST until it was deactivated."""
    tracking = Tracking("rfrfr")
    home = solve_home(tracking.robot).motors
    for number in range(30):
        assert tracking.tick(home + [0.3 * (number % 2), 0.0]).state
    tracking.tracker.take(home, tracking.now, tolerance=0.0)
    assert tracking.tick().state == State.TRACKING


def test_motors_that_swing_as_fast_as_they_may_are_in_one_place():
    """However seldom they are measured."""
    tracking = Tracking("rfrfr")
    home, speed = solve_home(tracking.robot).motors, SETTINGS.max_speed
    for number in range(600):
        swung = home + [0.3 * np.sin(speed / 0.3 * tracking.now), 0.0]
        outcome = tracking.tick(swung if number % 40 == 0 else None)
        assert outcome.state in (State.TRACKING, State.IDLE)
