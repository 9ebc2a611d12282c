# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What people try first: names for robots, values at the prompt, whether it is stable, one more load."""

import numpy as np
import pytest

from cpr_core import (
    InvalidRequest,
    Loads,
    bending_strains,
    find_equilibria,
    kinemato_statics,
    leg_shapes,
    load_robot,
    restore_equilibrium,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    spectrum,
    trace,
    trace_through,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.workspace import map_workspace, motor_grid, pose_grid

PUBLIC = {
    "solve_forward": lambda robot: solve_forward(robot, [2.59, 0.55]),
    "solve_forward_by_effort": lambda robot: solve_forward_by_effort(robot, [0.0, 0.0]),
    "solve_inverse": lambda robot: solve_inverse(robot, [0.0, 0.8]),
    "trace": lambda robot: trace(robot, motors=[2.6, 0.6]),
    "trace_through": lambda robot: trace_through(robot, motors=[[2.6, 0.6]]),
    "find_equilibria": lambda robot: find_equilibria(robot, [2.6, 0.6]),
    "restore_equilibrium": lambda robot: restore_equilibrium(
        robot, Loads.none(), [], [], [], np.eye(3), [0, 0, 0]
    ),
    "pose_grid": lambda robot: pose_grid(robot, {"x": [0.0, 0.1]}),
    "motor_grid": lambda robot: motor_grid(robot, {"motor1": [0.0, 0.1]}),
    "map_workspace": lambda robot: map_workspace(
        robot, pose_grid(load_robot("rfrfr"), {"x": [0.0, 0.1], "y": [0.8, 0.9]})
    ),
}


@pytest.mark.parametrize("name", PUBLIC)
def test_a_name_in_place_of_a_robot_is_refused_with_how_to_load_one(name):
    with pytest.raises(InvalidRequest, match=r"robot: .*load_robot\('rfrfr'\) loads one"):
        PUBLIC[name]("rfrfr")
    with pytest.raises(InvalidRequest, match=r"robot: expected a Robot, got 3\.5"):
        PUBLIC[name](3.5)


def test_values_are_shown_in_a_line():
    robot = load_robot("six_rfs")
    found = trace(robot, motors=solve_home(robot).motors + 0.01, points=3)
    loads = robot.default_loads.with_(gravity=[0, 0, -9.81])
    for value in (
        robot,
        robot.description,
        robot.description.legs[0],
        solve_home(robot),
        found,
        loads,
    ):
        assert len(repr(value)) < 200
        assert "\n" not in repr(value)
    assert "six_rfs" in repr(robot)
    assert "3 equilibria" in repr(found)
    assert repr(loads) == "<Loads: gravity=[0.0, 0.0, -9.81]>"


@pytest.mark.parametrize("name", shipped_robots())
def test_an_equilibrium_says_whether_it_is_stable_and_where_it_is(name):
    home = solve_home(load_robot(name))
    assert home.stable
    assert home.margin == pytest.approx(spectrum(home).margin)
    assert kinemato_statics(home).jacobian.shape == (
        len(home.robot.platform_axes),
        home.robot.motor_count,
    )
    np.testing.assert_allclose(solve_inverse(home.robot, home.pose).motors, home.motors, atol=1e-9)


def test_no_stability_is_read_from_energy_where_there_is_none():
    robot = load_robot("six_rfs")
    loads = Loads.none().with_(wrench_body=[0, 0, 0, 0.01, 0, 0])
    loaded = solve_forward(robot, solve_home(robot).motors, loads=loads)
    assert loaded.index_locked == 0
    assert not loaded.stable


def test_loads_of_the_description_stay_where_others_are_added():
    robot = load_robot("three_rfs")
    wrench = [0, 0, 0, 0.1, 0, 0]
    loads = robot.default_loads.with_(wrench_world=wrench)
    np.testing.assert_array_equal(loads.gravity, [0, 0, -9.81])
    np.testing.assert_array_equal(loads.wrench_world, wrench)
    kept = solve_forward(robot, solve_home(robot).motors, loads=loads)
    lost = solve_forward(
        robot, solve_home(robot).motors, loads=Loads.none().with_(wrench_world=wrench)
    )
    assert np.linalg.norm(kept.platform_position - lost.platform_position) > 1e-3


@pytest.mark.parametrize("ask", [solve_home, leg_shapes, bending_strains])
@pytest.mark.parametrize("given", ["six_rfs", 3.5])
def test_what_is_no_robot_and_no_equilibrium_is_named(ask, given):
    """A string ended in words about attributes."""
    with pytest.raises(InvalidRequest, match=r"expected an? (Robot|Equilibrium), got"):
        ask(given)
    if ask is not solve_home:
        with pytest.raises(InvalidRequest, match="expected an Equilibrium, got"):
            ask(load_robot("rfrfr"))


@pytest.mark.parametrize("values", [["1", "2"], [True, False], [1.0, None]])
def test_words_and_truth_values_are_no_motor_positions(values):
    with pytest.raises(InvalidRequest, match="motors: expected 2 numbers"):
        solve_forward(load_robot("rfrfr"), values)
