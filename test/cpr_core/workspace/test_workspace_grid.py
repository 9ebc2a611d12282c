# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Grids of maps: what is refused, and how."""

import numpy as np
import pytest
from helpers.doubts import DEGREES
from helpers.workspace_cases import content_of_rfrfr, rfrfr, six_rfs

from cpr_core import (
    InvalidRequest,
    NoInverseSolution,
    NonFiniteInput,
    load_robot,
    solve_home,
    solve_inverse,
)
from cpr_core.workspace import map_workspace, motor_grid, pose_grid
from cpr_core.workspace.first_cell import held_elsewhere

AXES = {"x": [0.0, 1.0], "y": [0.0, 1.0]}
MOTORS = {"motor1": [2.0, 3.0], "motor2": [0.0, 1.0]}


@pytest.mark.parametrize(
    ("vary", "held", "options", "text"),
    [
        ({"x": [0, 1]}, {}, {}, "at least two axes, got 1; for a line there is trace"),
        ({"x": [0, 1], "z": [0, 1]}, {}, {}, "out of x, y, got 'z'"),
        (AXES, {"x": 0.5}, {}, "x is both an axis and held"),
        ({"x": [1, 0], "y": [0, 1]}, {}, {}, "x: expected at least two increasing numbers"),
        ({"x": [1, 0], "y": [0, 1]}, {}, {"resolution": 0.1}, "x: expected the first and a larger"),
        ({"x": ["a", 1], "y": [0, 1]}, {}, {"resolution": 0.1}, "x: expected a list of numbers"),
        (AXES, {}, {"resolution": 0.0}, "x: expected a positive resolution"),
        (AXES, {}, {"resolution": 1e-9}, "too many"),
        (AXES, {}, {"resolution": 1e-5}, "expected at most"),
        (
            {"x": [0, 1], "s": [0, 1]},
            {},
            {"directions": {"s": {"x": 2.0}}},
            "axes in independent directions",
        ),
        (AXES, {}, {"directions": {"x": "y"}}, "directions of x: expected values by name, got 'y'"),
        (AXES, {}, {"directions": "x"}, "directions: expected values by name, got 'x'"),
        (AXES, {}, {"resolution": {"X": 0.1, "y": 0.2}}, "resolution: expected x or y, got 'X'"),
        (AXES, {}, {"resolution": "fine"}, "x: resolution: expected a number, got 'fine'"),
        (AXES, ["z"], {}, r"held: expected values by name, got \['z'\]"),
        ("xy", {}, {}, "vary: expected values by name, got 'xy'"),
        ({"x": [[0, 1]], "y": [0, 1]}, {}, {}, "x: expected a list of numbers"),
        (
            {"x": [0, 1], "y": 0.5},
            {},
            {},
            r"y: expected a list of numbers, got 0\.5; held=\{'y': 0\.5\} holds it there$",
        ),
        ({"x": [0, 1], "y": np.float64(2)}, {}, {}, r"got .*2\.0.*; held=\{'y': 2\.0\} holds it"),
    ],
)
def test_bad_grids_are_refused(vary, held, options, text):
    with pytest.raises(InvalidRequest, match=text):
        pose_grid(rfrfr(), vary, held, **options)


@pytest.mark.parametrize(
    ("vary", "held", "directions"),
    [("motors", None, None), (MOTORS, 3.0, None), (MOTORS, None, {"motor1": "motor2"})],
)
def test_motors_are_given_by_name(vary, held, directions):
    with pytest.raises(InvalidRequest, match="expected values by name"):
        motor_grid(rfrfr(), vary, held, directions=directions)


def test_numbers_have_to_be_finite():
    with pytest.raises(NonFiniteInput, match="x"):
        pose_grid(rfrfr(), {"x": [0, np.nan], "y": [0, 1]})
    with pytest.raises(NonFiniteInput, match="z is inf"):
        pose_grid(six_rfs(), AXES, {"z": np.inf})
    with pytest.raises(InvalidRequest, match=r"z: expected a .*number, got '1'"):
        pose_grid(six_rfs(), AXES, {"z": "1"})


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"workers": -1}, "workers: expected at least 0, got -1"),
        ({"tolerance": "a"}, r"tolerance: expected a .*number, got 'a'"),
        ({"tolerance": -1.0}, "tolerance: expected a positive number or 0, got -1"),
        ({"executor": 3}, "executor: expected an Executor, got 3"),
        ({"checkpoint_every": -1.0}, "checkpoint_every: expected a time of at least 0 s, got -1"),
    ],
)
def test_options_of_a_map_are_looked_at(options, text):
    with pytest.raises(InvalidRequest, match=text):
        map_workspace(rfrfr(), pose_grid(rfrfr(), AXES, resolution=0.5), **options)


def test_what_is_no_grid_is_refused():
    with pytest.raises(InvalidRequest, match="grid: expected a Grid, got None"):
        map_workspace(rfrfr(), None)


def test_orientations_are_given_in_one_way():
    with pytest.raises(InvalidRequest, match="got some of both"):
        pose_grid(six_rfs(), AXES, {"phi": 0.1, "roll": 0.2})


@pytest.mark.parametrize(
    ("name", "vary", "held", "text"),
    [
        ("planar_body", {"x": [-0.1, 0.1], "angle": [-30.0, 30.0]}, {}, "angle at -30"),
        ("planar_body", AXES, {"angle": 90.0}, "angle at 90"),
        ("three_rfs", {"z": [0.7, 0.75], "roll": [0.0, 20.0]}, {}, "roll at 20"),
        ("six_rfs", {"phi": [0.0, 360.0], "theta": [0.0, 1.0]}, {"z": 0.7}, "phi at 360"),
        ("six_rfs", {"phi": [-2 * np.pi, 2 * np.pi], "theta": [0.0, 1.0]}, {"z": 0.7}, None),
    ],
)
def test_angles_in_degrees_are_refused(name, vary, held, text):
    """They were mapped whole turns less."""
    robot = load_robot(name)
    if text is None:
        assert pose_grid(robot, vary, held).shape == (2, 2)
        return
    with pytest.raises(InvalidRequest, match=f"{text} {DEGREES}, expected radians"):
        pose_grid(robot, vary, held)


@pytest.mark.parametrize(
    ("name", "axes", "key"),
    [
        ("delta", "x y", "none"),
        ("six_rfs", "x y", "zyz"),
        ("six_rfs", "x roll", "roll_pitch_yaw"),
        ("three_rfs", "z roll", "single_angles"),
        ("planar_body", "x angle", "planar"),
    ],
)
def test_ways_to_give_an_orientation_are_called_as_files_have_them(name, axes, key):
    vary = {axis: [0.0, 0.1] for axis in axes.split()}
    assert pose_grid(load_robot(name), vary).orientation == key


def test_motors_are_named():
    with pytest.raises(InvalidRequest, match="out of motor1, motor2, got 'motor3'"):
        motor_grid(rfrfr(), {"motor1": [0, 1], "motor3": [0, 1]})
    grid = motor_grid(six_rfs(), {"motor1": [5, 6], "motor4": [5, 6]}, {"motor2": 5.5})
    home = solve_home(six_rfs()).motors
    np.testing.assert_allclose(grid.origin, [0, 5.5, home[2], 0, home[4], home[5]])
    with pytest.raises(InvalidRequest, match="this robot's motors"):
        map_workspace(rfrfr(), grid)


def test_a_robot_without_inverse_problem_is_mapped_by_its_motors():
    description = content_of_rfrfr()
    description["controlled"] = []
    third = description["legs"][0] | {"base": {"position": [-0.1, 0, 0], "tangent": [1, 0, 0]}}
    description["legs"].append(third)
    description["home"]["motors"].append(2.5)
    robot = load_robot(description)
    with pytest.raises(InvalidRequest, match="map its motors instead"):
        pose_grid(robot, AXES)
    found = map_workspace(robot, motor_grid(robot, {"motor1": [2.5, 2.6], "motor3": [2.4, 2.5]}))
    assert found.reached.all()
    assert np.all(np.isnan(found.inverse_margin))


def test_a_grid_that_is_not_reached_says_so():
    grid = pose_grid(rfrfr(), {"x": [5.0, 5.1], "y": [5.0, 5.1]})
    with pytest.raises(NoInverseSolution, match=r"none of \d+ cells of the grid is reached"):
        map_workspace(rfrfr(), grid)


def test_a_grid_that_is_not_reached_names_what_it_holds_elsewhere():
    """Coordinates that nobody named are held at 0: far from home, without a word."""
    robot = load_robot("planar_body")
    turned = solve_inverse(robot, [0.0, 0.0, -0.8])
    axes = {"x": [5.0, 5.1], "y": [5.0, 5.1]}
    for held, told in (
        ({}, "angle, held at 0 as what is not named is, is -0.8 rad at the start"),
        ({"angle": 1.2}, "angle, held at 1.2, is -0.8 rad at the start"),
        ({"angle": 2.0 * np.pi - 0.8}, ""),
    ):
        with pytest.raises(NoInverseSolution, match="none of") as caught:
            map_workspace(robot, pose_grid(robot, axes, held), start=turned)
        assert str(caught.value).endswith(f"move the grid{told and '; '}{told}")


def test_what_a_grid_of_motors_or_of_turned_platforms_holds_elsewhere_is_named():
    home = solve_home(six_rfs())
    motors = motor_grid(six_rfs(), {"motor1": [0, 1], "motor2": [0, 1]}, {"motor3": 5.0})
    assert held_elsewhere(home, motors) == "motor3, held at 5, is 5.86 rad at the start"
    home = solve_home(load_robot("six_rus"))
    axes = {"x": [0, 1], "y": [0, 1]}
    for angles, told in (
        ({}, ()),  # home is not turned: phi and psi mean nothing there, and may be anything
        ({"theta": 0.4}, ("theta",)),
        ({"roll": 0.0, "pitch": 0.2}, ("pitch",)),
    ):
        grid = pose_grid(home.robot, axes, {"z": home.platform_position[2], **angles})
        words = held_elsewhere(home, grid)
        assert [part.split(",")[0] for part in words.split("; ") if part] == list(told)


def test_a_resolution_is_kept_or_bettered():
    grid = pose_grid(rfrfr(), {"x": [0.0, 0.25], "y": [0.0, 0.3]}, resolution=0.1)
    assert grid.shape == (4, 4)
    assert np.all(grid.steps <= 0.1 + 1e-15)
    assert [values[-1] for values in grid.values] == [0.25, 0.3]


def test_a_resolution_that_divides_an_axis_is_kept_whatever_rounding_says():
    for cells in range(2, 40):
        for step in (0.1, 0.3, 0.7):
            grid = pose_grid(
                rfrfr(), {"x": [0.0, cells * step], "y": [-step, step]}, resolution=step
            )
            assert grid.shape == (cells + 1, 3)


def test_neighbours_know_each_other():
    grid = pose_grid(rfrfr(), AXES, resolution=0.25)
    cell, column = np.nonzero(grid.neighbours >= 0)
    other = grid.neighbours[cell, column]
    np.testing.assert_array_equal(grid.neighbours[other, column ^ 1], cell)
    moved = np.abs(grid.places(other) - grid.places(cell)).sum(axis=1)
    np.testing.assert_allclose(moved, 0.25)


def test_the_cell_nearest_to_the_place_of_a_cell_is_that_cell():
    grid = pose_grid(rfrfr(), {"x": [0.0, 0.3, 0.4], "y": [-1.0, 0.0, 2.0, 2.5]})
    for cell, place in enumerate(grid.places(np.arange(grid.size))):
        assert grid.nearest(place) == grid.nearest(place.tolist()) == cell


@pytest.mark.parametrize(
    ("question", "value"),
    [
        *(("nearest", value) for value in ([0], [0, np.nan], [0, 0, 0], [[0, 0]], "word", None)),
        *(("places", value) for value in ([-1], [9], [0.5], [True], [[0]], 0, "word", None)),
        *(
            (question, value)
            for question in ("coordinates", "kernel_coordinates")
            for value in ([0, 0.7], [[0]], [[0, np.nan]], [[0, 1], [0]], [["a", "b"]], "word", None)
        ),
    ],
)
def test_places_and_cells_that_a_grid_cannot_have_are_refused(question, value):
    grid = pose_grid(rfrfr(), AXES, resolution=0.5)
    assert grid.size == 9
    with pytest.raises(InvalidRequest, match="expected"):
        getattr(grid, question)(value)


def test_a_pitch_beyond_a_quarter_turn_is_refused_where_it_is_controlled_alone():
    """Cells had another pitch than their labels said, and were usable."""
    robot = load_robot("three_rfs")
    z = float(solve_home(robot).pose[0])
    for vary, held in (
        ({"pitch": [0.0, 1.6], "roll": [0.0, 0.1]}, {"z": z}),
        ({"z": [z, z + 0.1], "roll": [0.0, 0.1]}, {"pitch": -1.6}),
    ):
        with pytest.raises(InvalidRequest, match=r"a pitch of at most pi/2 rad, got -?1\.6"):
            pose_grid(robot, vary, held)
    pose_grid(robot, {"pitch": [0.0, 0.5 * np.pi], "roll": [0.0, 2.0]}, {"z": z})
    whole = {"pitch": [0.0, 1.6], "roll": [0.0, 0.1]}
    place = dict(zip("xyz", solve_home(six_rfs()).platform_position, strict=True))
    pose_grid(six_rfs(), whole, place | {"yaw": 0.0})


def test_directions_of_no_axis_are_refused():
    with pytest.raises(InvalidRequest, match=r"directions: expected .*got 'unused'"):
        pose_grid(rfrfr(), AXES, directions={"unused": {"x": 1.0}})


def test_angles_are_looked_at_where_several_axes_turn_the_platform():
    turned = {"s": {"phi": 1.0, "x": 0.01}, "t": {"phi": -1.0, "y": 0.01}}
    for ends, refused in (([-5.0, 0.0], True), ([0.0, 5.0], False)):
        vary = {"s": [0.0, 5.0], "t": ends}
        if refused:
            with pytest.raises(InvalidRequest, match="phi at 10 "):
                pose_grid(six_rfs(), vary, {"z": 0.8}, directions=turned)
        else:
            assert pose_grid(six_rfs(), vary, {"z": 0.8}, directions=turned).size == 4


def test_the_nearest_cell_is_nearer_than_all_others():
    values = {"x": [-0.5, -0.1, 0.0, 0.4], "y": [0.1, 0.2, 0.7]}
    grid, random = pose_grid(rfrfr(), values), np.random.default_rng(5)
    places = grid.places(np.arange(grid.size))
    for place in random.uniform(-1.0, 1.0, (30, 2)):
        assert grid.nearest(place) == np.linalg.norm(places - place, axis=1).argmin()
