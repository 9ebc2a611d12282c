# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in somebody's hands, without a page."""

import numpy as np
import pytest
from helpers.drive import changed_robot
from helpers.shipped_steps import STEPS

import cpr_core
from cpr_core.drawing.robot_lines import equilibrium_lines
from cpr_core.lie import quaternion_from_rotation
from cpr_core.model.shape import Pose
from cpr_core.viewing import handled_robot
from cpr_core.viewing.handled_robot import HandledRobot
from cpr_core.viewing.refused import Asked, ghost_lines
from cpr_core.viewing.status_panel import status_text


class Clock:
    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture(scope="module")
def planar():
    return cpr_core.load_robot("rfrfr")


@pytest.fixture(scope="module")
def spatial():
    return cpr_core.load_robot("six_rfs")


def dragged(handled, way):
    equilibrium = handled.equilibrium
    return handled.move_platform(
        equilibrium.platform_position + way, equilibrium.platform_quaternion
    )


def test_motors_lead_where_the_forward_problem_does(spatial):
    handled = HandledRobot(spatial)
    motors = handled.equilibrium.motors + 0.1
    assert handled.move_motors(motors)
    expected = cpr_core.solve_forward(spatial, motors)
    np.testing.assert_allclose(
        handled.equilibrium.platform_position, expected.platform_position, rtol=0, atol=1e-10
    )
    assert handled.refused is None


@pytest.mark.parametrize("name", ["rfrfr", "planar_body", "three_prs", "six_rfs", "delta"])
def test_of_a_dragged_platform_the_controlled_coordinates_count(name):
    robot = cpr_core.load_robot(name)
    handled = HandledRobot(robot)
    before = handled.equilibrium.pose
    controlled = robot.description.controlled
    axis = next(number for number, letter in enumerate("xyz") if letter in controlled)
    assert dragged(handled, 0.01 * robot.mean_length * np.eye(3)[axis]), handled.refused.reason
    after = handled.equilibrium.pose
    assert after[0] == pytest.approx(before[0] + 0.01 * robot.mean_length, abs=1e-9)
    np.testing.assert_allclose(after[1:], before[1:], atol=1e-9)


def test_what_is_refused_leaves_the_robot_at_the_last_equilibrium_with_a_ghost(spatial):
    handled = HandledRobot(spatial)
    home = handled.equilibrium
    assert not dragged(handled, [0.6, 0.0, 0.0])
    assert handled.refused.kind == "fold"
    assert "not reached" in handled.refused.reason
    last = handled.equilibrium
    assert last.converged
    assert last.stable
    assert home.platform_position[0] < last.platform_position[0] < home.platform_position[0] + 0.6
    ghost = ghost_lines(last, handled.refused.asked)
    wanted = home.platform_position + [0.6, 0.0, 0.0]
    holds = np.array([leg.joint.position for leg in spatial.description.legs])
    middle = wanted + (holds @ home.platform_rotation.T).mean(axis=0)
    np.testing.assert_allclose(ghost.platform[:-1].mean(axis=0), middle, atol=1e-9)
    # From there the robot goes on: farther is refused again, back is not.
    assert not dragged(handled, [0.01, 0.0, 0.0])
    assert dragged(handled, [-0.05, 0.0, 0.0]), handled.refused.reason
    assert handled.refused is None


def test_the_ghost_of_motors_is_every_leg_where_its_motor_was_to_be(planar):
    handled = HandledRobot(planar)
    assert not handled.move_motors(handled.equilibrium.motors + [4.0, -4.0])
    asked = handled.refused.asked
    ghost = ghost_lines(handled.equilibrium, asked)
    assert len(ghost.rods) == 2
    for leg, motor in zip(ghost.rods, asked.motors, strict=True):
        way = leg[1] - leg[0]
        assert np.cos(np.arctan2(way[1], way[0]) - motor) > 0.99


@pytest.mark.parametrize("name", ["planar_body", "six_rfs", "delta"])
def test_the_ghost_of_a_pose_is_the_platform_of_the_robot_that_is_there(name):
    robot = cpr_core.load_robot(name)
    home = cpr_core.solve_home(robot)
    reached = cpr_core.solve_forward(robot, home.motors + STEPS[name])
    there = Pose(reached.platform_rotation, reached.platform_position)
    ghost = ghost_lines(home, Asked(platform=there))
    assert ghost.rods == () and len(ghost.links) == 0  # nobody knows where they would be
    np.testing.assert_allclose(
        ghost.platform, equilibrium_lines(reached).platform, rtol=0, atol=1e-9 * robot.mean_length
    )


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (lambda robot: robot.move_motors([np.nan, 0.0]), "all finite"),
        (lambda robot: robot.move_motors([1e300, 0.0]), "looks like degrees"),
        (lambda robot: robot.move_motors([]), "expected 2 numbers"),
        (lambda robot: robot.move_motor(0, np.inf), "all finite"),
        (lambda robot: robot.move_pose([0.0, 1e300]), "looks like millimetres"),
        (lambda robot: robot.move_platform([0, np.nan, 0], [1, 0, 0, 0]), "all finite"),
        (lambda robot: robot.move_platform([0, 0.8, 0], [0, 0, 0, 0]), "unit"),
        (lambda robot: robot.push([1e300, 0.0, 0.0]), "not reached"),
        (lambda robot: robot.push([np.nan, 0.0, 0.0]), "all finite"),
        (lambda robot: robot.choose_modes(99), "at most 40"),
        (lambda robot: robot.choose_modes("many"), "whole number"),
    ],
)
def test_absurd_numbers_change_nothing_and_are_told(planar, asked, said):
    handled = HandledRobot(planar)
    home = handled.equilibrium
    assert not asked(handled)
    assert said in handled.words
    assert handled.refused.reason == handled.words
    assert handled.refused.kind.islower()
    assert handled.equilibrium is home
    assert not handled.undoable


def test_a_stable_robot_is_not_taken_past_the_loss_of_its_stability(planar):
    handled = HandledRobot(planar)
    for _ in range(60):
        handled.push(handled.force + [0.0, -0.5, 0.0])
        assert handled.equilibrium.index_locked == 0
        if handled.refused is not None:
            break
    assert handled.refused.kind in ("fold", "bifurcation", "stability")
    assert handled.equilibrium.margin < 0.05
    assert handled.undo()  # one gesture, its end refused
    assert not handled.undoable


def test_as_far_as_it_came_a_refused_request_is_undone_too(planar):
    handled = HandledRobot(planar)
    home = handled.equilibrium
    assert not handled.push([0.0, -20.0, 0.0])
    assert handled.equilibrium is not home
    assert handled.undo()
    assert handled.equilibrium is home


def test_gestures_are_undone_one_by_one(planar):
    clock = Clock()
    handled = HandledRobot(planar, clock=clock)
    home = handled.equilibrium
    for position in (2.6, 2.61, 2.62):
        clock.now += 0.1
        assert handled.move_motor(0, position)
    first = handled.equilibrium
    clock.now += 0.1
    assert handled.move_motor(1, 0.6)
    second = handled.equilibrium
    clock.now += 5.0
    assert handled.move_motor(1, 0.65)
    assert handled.undo()
    assert handled.equilibrium is second
    assert handled.undo()
    assert handled.equilibrium is first
    assert handled.undo()
    assert handled.equilibrium is home
    assert not handled.undo()
    assert handled.move_motor(0, 2.6)
    assert handled.undo()
    assert handled.move_motor(0, 2.7)  # at once, by the same hand: another gesture all the same
    assert handled.undo()
    assert handled.equilibrium is home
    other = cpr_core.solve_forward(planar, [2.7, 0.4])
    for _ in range(2):
        handled.take(other, "jumped")
        handled.take(home, "back")
    assert [handled.undo() for _ in range(5)] == [True, True, True, True, False]


def test_loads_gravity_and_home(planar):
    handled = HandledRobot(planar)
    home = handled.equilibrium
    assert handled.switch_gravity(True)
    np.testing.assert_array_equal(handled.equilibrium.loads.gravity, [0.0, -9.81, 0.0])
    assert handled.push([0.01, 0.0, 0.0])
    np.testing.assert_array_equal(handled.force, [0.01, 0.0, 0.0])
    np.testing.assert_array_equal(handled.equilibrium.motors, home.motors)
    assert handled.go_home() and handled.words == "at home"  # walked, its loads with it
    np.testing.assert_allclose(
        handled.equilibrium.platform_position, home.platform_position, atol=1e-10
    )
    assert not handled.has_gravity


def test_home_is_home_also_from_another_branch(planar):
    """It was called home at the motors of home, a metre away and unstable, with no way back."""
    home = cpr_core.solve_home(planar)
    found = cpr_core.find_equilibria(planar, home.motors)
    handled = HandledRobot(planar)
    others = [entry.equilibrium for entry in found if not entry.from_home]
    assert len(others) > 2
    for other in others:
        handled.take(other, "jumped")
        assert handled.go_home()
        assert handled.equilibrium is home
        away = np.linalg.norm(other.platform_position - home.platform_position)
        assert "at home, by a jump" in handled.words
        assert f"platform {away:.3g} m from home, index {other.index_locked}" in handled.words
        assert handled.undo()
        assert handled.equilibrium is other
    handled = HandledRobot(planar)
    assert handled.move_motors(home.motors + [0.1, 0.1]) and handled.go_home()
    assert handled.words == "at home"


@pytest.mark.parametrize("name", ["six_rfs", "three_rfs", "delta", "gough_stewart"])
def test_moments_act_in_space_too(name):
    """All were refused: they have no potential, so no energy says that the robot stays stable."""
    robot = cpr_core.load_robot(name)
    handled = HandledRobot(robot)
    home = handled.equilibrium
    loads = home.loads.with_(wrench_world=[0, 0, 1e-3, 0, 0, 0])
    assert handled.load(loads), handled.words
    assert status_text(handled).startswith("**energy does not decide (index 0)")
    expected = cpr_core.solve_forward(robot, home.motors, loads=loads)
    np.testing.assert_allclose(handled.equilibrium.state, expected.state, rtol=0.0, atol=1e-8)
    assert handled.push([0.0, 0.0, 1e-3])
    wrench = handled.equilibrium.loads.wrench_world
    np.testing.assert_array_equal(wrench, [0.0, 0.0, 1e-3, 0.0, 0.0, 1e-3])
    assert handled.push([0.0, 0.0, -1e-3])


def test_a_drag_is_undone_as_one_however_long_the_hand_rests(planar):
    clock = Clock()
    handled = HandledRobot(planar, clock=clock)
    home = handled.equilibrium
    for pause in (0.1, 5.0, 20.0):
        assert dragged(handled, [0.01, 0.0, 0.0])
        clock.now += pause
    handled.end_gesture()
    there = handled.equilibrium
    assert dragged(handled, [0.01, 0.0, 0.0])
    clock.now += 100.0  # it never said that it let go
    beyond = handled.equilibrium
    assert dragged(handled, [0.01, 0.0, 0.0])
    assert handled.undo()
    assert handled.equilibrium is beyond
    assert handled.undo()
    assert handled.equilibrium is there
    assert handled.undo()
    assert handled.equilibrium is home


def test_modes_are_another_robot_at_the_same_place(planar):
    handled = HandledRobot(planar)
    before = handled.equilibrium
    assert handled.choose_modes(9)
    assert handled.robot is not before.robot
    np.testing.assert_array_equal(handled.equilibrium.motors, before.motors)
    assert "9 modes" in handled.words
    with pytest.raises(cpr_core.InvalidRequest):
        handled.take(before, "")
    assert handled.undo()
    assert handled.equilibrium is before


def test_motors_that_are_held_are_held_with_other_modes_too():
    """They were let go: the next motion of the platform moved them."""
    robot = cpr_core.load_robot("four_rfr").holding([0])
    handled = HandledRobot(robot)
    assert handled.choose_modes(4)
    assert handled.robot.held_motors == (0,)
    held = handled.equilibrium.motors[0]
    assert handled.move_pose(handled.equilibrium.pose + [0.01, 0.0, 0.0])
    assert handled.equilibrium.motors[0] == held


def test_a_start_is_where_it_begins(planar):
    start = cpr_core.solve_forward(planar, [2.6, 0.6])
    handled = HandledRobot(planar, start)
    assert handled.equilibrium is start
    turned = quaternion_from_rotation(start.platform_rotation)
    assert handled.move_platform(start.platform_position, turned)


def test_gravity_is_that_of_the_description():
    """That of the earth is for robots that have none."""
    handled = HandledRobot(
        changed_robot("rfrfr", lambda content: content.update(gravity=[0.0, -3.0, 0.0]))
    )
    for on, expected in ((False, 0.0), (True, -3.0)):
        assert handled.switch_gravity(on)
        assert handled.has_gravity == on
        np.testing.assert_array_equal(handled.equilibrium.loads.gravity, [0.0, expected, 0.0])


def test_other_modes_bear_the_same_loads_and_say_how_far_that_is(planar):
    handled = HandledRobot(planar)
    assert handled.switch_gravity(True) and handled.push([0.05, 0.0, 0.0])
    before = handled.equilibrium
    assert handled.choose_modes(3)
    after = handled.equilibrium
    assert not after.loads.differences(before.loads)
    apart = 1e3 * np.linalg.norm(after.platform_position - before.platform_position)
    assert handled.words == f"3 modes: the platform is {apart:.3g} mm from where it was"


def test_from_another_branch_no_modes_are_chosen_but_motors_move_on(planar):
    """Of one that is unstable no stability can be lost."""
    home = cpr_core.solve_home(planar)
    found = cpr_core.find_equilibria(planar, home.motors)
    for stable in {entry.stable for entry in found if not entry.from_home}:
        other = next(e.equilibrium for e in found if not e.from_home and e.stable == stable)
        handled = HandledRobot(planar)
        handled.take(other, "jumped")
        assert not handled.choose_modes(9)
        assert handled.refused.kind == "branch" and "go home first" in handled.words
        assert handled.equilibrium is other
        assert handled.move_motors(home.motors + 1e-3), handled.words
        assert handled.equilibrium.stable == stable


def test_what_takes_too_long_can_be_asked_again(planar, monkeypatch):
    monkeypatch.setattr(handled_robot, "_TIME_LIMIT", 1e-9)
    handled = HandledRobot(planar)
    assert not handled.move_motors(handled.equilibrium.motors + 0.5)
    assert handled.words.startswith("not there in time, ask again to go on: ")


def test_a_pose_on_the_other_side_of_an_instability_is_not_walked_to(planar):
    handled = HandledRobot(planar)
    assert cpr_core.solve_inverse(planar, [0.0, -0.2], start=handled.equilibrium).index_locked > 0
    assert not handled.move_pose([0.0, -0.2])
    assert handled.equilibrium.stable and handled.undoable
    assert handled.refused.kind == "stability"


def test_a_hand_that_rests_for_more_than_a_second_begins_anew(planar):
    clock = Clock()
    handled = HandledRobot(planar, clock=clock)
    motors = handled.equilibrium.motors
    for number, pause in enumerate((0.0, 0.9, 1.1), 1):
        clock.now += pause
        assert handled.move_motor(0, motors[0] + 0.01 * number)
    assert handled.undo()
    assert handled.equilibrium.motors[0] == motors[0] + 0.02
    assert handled.undo() and not handled.undoable
