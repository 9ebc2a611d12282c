# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An external wrench while setpoints are followed: held against, borne from tick to tick, or refused."""

import numpy as np
from helpers.counted_solves import Solves
from helpers.drive import PERIOD, Drive, robot, to

from cpr_core import solve_home, solve_inverse
from cpr_core.model.assessment import Assessment
from cpr_core.solving.deadline import Deadline
from cpr_ros.following import borne_loads
from cpr_ros.following.external_wrench import ExternalWrench
from cpr_ros.following.supervision import Action, State, Status


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
