# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Solutions that are applied: only where the motors are, and while nothing else is on its way."""

import itertools

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveInverse
from geometry_msgs.msg import PoseStamped
from helpers.branches import stable_elsewhere
from helpers.drive import PERIOD
from helpers.session_bench import Bench, apply, commanded, still, stop

from cpr_core import solve_forward
from cpr_ros.error_codes import RequestError
from cpr_ros.following.goals import MotorGoal
from cpr_ros.following.supervision import Action, State
from cpr_ros.operation.kept_state import KeptState
from cpr_ros.operation.starting_place import HELD, begin_at_last


def test_another_solution_takes_the_place_of_one_that_commands_are_on_their_way_to(bench):
    """One that was applied by mistake: taken back as docs/node.md says."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 2.7, 0.5)
    assert bench.tick().state == State.ALIGNING
    apply(session, 2.5, 0.6)
    assert bench.tick().state == State.ALIGNING
    assert bench.commands[-1][0] < bench.commands[-2][0]
    session.orders.pause(True)
    bench.tick()
    held = bench.commands[-1].copy()
    apply(session, *held, start=home)
    session.orders.pause(False)
    for _ in range(3):
        assert bench.tick().state == State.IDLE
    np.testing.assert_array_equal(bench.commands[-1], held)
    where, expected = session.solver.current.equilibrium, solve_forward(session.robot, held)
    np.testing.assert_allclose(where.platform_position, expected.platform_position, atol=1e-9)


def test_a_pause_on_the_way_tells_that_the_motors_are_elsewhere_and_a_release_where_they_go(bench):
    """The stream said stable and NONE, the release that a setpoint was waited for: motors drove off."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    assert session.orders.pause(True) == "paused, the setpoint is forgotten"
    assert session.orders.pause(False) == "waiting for a setpoint"
    commanded(session, home.motors)
    apply(session, 2.7, 0.5)
    for _ in range(5):
        assert bench.tick().state == State.ALIGNING
    words = "the motors are not where the node has the robot: commands are held on their way"
    answer = session.orders.pause(True)
    assert answer.startswith(f"paused, the setpoint is forgotten; {words}, motor1 from ")
    assert answer.endswith(" rad; ~/pause false lets them go on")
    for _ in range(3):
        bench.tick()
        told = session.verdict(bench.now)
        assert told.action == Action.SLOW and words in told.text
    answer = session.orders.pause(False)
    assert answer.startswith("commands go on, at 1 rad/s or rod lengths/s at most: motor1 from ")
    assert " to 2.7 rad, motor2 from " in answer
    while bench.tick().state == State.ALIGNING:
        assert words not in session.verdict(bench.now).text
    np.testing.assert_array_equal(bench.commands[-1], [2.7, 0.5])


def test_a_solution_of_another_branch_is_applied_only_where_the_motors_are(bench):
    """They went there straight, and the robot came to the one that its own branch has there."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    other = stable_elsewhere(session.robot)
    commanded(session, home.motors)
    with pytest.raises(RequestError, match="leads to another equilibrium"):
        apply(session, 2.7, 0.5, start=other)
    for _ in range(3):
        assert bench.tick().state == State.IDLE
    assert bench.commands == []
    apply(session, *home.motors, start=other)
    assert bench.tick().state == State.IDLE
    where = session.solver.current.equilibrium.platform_position
    np.testing.assert_allclose(where, other.platform_position, atol=1e-9)
    assert bench.commands == []
    apply(session, 2.6, 0.5, start=other)  # straight on from there
    assert bench.tick().state == State.ALIGNING


def test_no_solution_beyond_a_stop_threshold_is_applied(bench):
    """629 commands led there at full speed, while the stream said HALT."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    target = PoseStamped()
    target.pose.position.y = 0.038
    with pytest.raises(RequestError, match=r"% of the way: margin would be .* below margin_stop"):
        session.solver.inverse(SolveInverse.Request(platform=target, apply=True))
    assert bench.tick().state == State.IDLE
    assert bench.commands == []


def test_the_way_to_a_solution_is_given_the_time_that_its_request_has_left(bench):
    session, home = bench.session, bench.session.solver.current
    commanded(session, home.equilibrium.motors)
    begun = session.solver.current
    # The clock stands still while it is solved.
    session.solver.clock = itertools.chain([0.0, 0.0], itertools.repeat(1e9)).__next__
    with pytest.raises(RequestError, match="before the way of the motors") as refused:
        apply(session, 2.9, 0.2)
    assert refused.value.val == ErrorCode.TIMED_OUT
    assert session.solver.current is begun


def test_commands_that_were_on_their_way_are_held_after_a_restart_until_they_are_released(
    bench, tmp_path
):
    """They set off by themselves: to where a mistake was to lead that had been paused before."""
    session, home = bench.session, bench.session.solver.current.equilibrium
    commanded(session, home.motors)
    apply(session, 3.2, -0.1)
    for _ in range(20):
        assert bench.tick().state == State.ALIGNING
    held = bench.commands[-1]
    kept = KeptState(tmp_path / "state", session.robot)
    kept.keep(session.solver.current.equilibrium, held)
    again = Bench()
    said = begin_at_last(again.session, kept.last())
    assert said.startswith(
        "where it was last, motors (3.2, -0.1); commands were on their way there"
    )
    assert said.endswith(HELD)
    again.session.stand()
    for _ in range(5):
        assert again.tick().state == State.PAUSED
    assert again.commands == []
    again.session.orders.pause(False)
    assert again.tick().state == State.ALIGNING
    step = np.abs(again.commands[0] - held).max()
    assert 0.0 < step <= PERIOD * (1.0 + 1e-6)
    kept.close()


def test_no_solution_is_applied_while_the_robot_is_on_its_way_home(bench):
    """It dropped the way home that waited for the commands, too, without a word."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    apply(session, 2.7, 0.5)
    assert bench.tick().state == State.ALIGNING
    session.orders.reset()
    for _ in range(2):
        with pytest.raises(RequestError, match="the robot is on its way"):
            apply(session, 2.6, 0.5)
        bench.tick()
    while bench.tick().state != State.IDLE:
        pass
    np.testing.assert_array_equal(bench.commands[-1], home)
    apply(session, 2.6, 0.5)


def test_no_solution_is_applied_while_paused(bench):
    """The motors set off to it as soon as the pause was over."""
    session, home = bench.session, bench.session.solver.current.equilibrium.motors
    commanded(session, home)
    session.orders.pause(True)
    bench.tick()
    with pytest.raises(RequestError, match="paused"):
        apply(session, 2.7, 0.5)
    session.orders.pause(False)
    assert bench.tick().state == State.IDLE
    assert bench.commands == []


def test_no_solution_is_applied_in_place_of_a_setpoint_that_has_just_come(bench):
    session = bench.session
    session.orders.follow(MotorGoal(session.robot, [2.69, 0.50]), bench.now)
    with pytest.raises(RequestError, match="the robot is on its way"):
        apply(session, 2.6, 0.5)
    stop(session, bench.now)  # as the message says
    apply(session, 2.6, 0.5)


def test_no_solution_is_applied_while_a_trajectory_is_being_solved(bench):
    """It ended the trajectory: the robot had been moved."""
    session, endings = bench.session, []
    home = session.solver.current.equilibrium.motors
    motion = still(session, home, bench.now, 300.0, endings.append)
    assert motion.goal is None
    with pytest.raises(RequestError, match="a trajectory is to be followed"):
        apply(session, 2.6, 0.5)
    assert not endings
    stop(session, bench.now)  # as the message says
    assert [ending.val for ending in endings] == [ErrorCode.PREEMPTED]
    apply(session, 2.6, 0.5)


def test_no_solution_is_applied_and_no_rest_had_while_somebody_waits_for_a_goal(bench):
    """One that waits to be measured where it is: ticks tell, and it went elsewhere without a word."""
    session = bench.session
    goal = MotorGoal(session.robot, [2.6, 0.55])
    session.orders.follow(goal, bench.now, ages=False)
    session.orders.await_end(goal)
    while bench.tick().state != State.IDLE:
        pass
    assert not session.at_rest
    with pytest.raises(RequestError, match="a goal of ~/move_to waits"):
        apply(session, 2.6, 0.5)
    session.orders.follow(MotorGoal(session.robot, [2.6, 0.55]), bench.now, ages=False)  # nobody's
    bench.tick()
    assert session.at_rest
    apply(session, 2.6, 0.5)
