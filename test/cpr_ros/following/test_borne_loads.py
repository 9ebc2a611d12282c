# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Other loads at the same motors: borne in one tick or in several, refused, and taken away again."""

import time
from itertools import count

import numpy as np
import pytest
from helpers.drive import robot

from cpr_core import NoForwardSolution, solve_forward, solve_home, solve_inverse
from cpr_core.model.assessment import Assessment
from cpr_core.solving.deadline import Deadline
from cpr_ros.following import borne_loads
from cpr_ros.following.borne_loads import BorneLoads
from cpr_ros.following.steps import Undecided, attempt

#: Two pushes near where the hexapod buckles, each of them borne, from one side to the other [N].
TO_ONE_SIDE, TO_THE_OTHER = [-0.75, 1.3, 0.4], [-1.6, -1.45, -0.5]


@pytest.fixture
def home():
    return solve_home(robot("rfrfr"))


@pytest.fixture(scope="module")
def at_the_border():
    """The hexapod so far to one side that it is halted for its margin."""
    start = solve_home(robot("gough_stewart"))
    return solve_inverse(start.robot, start.pose + [0.0664, 0, 0, 0, 0, 0, 0], start=start)


def under(loads, start):
    """The stable equilibrium under other loads at the same motors, in one solve."""
    return solve_forward(start.robot, start.motors, start=start, loads=loads, stable_only=True)


def pushed(equilibrium, force):
    return equilibrium.loads.with_(wrench_world=[0, 0, 0, *force])


class Ticks:
    """Where a robot is under loads that change, a tick after the other."""

    def __init__(self, equilibrium):
        self.bearing = BorneLoads(equilibrium.robot)
        self.current, self.refusal, self.now = Assessment(equilibrium), None, 0.0

    def tick(self, loads):
        self.now += 1.0
        self.current, self.refusal = self.bearing.at(self.current, loads, self.now)
        return self.refusal

    def push(self, force):
        """Ticks until it is told whether a force is borne; the equilibrium changes in the last one."""
        before, loads = self.current, pushed(self.current.equilibrium, force)
        for _ in range(100):
            refusal = self.tick(loads)
            decided = not isinstance(refusal, Undecided)  # a busy computer takes some ticks more
            if refusal is None or (decided and "not borne yet" not in refusal.text):
                return refusal
            assert self.current is before
        raise AssertionError(f"not told in 100 ticks: {self.refusal}")


@pytest.fixture
def solves(monkeypatch):
    """The loads of every solve that is asked for."""
    asked = []

    def counted(current, goal, fraction, loads):
        asked.append(loads)
        return attempt(current, goal, fraction, loads)

    monkeypatch.setattr(borne_loads, "attempt", counted)
    return asked


def one_step_at_a_time(monkeypatch):
    """There is time for one step of a walk, however fast the computer is."""
    walks = []

    def over(deadline):
        walks.append(deadline)
        return walks.count(deadline) > 1

    monkeypatch.setattr(Deadline, "over", property(over))


def test_loads_that_have_not_changed_are_borne_where_the_robot_is(home):
    current = Assessment(home)
    assert BorneLoads(home.robot).at(current, home.loads, 0.0) == (current, None)


def test_other_loads_are_borne_at_the_same_motors(home):
    loads = pushed(home, [0, -0.1, 0])
    borne, refusal = BorneLoads(home.robot).at(Assessment(home), loads, 0.0)
    assert refusal is None
    assert borne.equilibrium.loads is loads
    np.testing.assert_array_equal(borne.equilibrium.motors, home.motors)
    assert borne.equilibrium.platform_position[1] < home.platform_position[1]


def test_loads_that_are_not_borne_leave_the_robot_where_it_is(home, solves):
    ticks = Ticks(home)
    refusal = ticks.push([0, -1000.0, 0])
    assert ticks.current.equilibrium is home
    assert refusal.text.startswith("the external wrench is not borne: ")
    before, loads = len(solves), pushed(home, [0, -1001.0, 0])
    refusal = ticks.tick(loads)
    assert ticks.tick(loads) is refusal  # it is not solved for again
    assert len(solves) == before + 1


def test_a_load_beyond_where_branches_cross_is_refused_in_the_end(at_the_border):
    """Ticks of 0.1 s got nowhere for ever, and the model was where a part of the load had brought it."""
    ticks, loads = Ticks(at_the_border), pushed(at_the_border, [0, 0, 20.0])
    for _ in range(100):
        refusal = ticks.tick(loads)
        assert ticks.current.equilibrium is at_the_border
        if refusal.text.startswith("the external wrench is not borne: no equilibrium is "):
            return
    raise AssertionError(refusal.text)


def test_a_way_that_gets_nowhere_is_tried_again_but_not_all_the_time(home, solves, monkeypatch):
    """No tick takes longer for it: streams wait."""
    monkeypatch.setattr(Deadline, "over", property(lambda deadline: True))
    ticks, loads = Ticks(home), pushed(home, [0, -0.1, 0])
    monkeypatch.setattr(time, "perf_counter", count(0.0, 0.1).__next__)  # what a tick takes
    for _ in range(3):
        assert "the external wrench is not borne yet: " in ticks.tick(loads).text
    refusal = ticks.tick(loads)
    assert "the external wrench is not borne: no equilibrium is found" in refusal.text
    ticks.now -= 0.5  # half a second later
    assert ticks.tick(loads) is refusal
    assert len(solves) == 4
    monkeypatch.undo()
    ticks.now += 10.0
    assert ticks.tick(loads) is None
    assert ticks.current.equilibrium.loads is loads


def test_a_load_is_borne_in_several_ticks_as_in_one(monkeypatch):
    start = solve_home(robot("six_rfs"))
    whole, parts = Ticks(start), Ticks(start)
    assert whole.push([0.4, 0, -1.0]) is None
    one_step_at_a_time(monkeypatch)
    assert parts.push([0.4, 0, -1.0]) is None
    assert parts.now > 2.0
    found, expected = parts.current.equilibrium, whole.current.equilibrium
    np.testing.assert_array_equal(found.motors, start.motors)
    np.testing.assert_allclose(found.state, expected.state, rtol=0.0, atol=1e-9)


def test_a_load_that_changes_on_the_way_is_followed_on_from_there(monkeypatch):
    """A wrench is measured anew before the last one is borne."""
    start = solve_home(robot("six_rfs"))
    ticks = Ticks(start)
    with monkeypatch.context() as slow:
        one_step_at_a_time(slow)
        assert "not borne yet" in ticks.tick(pushed(start, [0.4, 0, -1.0])).text
        assert "not borne yet" in ticks.tick(pushed(start, [0.4, 0, -1.01])).text
        assert ticks.push([0.4, 0, -1.02]) is None
    whole = under(pushed(start, [0.4, 0, -1.02]), start)
    found = ticks.current.equilibrium
    np.testing.assert_allclose(found.state, whole.state, rtol=0.0, atol=1e-9)


def test_a_load_that_is_gone_before_it_was_borne_has_changed_nothing(at_the_border, monkeypatch):
    ticks = Ticks(at_the_border)
    with monkeypatch.context() as slow:
        one_step_at_a_time(slow)
        assert "not borne yet" in ticks.tick(pushed(at_the_border, [0, 0, 20.0])).text
    assert ticks.tick(at_the_border.loads) is None
    assert ticks.current.equilibrium is at_the_border


def buckled_by_pushes(at_the_border):
    """It is held by a push to one side, on the sheet that leans to the other."""
    ticks = Ticks(at_the_border)
    assert ticks.push(TO_ONE_SIDE) is None
    assert ticks.push(TO_THE_OTHER) is None
    return ticks


def test_pushes_that_are_borne_may_lead_where_the_branch_ends_on_the_straight_way_back(
    at_the_border,
):
    """No step had jumped: in small ones it goes the same way, and back."""
    there = buckled_by_pushes(at_the_border).current.equilibrium
    small, loads = at_the_border, [at_the_border.loads]
    for force in (TO_ONE_SIDE, TO_THE_OTHER):
        first = loads[-1]
        for part in np.linspace(0.05, 1.0, 20):
            loads.append(first.toward(pushed(at_the_border, force), part))
            small = under(loads[-1], small)
    np.testing.assert_allclose(small.state, there.state, rtol=0.0, atol=1e-6)
    with pytest.raises(NoForwardSolution, match="turns back"):
        solve_forward(there.robot, there.motors, start=there, loads=at_the_border.loads)
    for last in reversed(loads):
        small = under(last, small)
    np.testing.assert_allclose(small.state, at_the_border.state, rtol=0.0, atol=1e-6)


def test_the_end_of_a_push_leads_back_the_way_it_came(at_the_border):
    """It was HALT for ever, with the cause gone, in numbers of a push that had ended."""
    ticks = buckled_by_pushes(at_the_border)
    refusal = ticks.push([0, 0, 0])
    assert refusal.reason == "branch_jump"
    assert "held it now that it is gone: no equilibrium is reached: the branch " in refusal.text
    assert refusal.text.endswith("was before that wrench, but may have snapped elsewhere")
    found = ticks.current.equilibrium
    np.testing.assert_allclose(found.state, at_the_border.state, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(found.motors, at_the_border.motors)
    assert ticks.tick(found.loads) is None  # it was told once
    assert buckled_by_pushes(found).current.equilibrium.stable


def test_a_push_that_becomes_smaller_leads_back_the_way_it_came(at_the_border):
    ticks = buckled_by_pushes(at_the_border)
    refusal = ticks.push([-0.05, -0.05, 0.0])
    assert "now that it is less: " in refusal.text
    direct = under(pushed(at_the_border, [-0.05, -0.05, 0.0]), at_the_border)
    found = ticks.current.equilibrium
    np.testing.assert_allclose(found.state, direct.state, rtol=0.0, atol=1e-9)
    assert ticks.push([0, 0, 0]) is None


def test_a_way_back_is_followed_from_tick_to_tick_too(at_the_border, monkeypatch):
    ticks = buckled_by_pushes(at_the_border)
    real = borne_loads.attempt

    def late(current, goal, fraction, loads):
        """The first solve from before the pushes gets nowhere."""
        if current.equilibrium is at_the_border and not late.told:
            late.told = True
            return Undecided("not_converged", "no equilibrium is found within 0.1 s")
        return real(current, goal, fraction, loads)

    late.told = False
    monkeypatch.setattr(borne_loads, "attempt", late)
    refusal = ticks.push([0, 0, 0])
    assert late.told
    assert refusal.reason == "branch_jump"
    np.testing.assert_array_equal(ticks.current.equilibrium.motors, at_the_border.motors)


def test_the_end_of_a_push_says_what_helps_where_no_way_back_is_known(at_the_border):
    """Under the push the motors had moved, or a solution was applied."""
    ticks = Ticks(buckled_by_pushes(at_the_border).current.equilibrium)
    before = ticks.current
    refusal = ticks.push([0, 0, 0])
    assert ticks.current is before
    assert refusal.reason == "not_converged"
    assert refusal.text.startswith(
        "the robot cannot rest where the external wrench held it now that it is gone: no equilibrium"
    )
    assert refusal.text.endswith("; measure the motors, or apply a solution from home")


def test_a_larger_push_is_not_tried_from_before_the_first(at_the_border):
    """A robot that snaps under it is not to go on as if it had not."""
    ticks = buckled_by_pushes(at_the_border)
    before = ticks.current
    refusal = ticks.push([0, -3.0, 0])
    assert ticks.current is before
    assert refusal.text.startswith("the external wrench is not borne: ")
    assert Ticks(at_the_border).push([0, -3.0, 0]) is None  # from there it would be borne
