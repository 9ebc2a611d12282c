# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Maps of workspaces: every cell is what a direct solve finds there."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from helpers.workspace_cases import (
    assert_same,
    content_of_rfrfr,
    just_beyond,
    rfrfr,
    six_rfs,
    small_grid,
    small_map,
)

from cpr_core import (
    InvalidRequest,
    NoInverseSolution,
    NonFiniteInput,
    bending_strains,
    kinemato_statics,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
)
from cpr_core.kernels.record_layout import INDEX_LOCKED
from cpr_core.lie import quaternion_from_rotation, roll_pitch_yaw, rotation_exp
from cpr_core.solving.limits import margins
from cpr_core.workspace import (
    EdgeState,
    flood,
    map_workspace,
    motor_grid,
    pose_grid,
    summary_of,
)
from cpr_core.workspace.cell_layout import BRANCH_SIGN
from cpr_core.workspace.cell_problem import cell_problem
from cpr_core.workspace.first_cell import signs_at_equilibrium


def test_cells_are_the_equilibria_of_direct_solves():
    found = small_map()
    cells = np.flatnonzero(found.reached)
    assert len(cells) > 80
    for cell in cells[::7].tolist():
        direct = solve_inverse(found.robot, found.place(cell), start=found.equilibrium(cell))
        np.testing.assert_allclose(found.motors[cell], direct.motors, atol=1e-8)
        np.testing.assert_allclose(found.cells.efforts[cell], direct.efforts, atol=1e-8)
        assert found.cells.energy[cell] == pytest.approx(direct.energy, rel=1e-9)
        np.testing.assert_allclose(found.cells.position[cell][:2], found.place(cell), atol=1e-12)


def test_walks_from_home_lead_to_the_same_cells():
    """Straight from home in the pose, not cell by cell: where nothing is in the way."""
    found = small_map()
    for place in ([0.3, 0.6], [-0.2, 0.4], [0.4, 0.3]):
        direct = solve_inverse(found.robot, place)
        cell = found.grid.nearest(np.array(place))
        np.testing.assert_allclose(found.motors[cell], direct.motors, atol=1e-8)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_rfs", "planar_body", "gough_stewart"])
def test_every_number_of_a_cell_is_that_of_scipy(name):
    robot = load_robot(name, modes=4)
    vary = {"z": [-0.02, 0.02], "roll": [-0.05, 0.05]} if name == "three_rfs" else None
    home = solve_home(robot)
    if vary is None:
        x, y = home.platform_position[:2]
        vary = {"x": [x - 0.01, x + 0.01], "y": [y - 0.01, y + 0.02]}
    else:
        vary["z"] = [home.platform_position[2] + dz for dz in vary["z"]]
    held = {}
    if name in ("six_rfs", "gough_stewart"):
        angles = roll_pitch_yaw(home.platform_rotation)
        held = dict(zip(("roll", "pitch", "yaw"), angles, strict=True))
        held["z"] = home.platform_position[2]
    if name == "planar_body":
        held["angle"] = roll_pitch_yaw(home.platform_rotation)[2]
    found = map_workspace(robot, pose_grid(robot, vary, held), workers=0)
    assert found.complete
    assert found.reached.sum() > 1
    for cell in np.flatnonzero(found.reached).tolist():
        equilibrium = found.equilibrium(cell)
        assert equilibrium.converged
        assert (found.index_locked[cell], found.index_free[cell]) == (
            equilibrium.spectrum_locked.index,
            equilibrium.spectrum_free.index,
        )
        values = equilibrium.spectrum_locked.eigenvalues
        np.testing.assert_allclose(
            found.cells.eigenvalues[cell], values[:4], rtol=1e-9, atol=1e-12 * values[-1]
        )
        assert found.inverse_condition_number[cell] == pytest.approx(
            equilibrium.spectrum_locked.inverse_condition_number, rel=1e-7
        )
        model = kinemato_statics(equilibrium)
        for problem, margin in (
            ("forward", found.forward_margin),
            ("inverse", found.inverse_margin),
        ):
            exact = model.singularity(problem).smallest
            assert margin[cell] == pytest.approx(exact, rel=1e-4), problem
        np.testing.assert_allclose(found.strains[cell], bending_strains(equilibrium), rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "axes"),
    [
        ("three_rfr_hubs", "x y"),
        ("three_rfr_hubs", "motor1 motor2"),
        ("three_rfs", "z roll"),
        ("three_rfs", "motor1 motor2"),
        ("six_rfs", "x roll"),
    ],
)
def test_without_a_potential_the_branch_is_told_as_by_walks(name, axes):
    robot = load_robot(name, modes=3)
    home = solve_home(robot)
    names = (*robot.motor_names, *"xyz", "roll", "pitch", "yaw", "angle")
    angles = roll_pitch_yaw(home.platform_rotation)
    angles = (*angles, angles[2])
    at = dict(zip(names, [*home.motors, *home.platform_position, *angles], strict=True))
    vary = {axis: [at[axis] - 0.01, at[axis] + 0.02] for axis in axes.split()}
    others = {"six_rfs": ("y", "z", "pitch", "yaw"), "three_rfr_hubs": ("angle",)}.get(name, ())
    held = None if "motor1" in vary else {axis: at[axis] for axis in others}
    grid = (motor_grid if "motor1" in vary else pose_grid)(robot, vary, held, resolution=0.01)
    turning = {"wrench_body": [0, 0, 0, 0.02, 0.01, 0]}
    loads = robot.default_loads.with_(
        **turning if robot.planar else {"wrench_world": [0.001, 0.002, 0.001, 0, 0, 0]}
    )
    assert not robot.has_potential(loads)
    found = map_workspace(robot, grid, loads=loads, workers=0, tolerance=0.0)
    assert found.reached.sum() > 8
    problem = cell_problem(robot, loads, grid)
    for cell in np.flatnonzero(found.reached).tolist():
        expected = signs_at_equilibrium(problem, found.equilibrium(cell))
        assert expected[BRANCH_SIGN] != 0
        np.testing.assert_array_equal(found.cells.signs[cell], expected)


def test_both_indices_are_those_of_the_cells_where_they_differ():
    found = small_map()
    differ = np.flatnonzero(found.reached & (found.index_locked != found.index_free))
    assert len(differ) > 10
    for cell in differ[::10].tolist():
        spectra = found.equilibrium(cell).spectrum_locked, found.equilibrium(cell).spectrum_free
        indices = tuple(spectrum.index for spectrum in spectra)
        assert (found.index_locked[cell], found.index_free[cell]) == indices


def test_two_routes_agree_except_across_a_cut():
    """Around the unstable zone of the RFRFR robot lies another sheet: the map says where they meet."""
    found = small_map()
    assert len(found.disagreements) == 0
    robot = rfrfr(12)
    wide = map_workspace(
        robot, pose_grid(robot, {"x": [-0.9, 0.9], "y": [-1.0, 1.0]}, resolution=0.05), tolerance=0
    )
    assert len(wide.disagreements) > 0
    for cell, other in wide.disagreements[::10].tolist():
        walked = solve_inverse(robot, wide.place(other), start=wide.equilibrium(cell))
        assert np.abs(walked.motors - wide.motors[other]).max() > 1e-4
    passed = np.argwhere(wide.cells.edges == EdgeState.PASSED)
    for cell, column in passed[:: len(passed) // 20].tolist():
        other = wide.grid.neighbours[cell, column]
        walked = solve_inverse(robot, wide.place(other), start=wide.equilibrium(cell))
        np.testing.assert_allclose(walked.motors, wide.motors[other], atol=1e-6)


def test_cells_that_are_not_reached_have_no_solution_from_their_neighbours():
    found = small_map()
    blocked = np.argwhere(found.cells.edges == EdgeState.BLOCKED)
    assert len(blocked)
    for cell, column in blocked.tolist():
        other = found.grid.neighbours[cell, column]
        with pytest.raises(NoInverseSolution) as failure:
            beyond = just_beyond(found, cell, other)
            solve_inverse(found.robot, beyond, start=found.equilibrium(cell))
        reached = found.cells.edge_fraction[cell, column]
        assert reached == pytest.approx(failure.value.fraction, abs=2e-3)


def test_a_slice_of_the_pose_space_by_euler_angles():
    robot = six_rfs()
    held = {"z": 0.635, "phi": np.pi / 8, "theta": np.pi / 3}
    grid = pose_grid(robot, {"x": [-0.4, -0.3], "y": [0.0, 0.2]}, held, resolution=0.05)
    found = map_workspace(robot, grid)
    assert found.reached.all()
    turn = rotation_exp([0, 0, np.pi / 8]) @ rotation_exp([0, np.pi / 3, 0])
    quaternion = quaternion_from_rotation(turn)
    for cell in range(0, grid.size, 4):
        np.testing.assert_allclose(found.cells.rotation[cell], turn, atol=1e-12)
        x, y = found.place(cell)
        direct = solve_inverse(robot, [x, y, 0.635, *quaternion], start=found.equilibrium(cell))
        np.testing.assert_allclose(found.motors[cell], direct.motors, atol=1e-8)


def test_orientations_vary_in_three_dimensions_and_askew():
    robot = six_rfs()
    x, y, z = solve_home(robot).platform_position
    grid = pose_grid(
        robot,
        {"s": [-0.02, 0.0, 0.03], "yaw": [-0.1, 0.1], "z": [z, z + 0.02]},
        {"x": x, "y": y},
        directions={"s": {"x": 0.6, "y": 0.8}},
    )
    found = map_workspace(robot, grid)
    assert found.grid.shape == (3, 2, 2)
    assert found.reached.all()
    for cell in range(grid.size):
        s, yaw, height = found.place(cell)
        position = [x + 0.6 * s, y + 0.8 * s, height]
        np.testing.assert_allclose(found.cells.position[cell], position, atol=1e-12)
        np.testing.assert_allclose(
            found.cells.rotation[cell], rotation_exp([0, 0, yaw]), atol=1e-12
        )


def test_a_map_of_motors():
    robot = rfrfr()
    grid = motor_grid(robot, {"motor1": [2.3, 2.9], "motor2": [0.2, 0.8]}, resolution=0.1)
    found = map_workspace(robot, grid)
    assert found.reached.all()
    for cell in range(0, grid.size, 5):
        direct = solve_forward(robot, found.place(cell))
        np.testing.assert_allclose(found.cells.position[cell], direct.platform_position, atol=1e-8)
        assert found.index_locked[cell] == direct.index_locked


def test_a_map_of_motors_ends_where_the_robot_snaps():
    robot = rfrfr()
    grid = motor_grid(robot, {"motor1": [2.0, 7.0], "motor2": [0.5, 3.5]}, resolution=0.25)
    found = map_workspace(robot, grid)
    assert 0 < found.reached.sum() < grid.size
    assert np.all(found.index_locked[found.reached] == 0)
    ends = {border.kind: border for border in found.borders}["singularity"]
    assert len(ends.points)


def test_a_long_step_is_divided():
    robot = rfrfr()
    grid = motor_grid(robot, {"motor1": [1.2, 2.59], "motor2": [0.55, 1.9]})
    found = map_workspace(robot, grid)
    assert found.reached.sum() > 1
    for cell in np.flatnonzero(found.reached).tolist():
        direct = solve_forward(robot, found.place(cell))
        np.testing.assert_allclose(found.motors[cell], direct.motors, atol=1e-12)
        np.testing.assert_allclose(found.cells.position[cell], direct.platform_position, atol=1e-8)


def test_limits_are_flags_and_have_borders():
    description = content_of_rfrfr()
    description["rod"]["yield_strain"] = 0.007
    for leg in description["legs"]:
        leg["motor"]["limits"] = {"position": [-2.5, 5.5], "effort": 1.1}
    robot = load_robot(description)
    found = map_workspace(robot, small_grid())
    assert found.limit_names == (
        "motor_limit motor1",
        "effort_limit motor1",
        "motor_limit motor2",
        "effort_limit motor2",
        "strain_limit leg1",
        "strain_limit leg2",
    )
    np.testing.assert_array_equal(found.reached, small_map().reached)
    np.testing.assert_array_equal(np.isnan(found.strains), np.stack([~found.reached] * 2, axis=1))
    for cell in np.flatnonzero(found.reached)[::9].tolist():
        left = margins(found.equilibrium(cell))
        expected = [*left[:8].reshape(4, 2).min(axis=1), *left[8:]]
        np.testing.assert_allclose(found.limit_margins[cell], expected, atol=1e-12)
    assert 0 < found.within_limits.sum() < found.reached.sum()
    assert found.usable.sum() <= found.within_limits.sum()
    beyond = np.sum((found.limit_margins < 0.0).any(axis=1) & found.reached)
    assert summary_of(found, 0.0).beyond_limits == beyond
    assert summary_of(small_map(), 0.0).beyond_limits == 0  # cells that are not reached are none
    border = {border.kind: border for border in found.borders}["limits"]
    assert len(border.points)
    for point, (cell, _) in zip(border.points, border.cells, strict=True):
        without = small_map().equilibrium(cell)
        at_border = solve_inverse(small_map().robot, point, start=without)
        assert np.abs(margins(replace(at_border, robot=robot))).min() < 1e-3


@pytest.mark.parametrize("cell", [1.5, 0.0, "0", True, None, [0], -1, 117, 10**9])
def test_what_is_no_cell_of_a_map_is_refused(cell):
    found = small_map()
    assert found.grid.size == 117
    for question in (found.place, found.equilibrium):
        with pytest.raises(InvalidRequest, match="cell: expected"):
            question(cell)


def test_cells_that_were_not_reached_have_a_place_but_no_equilibrium():
    found = small_map()
    cell = int(np.flatnonzero(~found.reached)[0])
    assert found.grid.nearest(found.place(cell)) == cell
    with pytest.raises(InvalidRequest, match=f"cell: expected a cell that was reached, got {cell}"):
        found.equilibrium(cell)


def test_thresholds_of_a_summary_are_looked_at():
    for threshold in (-1e-9, "0", None):
        with pytest.raises(InvalidRequest, match="threshold: expected"):
            summary_of(small_map(), threshold)
    with pytest.raises(NonFiniteInput, match="threshold: expected a finite number, got nan"):
        summary_of(small_map(), np.nan)


def test_a_map_says_in_a_line_how_far_it_is():
    found = small_map()
    start = f"<WorkspaceMap of rfrfr: {found.reached.sum()} of 117 cells reached, "
    assert repr(found) == f"{start}complete>"
    assert repr(replace(found, expanded=0)) == f"{start}not complete>"


def test_usable_cells_hang_together_and_are_stable():
    found = small_map()
    assert found.usable[found.first]
    assert np.all(found.index_locked[found.usable] == 0)
    assert found.usable.sum() < found.reached.sum()
    assert not np.any(found.within_limits & ~found.reached)
    # Behind a wall of unstable cells none is, be they stable.
    column = np.unravel_index(np.arange(found.grid.size), found.grid.shape)[0]
    wall = column[found.first] - 1
    signs = found.cells.signs.copy()
    signs[(column == wall) & found.reached, INDEX_LOCKED] = 1
    walled = replace(found, cells=replace(found.cells, signs=signs))
    assert np.any(found.usable & (column < wall))
    np.testing.assert_array_equal(walled.usable, found.usable & (column > wall))


def test_a_map_that_is_cancelled_is_unfinished():
    stop = threading.Event()
    found = map_workspace(
        rfrfr(),
        small_grid(),
        progress=lambda state: state.done > 20 and stop.set(),
        cancelled=stop.is_set,
    )
    assert not found.complete
    assert found.borders == ()
    assert 20 < found.expanded < small_map().expanded


def test_progress_counts_cells():
    states = []
    found = map_workspace(rfrfr(), small_grid(), progress=states.append)
    done = [state.done for state in states]
    assert done == sorted(done)
    assert (states[-1].done, states[-1].total) == (found.reached.sum(), found.grid.size)
    assert_same(found, small_map())


def test_guesses_save_steps_and_change_nothing_else(monkeypatch):
    found = small_map()
    guesses = flood.Flood._guesses
    monkeypatch.setattr(
        flood.Flood, "_guesses", lambda *arguments: np.full_like(guesses(*arguments), np.nan)
    )
    plain = map_workspace(rfrfr(), small_grid(), workers=0)
    np.testing.assert_array_equal(found.reached, plain.reached)
    np.testing.assert_array_equal(found.cells.signs, plain.cells.signs)
    np.testing.assert_array_equal(found.cells.edges, plain.cells.edges)
    np.testing.assert_allclose(found.cells.state, plain.cells.state, atol=1e-7)
    assert plain.borders
    for border, plain_border in zip(found.borders, plain.borders, strict=True):
        np.testing.assert_allclose(border.points, plain_border.points, atol=1e-5)


def test_rotations_stay_rotations_far_from_the_start():
    robot = six_rfs()
    home = dict(zip(robot.motor_names, solve_home(robot).motors, strict=True))
    axes = {name: [home[name] - 0.02, home[name] + 0.3] for name in ("motor1", "motor2")}
    found = map_workspace(robot, motor_grid(robot, axes, resolution=0.008), tolerance=0.0)
    assert found.reached.sum() > 1000
    turns = found.cells.rotation[found.reached]
    away = np.transpose(turns, (0, 2, 1)) @ turns - np.eye(3)
    assert np.abs(away).max() < 1e-12


@pytest.mark.parametrize(
    ("other", "says"), [("six_rfs", "of what this robot controls"), ("delta", "controls, got x, y")]
)
def test_grids_of_poses_that_another_robot_has_are_refused(other, says):
    grid = pose_grid(rfrfr(), {"x": [-0.1, 0.1], "y": [0.2, 0.4]}, resolution=0.1)
    with pytest.raises(InvalidRequest, match=says):
        map_workspace(load_robot(other), grid)
