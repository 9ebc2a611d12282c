# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A solver that fails, jumps or has no time holds the robot, and is not asked all the time."""

import time
from dataclasses import replace

import numpy as np
import pytest
from helpers.counted_solves import Solves
from helpers.drive import SETTINGS, Drive, to

from cpr_core import Equilibrium, solve_home
from cpr_ros.following import judged_steps, pose_steps, steps
from cpr_ros.following.goals import MotorGoal, PoseGoal
from cpr_ros.following.supervision import State, Status


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
