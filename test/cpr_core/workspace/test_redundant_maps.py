# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps of robots with more motors than controlled coordinates."""

import pickle
from concurrent.futures import Executor, Future

import numpy as np
import pytest

from cpr_core import (
    InvalidRequest,
    NoInverseSolution,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.workspace import map_workspace, motor_grid, pose_grid
from cpr_core.workspace.store import read_map


@pytest.fixture(scope="module")
def robot():
    return load_robot("four_rfr")


@pytest.fixture(scope="module")
def grid(robot):
    return pose_grid(
        robot, {"x": (-0.04, 0.04), "y": (-0.04, 0.04)}, {"angle": 0.0}, resolution=0.02
    )


class Elsewhere(Executor):
    """Tasks and results travel, as they do between processes and machines."""

    def submit(self, task, /, *arguments):
        task, arguments = pickle.loads(pickle.dumps((task, arguments)))
        future = Future()
        future.set_result(pickle.loads(pickle.dumps(task(*arguments))))
        return future


@pytest.mark.parametrize("objective", ["least_motion", "least_effort"])
def test_every_cell_is_the_best_from_the_start(robot, grid, objective):
    found = map_workspace(robot, grid, objective=objective, tolerance=0.0)
    assert found.complete and found.reached.all() and not len(found.disagreements)
    assert found.objective.startswith(objective)
    home = solve_home(robot)
    for cell in range(grid.size):
        pose = np.array([*grid.places(np.array([cell]))[0], 0.0])
        expected = solve_inverse(robot, pose, start=home, objective=objective)
        np.testing.assert_allclose(found.motors[cell], expected.motors, rtol=0.0, atol=1e-6)
        margin = kinemato_statics(found.equilibrium(cell)).singular_values("inverse")[0]
        assert found.inverse_margin[cell] == pytest.approx(margin, rel=1e-6)


def test_searches_that_end_beside_each_other_are_no_two_sheets(robot):
    """Of 80 ways between cells 20 disagreed, by what the search for the greatest margin leaves."""
    grid = pose_grid(robot, {"x": (-0.1, 0.1), "y": (-0.1, 0.1)}, {"angle": 0.1}, resolution=0.05)
    found = map_workspace(robot, grid, objective="greatest_margin", tolerance=0.0)
    assert found.reached.all() and found.usable.all() and not len(found.disagreements)
    home = solve_home(robot)
    for cell in range(0, grid.size, 4):
        pose = found.equilibrium(cell).pose
        expected = solve_inverse(robot, pose, start=home, objective="greatest_margin")
        np.testing.assert_allclose(found.motors[cell], expected.motors, rtol=0.0, atol=3e-4)
        assert found.equilibrium(cell).margin == pytest.approx(expected.margin, abs=1e-5)


def test_the_result_is_the_same_elsewhere_and_on_disk(robot, grid, tmp_path):
    file = tmp_path / "map.nc"
    found = map_workspace(robot, grid, tolerance=0.0, file=file)
    again = map_workspace(robot, grid, tolerance=0.0, executor=Elsewhere())
    np.testing.assert_allclose(again.cells.state, found.cells.state, rtol=0.0, atol=1e-12)
    stored = read_map(file, robot)
    np.testing.assert_array_equal(stored.motors, found.motors)
    assert stored.objective == found.objective
    with pytest.raises(InvalidRequest, match=r"is a map of least_motion from motors \(0\.4"):
        map_workspace(robot, grid, tolerance=0.0, file=file, objective="least_effort")


def test_motors_that_are_held_are_held_all_over_the_map(robot, grid):
    """They were free, and moved to where nothing was least."""
    held = robot.holding((0,))
    found = map_workspace(held, grid, tolerance=0, workers=0)
    home = solve_home(held)
    cells = np.flatnonzero(found.reached)
    assert len(cells) > 5
    assert np.abs(found.motors[cells, 0] - home.motors[0]).max() < 1e-12
    for cell in cells[::4]:
        wanted = solve_inverse(held, found.equilibrium(int(cell)).pose, start=home)
        np.testing.assert_allclose(found.motors[cell], wanted.motors, rtol=0, atol=1e-7)


@pytest.mark.parametrize("objective", ["least_motion", "least_effort"])
def test_poses_are_mapped_under_loads_without_a_potential_too(robot, grid, objective):
    """The determinant of a matrix that is not square was asked for."""
    home = solve_home(robot)
    loads = robot.default_loads.with_(wrench_body=[0, 0, 0, 0.05, 0.02, 0])
    start = solve_forward(robot, home.motors, start=home, loads=loads)
    found = map_workspace(robot, grid, start=start, objective=objective, tolerance=1e-3)
    assert found.complete and found.reached.all() and not found.usable.any()
    assert not len(found.disagreements)
    for cell in range(0, grid.size, 4):
        pose = found.equilibrium(cell).pose
        expected = solve_inverse(robot, pose, start=start, objective=objective)
        np.testing.assert_allclose(found.motors[cell], expected.motors, rtol=0.0, atol=1e-6)


def test_borders_are_refined_where_the_platform_goes_no_farther(robot):
    wide = pose_grid(robot, {"x": (0.0, 0.2), "y": (-0.02, 0.02)}, {"angle": 0.0}, resolution=0.04)
    found = map_workspace(robot, wide, tolerance=1e-4)
    singular = next(border for border in found.borders if border.kind == "singularity")
    assert not found.reached.all() and len(singular.points)
    for x, y in singular.points:
        assert solve_inverse(robot, [x - 2e-3, y, 0.0]).converged
        with pytest.raises(NoInverseSolution, match="singularity"):
            solve_inverse(robot, [x + 2e-3, y, 0.0])
    with pytest.raises(InvalidRequest, match="motors are imposed"):
        motors = {"motor1": (0.3, 0.5), "motor2": (0.3, 0.5)}
        map_workspace(robot, motor_grid(robot, motors, resolution=0.1), objective="least_effort")
