# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The first step out of rest: when it is judged ahead, and that it is the one which is taken."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS, Drive, robot
from helpers.shipped_steps import STEPS

from cpr_core import solve_forward, solve_home
from cpr_core.model.assessment import Assessment, Threshold
from cpr_ros.following.first_step import FirstStep
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.setpoint_following import SetpointFollower
from cpr_ros.following.supervision import Refusal, State


class Rest(Drive):
    """A robot at rest, which looks around."""

    def __init__(self, name, **settings):
        super().__init__(robot(name), **settings)
        self.first = FirstStep(self.robot, PERIOD, self.follower)

    def look_around(self):
        """Until there is nothing to look at any more; how many looks that took."""
        looks = 0
        self.first.look(self.current, self.now)
        while math.isfinite(self.first.due):
            assert self.first.due > self.now
            self.now = self.first.due
            self.first.look(self.current, self.now)
            looks += 1
        return looks

    def aim(self):
        return self.first.aim(self.current, self.now)


@pytest.mark.parametrize("name", sorted(STEPS))
def test_it_is_the_step_that_the_tick_takes(name):
    """To the last bit: another command would have to follow otherwise."""
    rest, random = Rest(name, max_speed=0.1), np.random.default_rng(3)
    for part in (1e-4, 1.0, -0.5):
        rest.look_around()
        target = rest.motors + part * np.array(STEPS[name]) * random.uniform(0.5, 1.0)
        rest.follow(MotorGoal(rest.robot, target))
        aim = rest.aim()
        # Legs that are nearly straight are loaded twice as much after a step, and have to be solved.
        assert aim is not None or (name == "gough_stewart" and part != 1e-4)
        outcome = rest.tick()
        assert outcome.moved
        if aim is not None:
            np.testing.assert_array_equal(outcome.assessment.equilibrium.motors, aim)
        assert rest.aim() is None  # in motion nothing is known ahead
        rest.until_state(State.IDLE)


def test_it_is_looked_at_only_after_a_while_and_with_pauses():
    rest = Rest("rfrfr")
    assert math.isinf(rest.first.due)
    rest.first.look(rest.current, 10.0)
    assert rest.first.due == pytest.approx(10.02)
    rest.first.look(rest.current, 10.01)
    assert rest.first.due == pytest.approx(10.02)
    rest.first.look(rest.current, 10.03)
    assert 10.03 < rest.first.due < 10.04
    rest.first.wait()
    assert math.isinf(rest.first.due)
    rest.first.look(rest.current, 11.0)  # it goes on where it was interrupted
    assert rest.first.due == pytest.approx(11.02)
    rest.now = 11.0
    assert rest.look_around() == 4  # three looks are left, and one that finds nothing to look at


def test_without_having_looked_nothing_is_known():
    rest = Rest("rfrfr")
    rest.follow(MotorGoal(rest.robot, rest.motors + 0.01))
    assert rest.aim() is None
    rest.first.look(rest.current, 0.0)
    rest.first.look(rest.current, 1.0)
    assert rest.aim() is None  # one look of four


def test_what_is_known_holds_of_this_place_and_these_settings_only():
    rest = Rest("rfrfr")
    rest.look_around()
    rest.follow(MotorGoal(rest.robot, rest.motors + 0.01))
    assert rest.aim() is not None
    assert rest.first.aim(Assessment(rest.current.equilibrium), rest.now) is None
    slower = replace(SETTINGS, max_speed=0.5)
    rest.follower.settings = slower
    assert rest.aim() is None
    rest.look_around()
    aim = rest.aim()
    assert np.abs(aim - rest.motors).max() == pytest.approx(0.5 * PERIOD)
    high = SETTINGS.thresholds | {"margin": Threshold(1.1 * rest.current.margin, 0.05)}
    rest.follower.settings = replace(slower, thresholds=high)
    rest.look_around()
    assert rest.aim() is None  # where it has to be slow it is solved first


def test_who_does_not_go_straight_to_motors_at_full_speed_is_solved_first():
    rest = Rest("rfrfr", setpoint_timeout=0.5)
    rest.look_around()
    follower, motors = rest.follower, rest.motors
    assert rest.aim() is None  # nobody asks for anything
    rest.follow(PoseGoal(rest.robot, rest.current.equilibrium.pose + 0.001))
    assert rest.aim() is None
    rest.follow(MotorGoal(rest.robot, motors))
    assert rest.aim() is None  # it is there
    rest.follow(MotorGoal(rest.robot, motors + 0.1))
    assert rest.aim() is not None
    rest.now += 0.51
    assert rest.aim() is None  # too old
    rest.follow(MotorGoal(rest.robot, motors + 0.1))
    follower.pause(True)
    assert rest.aim() is None
    follower.pause(False)
    follower.reset()
    assert rest.aim() is None  # a way home is told to be one, and where it ends


def test_after_a_refused_step_the_next_one_is_solved_first(monkeypatch):
    rest = Rest("rfrfr")
    rest.look_around()
    rest.follow(MotorGoal(rest.robot, rest.motors + 0.1))
    assert rest.aim() is not None
    danger = Refusal("not_converged", "for a test")
    with monkeypatch.context() as patched:
        patched.setattr(SetpointFollower, "_danger", lambda *_: danger)
        assert not rest.tick().moved
    assert rest.aim() is None


def test_near_a_warning_it_is_solved_first():
    """On the way to a fold: before the margin is at its warning nothing is commanded ahead any more."""
    rest = Rest("rfrfr")
    home, way = solve_home(rest.robot), np.array([3.1, -3.1])
    warning, ahead = SETTINGS.thresholds["margin"].warning, []
    found = home
    for part in np.linspace(0.0, 1.0, 32):
        found = solve_forward(rest.robot, home.motors + part * way, start=found)
        rest.current = Assessment(found)
        rest.look_around()
        rest.follow(MotorGoal(rest.robot, found.motors + 0.001 * way))
        ahead.append(rest.aim() is not None)
    assert found.margin < warning
    assert ahead[0]
    assert ahead == sorted(ahead, reverse=True)
    assert not ahead[-1]
    last = solve_forward(rest.robot, home.motors + (sum(ahead) - 1) / 31 * way)
    assert warning < last.margin < 2.0 * warning
