# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a robot begins: at home, where it was last, or where it is measured."""

import numpy as np
import pytest
from helpers.branches import stable_elsewhere
from helpers.drive import PERIOD, robot
from helpers.geared_robots import geared
from helpers.session_bench import ticked

from cpr_core import CprError, solve_forward, solve_home, solve_inverse
from cpr_ros.messages.frames import Frames
from cpr_ros.operation.kept_state import KnownPlace
from cpr_ros.operation.session import Session
from cpr_ros.operation.starting_place import (
    HELD,
    begin_at,
    begin_at_commands,
    begin_at_home,
    begin_at_last,
    begin_at_measured,
    begin_on_way_home,
)
from cpr_ros.settings.node_settings import Parameters, live_parameters
from cpr_ros.settings.parameter_table import PARAMETERS

DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}
FIXED = {parameter.name: parameter.default for parameter in PARAMETERS if not parameter.live}


OF_A_SESSION = (
    Frames("base", "platform"),
    Parameters(**FIXED | {"characteristic_length": None}),
    live_parameters(DEFAULTS.__getitem__),
)


@pytest.fixture
def session(request):
    return Session(robot(getattr(request, "param", "rfrfr")), *OF_A_SESSION)


def at(session):
    return session.solver.current.equilibrium


def test_the_wrench_of_then_is_taken_away_and_the_commands_stay(session):
    loads = session.robot.default_loads.with_(wrench_world=[0, 0, 0, 0.2, -0.3, 0])
    pushed = solve_forward(session.robot, [2.7, 0.4], loads=loads)
    said = begin_at_last(session, KnownPlace(pushed, np.array([2.71, 0.39])))
    began = (
        "where it was last, motors (2.7, 0.4); commands were on their way there from (2.71, 0.39)"
    )
    assert said == f"{began}: {HELD}"
    free = solve_forward(session.robot, [2.7, 0.4])
    np.testing.assert_allclose(at(session).platform_position, free.platform_position, atol=1e-10)
    assert at(session).loads is session.robot.default_loads
    np.testing.assert_array_equal(session.commands.newest, [2.71, 0.39])


def test_an_equilibrium_that_is_unstable_without_its_wrench_is_no_place_to_begin(session):
    unstable = solve_inverse(session.robot, [0.0, 0.0])
    assert unstable.index_locked > 0
    with pytest.raises(CprError, match="unstable"):
        begin_at_last(session, KnownPlace(unstable, unstable.motors))


def test_measured_near_by_it_stays_on_its_branch_and_far_away_it_is_on_that_of_home(session):
    home = solve_home(session.robot)
    other = stable_elsewhere(session.robot)
    begin_at(session, other, other.motors, 0.0)
    begin_at_measured(session, other.motors + 0.01)
    near = solve_forward(session.robot, other.motors + 0.01, start=other)
    np.testing.assert_allclose(at(session).platform_position, near.platform_position, atol=1e-9)
    begin_at_measured(session, other.motors + 0.3)
    home = solve_forward(session.robot, other.motors + 0.3)
    np.testing.assert_allclose(at(session).platform_position, home.platform_position, atol=1e-9)
    np.testing.assert_array_equal(session.commands.newest, other.motors + 0.3)


def test_what_is_near_by_counts_behind_gears():
    """A motor that turns a hundred times as far as its joint is soon radians away."""
    plain, machine, ratios = geared("rfrfr")
    session = Session(machine, *OF_A_SESSION)
    joints = stable_elsewhere(plain).motors
    other = stable_elsewhere(machine)
    np.testing.assert_allclose(other.motors * ratios, joints, atol=1e-6)
    for way, near in ((0.05, True), (0.3, False)):
        begin_at(session, other, other.motors, 0.0)
        begin_at_measured(session, other.motors + way / ratios)
        start = other if near else solve_home(machine)
        found = solve_forward(machine, other.motors + way / ratios, start=start)
        place = at(session).platform_position
        np.testing.assert_allclose(place, found.platform_position, atol=1e-9)


@pytest.mark.parametrize("session", ["six_rfs"], indirect=True)
@pytest.mark.parametrize("wrench", [{"wrench_world": [0, 0, 0.02, 0, 0, 0]}, {"wrench_body": 0.01}])
def test_measured_it_is_without_the_wrench_that_acted_last(session, wrench):
    """One without a potential: nothing told where it is stable, and it could not be placed again."""
    wrench = {name: np.broadcast_to(values, 6) for name, values in wrench.items()}
    loads = session.robot.default_loads.with_(**wrench)
    assert not session.robot.has_potential(loads)
    measured = at(session).motors + 0.02
    pushed = solve_forward(session.robot, at(session).motors, loads=loads)
    begin_at(session, pushed, pushed.motors, 0.0)
    begin_at_measured(session, measured)
    free = solve_forward(session.robot, measured)
    np.testing.assert_allclose(at(session).platform_position, free.platform_position, atol=1e-9)
    assert at(session).loads is session.robot.default_loads
    np.testing.assert_array_equal(session.commands.newest, measured)


@pytest.mark.parametrize("told", [False, True])
def test_the_wrench_of_an_applied_solution_acts_no_more_and_it_is_said(session, told):
    """One on the topic acts again in the next tick."""
    loads = session.robot.default_loads.with_(wrench_world=[0, 0, 0, 0.2, -0.3, 0])
    pushed = solve_forward(session.robot, [2.7, 0.4], loads=loads)
    begin_at(session, pushed, pushed.motors, 0.0)
    if told:
        session.wrench.take(loads, 0.0)
    said = begin_at_measured(session, pushed.motors)
    assert (", without the wrench of the solution that was applied" in said) == (not told)
    ticked(session, PERIOD)
    acting = loads if told else session.robot.default_loads
    np.testing.assert_array_equal(at(session).loads.wrench_world, acting.wrench_world)


def test_a_robot_measured_where_only_a_wrench_held_it_is_not_placed_and_it_is_said_why(session):
    unstable = solve_inverse(session.robot, [0.0, 0.0])
    loads = session.robot.default_loads.with_(wrench_world=[0, 0, 0, 0.01, 0, 0])
    held = solve_forward(session.robot, unstable.motors, start=unstable, loads=loads)
    begin_at(session, held, held.motors, 0.0)
    with pytest.raises(CprError, match=r"measured at .* without external wrench, .* unstable"):
        begin_at_measured(session, held.motors + 0.01)
    assert at(session) is held


def test_words_tell_which_branch_does_not_lead_to_where_the_motors_are(session):
    unstable = solve_inverse(session.robot, [0.0, 0.0])
    begin_at(session, unstable, unstable.motors, 0.0)
    with pytest.raises(CprError, match=r"the branch it is on, .* does not lead"):
        begin_at_measured(session, unstable.motors + 0.01)
    with pytest.raises(CprError, match="the branch of home does not lead"):
        begin_at_measured(session, np.array([20.0, 0.55]))


def test_commands_of_another_description_are_begun_at_on_the_branch_of_home(session):
    home, last = solve_home(session.robot), np.array([3.6, -0.4])
    assert "(3.6, -0.4), on the branch of home" in begin_at_commands(session, last)
    np.testing.assert_array_equal(session.commands.newest, last)
    found = solve_forward(session.robot, last, start=home)
    np.testing.assert_allclose(at(session).configuration, found.configuration, atol=1e-9)
    for nowhere, why in (([20.0, 0.55], "does not lead"), ([1e3, 0.5], "does not lead")):
        with pytest.raises(CprError, match=f"the last commands, under another description.*{why}"):
            begin_at_commands(session, np.array(nowhere))
        np.testing.assert_array_equal(session.commands.newest, last)


def test_home_is_gone_to_from_the_last_commands(session):
    home = solve_home(session.robot).motors
    assert begin_at_home(session, None).startswith("nothing is known of where the robot is")
    assert session.commands.newest is None
    last = solve_forward(session.robot, home + [0.1, -0.1])
    assert "to home at max_speed" in begin_at_home(session, last.motors)
    _, command = ticked(session, PERIOD)
    assert 0.0 < np.abs(command - last.motors).max() <= PERIOD * (1.0 + 1e-5)
    assert begin_at_home(session, home) == "the last commands were those of home"


def test_home_is_gone_to_from_where_the_motors_are_measured(session):
    measured = solve_home(session.robot).motors + [0.3, 0.0]
    said = begin_at_home(session, measured, measured=True)
    assert said.startswith("commands go from where the motors are measured, ")
    command = None
    while not session.outgoing.aligned:
        before, (_, command) = session.commands.newest, ticked(session, PERIOD)
        assert np.abs(command - before).max() <= PERIOD * (1.0 + 1e-5)
    home = solve_home(session.robot).motors
    np.testing.assert_array_equal(command, home)
    assert begin_at_home(session, home, measured=True) == "the motors are measured at home"


def commands_within(session, seconds):
    """What leaves for the motors meanwhile."""
    commands = [ticked(session, tick * PERIOD)[1] for tick in range(round(seconds / PERIOD))]
    return [command for command in commands if command is not None]


def on_another_branch(robot):
    start = stable_elsewhere(robot)
    return solve_forward(robot, start.motors + [0.1, 0.05], start=start)


def test_home_is_not_gone_to_by_a_way_on_which_the_robot_would_snap(session):
    """No halt guards commands that align: they went straight through instabilities, at full speed."""
    elsewhere = on_another_branch(session.robot)
    motors = elsewhere.motors
    said = begin_on_way_home(session, motors, last=elsewhere)
    assert said.startswith("commands go from the last ones, ")
    assert "to home at max_speed, not yet: " in said
    assert said.endswith(f"; {HELD}")
    assert session.follower.paused
    assert commands_within(session, 0.1) == []
    np.testing.assert_array_equal(session.commands.newest, motors)
    session.orders.pause(False)  # somebody has looked
    assert len(commands_within(session, 0.1)) > 10


def test_home_is_not_gone_to_from_where_nobody_knows_how_the_robot_stands(session):
    motors = np.array([6.2, -3.0])  # the branch of home turns back before
    for measured in (False, True):
        said = begin_on_way_home(session, motors, measured=measured)
        assert "not yet: how the robot stands there is not known: " in said
        assert session.follower.paused
        assert commands_within(session, 0.1) == []


def test_out_of_a_place_near_an_instability_home_is_gone_to(session):
    """Below a stop threshold at first, and ever farther from it."""
    low = solve_inverse(session.robot, [0.0, 0.038])
    assert low.margin < session.follower.settings.thresholds["margin"].stop
    said = begin_on_way_home(session, low.motors, last=low)
    assert said.endswith("to home at max_speed")
    assert len(commands_within(session, 0.1)) > 10


def test_commands_that_were_held_before_are_held_when_the_motors_are_measured(session):
    elsewhere = on_another_branch(session.robot)
    begin_on_way_home(session, elsewhere.motors, last=elsewhere)
    measured = solve_home(session.robot).motors + [0.1, 0.0]
    said = begin_on_way_home(session, measured, measured=True)
    assert said.endswith(f"to home at max_speed; {HELD}")
    assert commands_within(session, 0.1) == []


@pytest.mark.parametrize("session", ["planar_body"], indirect=True)
def test_a_motor_that_rests_at_its_stop_is_measured_on_either_side_of_it(session):
    """A nanoradian beyond was refused, with words about branches."""
    motors, stop = at(session).motors.copy(), session.robot.description.motors[1].limits.upper
    for beside in (1e-9, 0.9e-3, -1e-6):
        measured = motors + [0.0, stop + beside - motors[1], 0.0]
        begin_at_measured(session, measured)
        np.testing.assert_array_equal(at(session).motors[[0, 2]], motors[[0, 2]])
        assert at(session).motors[1] == min(stop, measured[1])
        np.testing.assert_array_equal(session.commands.newest, at(session).motors)
    before = at(session)
    with pytest.raises(CprError) as refused:
        begin_at_measured(session, motors + [0.0, stop + 0.002 - motors[1], 0.0])
    name = session.robot.motor_names[1]
    assert f"{name} is measured at {stop + 0.002:g} rad, beyond its range" in str(refused.value)
    assert "branch" not in str(refused.value)
    assert at(session) is before
