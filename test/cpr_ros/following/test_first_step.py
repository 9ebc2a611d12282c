# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The first step out of rest: when it is judged ahead, and that it is the one which is taken."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.drive import PERIOD, SETTINGS, Drive, robot
from helpers.shipped_steps import REDUNDANT, STEPS

from cpr_core import solve_forward, solve_home
from cpr_core.model.assessment import Assessment, Threshold
from cpr_core.model.kinemato_statics import KinematoStatics
from cpr_ros.following.first_step import FirstStep
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.judged_steps import JudgedSteps
from cpr_ros.following.pose_steps import PoseSteps, TickWay
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
        known = self.first.knows(self.current)
        return self.follower.aim(self.current, self.now) if known else None


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
    assert not rest.first.knows(Assessment(rest.current.equilibrium))
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


@pytest.mark.parametrize("name", sorted(set(STEPS) - set(REDUNDANT)))
@pytest.mark.parametrize("part", [1e-3, 1.0])
def test_the_first_step_towards_a_pose_is_along_the_tangent(name, part):
    """To the last bit what the tick takes, looked around or not; then straight to the pose."""
    rest, direct = Rest(name, max_speed=0.1), Rest(name, max_speed=0.1)
    motors = rest.motors + part * np.array(STEPS[name])
    pose = solve_forward(rest.robot, motors, start=rest.current.equilibrium).pose
    rest.look_around()
    for each in (rest, direct):
        each.follow(PoseGoal(each.robot, pose))
    aim = rest.aim()
    assert direct.aim() is None
    # As above, a leg that is nearly straight; the inverse problem of the others is far from singular.
    assert aim is not None or name == "gough_stewart"
    first = rest.tick()
    after = first.assessment.equilibrium.motors
    np.testing.assert_array_equal(direct.tick().assessment.equilibrium.motors, after)
    if aim is not None:
        np.testing.assert_array_equal(after, aim)
    if part < 1.0:  # all of it, but for its bend
        left = PoseGoal(rest.robot, pose).remaining(first.assessment.equilibrium)
        assert left < 1e-2 * PoseGoal(rest.robot, pose).remaining(solve_home(rest.robot))
    rest.until_state(State.IDLE)
    np.testing.assert_allclose(rest.current.equilibrium.pose, pose, atol=1e-9)


def test_a_way_of_less_than_a_tick_is_gone_at_once_but_for_its_bend():
    rest = Rest("six_rfs")
    start = rest.current.equilibrium
    pose = solve_forward(rest.robot, start.motors + 0.2 * PERIOD, start=start).pose
    rest.look_around()
    goal = PoseGoal(rest.robot, pose)
    rest.follow(goal)
    whole = goal.remaining(start)
    rest.tick()
    assert 1e-9 < goal.remaining(rest.current.equilibrium) < 1e-2 * whole
    rest.tick()
    assert goal.remaining(rest.current.equilibrium) < 1e-9


@pytest.mark.parametrize("name", ["rfrfr", "three_prs"])
def test_where_the_tangent_tells_nothing_the_way_is_felt(name, monkeypatch):
    """A matrix that cannot be had ends no tick."""
    rest = Rest(name)
    motors = rest.motors + 0.3 * np.array(STEPS[name])
    pose = solve_forward(rest.robot, motors, start=rest.current.equilibrium).pose
    rest.look_around()
    rest.follow(PoseGoal(rest.robot, pose))
    assert rest.aim() is not None

    def failing(_model):
        raise np.linalg.LinAlgError("for a test")

    nothing = np.full((rest.robot.motor_count,) * 2, np.nan)
    for tangent in (property(failing), property(lambda _model: nothing)):
        monkeypatch.setattr(KinematoStatics, "motors_by_pose", tangent)
        assert rest.aim() is None
    rest.until_state(State.IDLE)
    np.testing.assert_allclose(rest.current.equilibrium.pose, pose, atol=1e-9)


def test_the_first_step_keeps_the_speed_of_the_platform():
    """It is whole where neither motors nor platform need more than a tick, else short."""
    rest = Rest("six_rfs")
    current, motor_steps = rest.current, [1.0] * 6
    start = current.equilibrium
    goal = PoseGoal(rest.robot, solve_forward(rest.robot, start.motors + 0.001, start=start).pose)
    steps, remaining = PoseSteps(rest.robot), goal.remaining(start)
    way = goal.motors_ahead(current)
    for platform_step, part in ((1.001, 1.0), (0.999, 0.0999), (0.1, 0.01)):
        tick = TickWay(motor_steps, platform_step * remaining)
        aim = steps.first(current, goal, 1.0, tick)
        np.testing.assert_allclose(aim - start.motors, part * way, rtol=1e-9)
        aim = steps.first(current, goal, 0.5, tick._replace(platform=2.0 * tick.platform))
        np.testing.assert_allclose(aim - start.motors, part * way, rtol=1e-9)


def test_towards_a_pose_the_inverse_singularity_counts_too():
    rest = Rest("rfrfr")
    value = rest.current.inverse_singularity
    near = SETTINGS.thresholds | {"inverse_singularity": Threshold(1.0001 * value, 0.0)}
    rest.follower.settings = replace(SETTINGS, thresholds=near)
    rest.look_around()
    rest.follow(PoseGoal(rest.robot, rest.current.equilibrium.pose + 0.001))
    assert rest.aim() is None
    rest.follow(MotorGoal(rest.robot, rest.motors + 0.01))
    assert rest.aim() is not None


def test_the_way_to_a_pose_that_is_corrected_or_driven_is_solved_first():
    rest = Rest("rfrfr")
    rest.look_around()
    pose = rest.current.equilibrium.pose
    goal = PoseGoal(rest.robot, pose + 0.001)
    rest.follow(goal)
    assert rest.aim() is not None
    rest.follower.corrected = lambda followed: followed.at(followed.pose + 1e-5)
    assert rest.aim() is None
    driven = Rest("rfrfr")
    driven.look_around()
    goal.driven = True
    driven.follow(goal)
    assert driven.aim() is None


def test_who_does_not_go_straight_at_full_speed_is_solved_first():
    rest = Rest("rfrfr", setpoint_timeout=0.5)
    rest.look_around()
    follower, motors = rest.follower, rest.motors
    assert rest.aim() is None  # nobody asks for anything
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
        patched.setattr(JudgedSteps, "_danger", lambda *_: danger)
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
