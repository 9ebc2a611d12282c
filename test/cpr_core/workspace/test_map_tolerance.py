# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the borders of a map are refined to: it is complete only then, and they are not lost."""

import itertools

import numpy as np
import pytest
from helpers.workspace_cases import assert_same, rfrfr, small_grid, small_map

from cpr_core import load_robot
from cpr_core.workspace import EdgeState, map_workspace, pose_grid
from cpr_core.workspace.store import as_dataset, read_map
from cpr_core.workspace.summary import summary_of


def cancelled_while_refining(file, tolerance=1e-5):
    """The map of a file gone on with, cancelled as soon as all cells are done."""
    explored, asked = file.exists(), 0

    def look(state):
        nonlocal explored
        explored = state.done == state.reached

    def enough():
        nonlocal asked
        asked += 1
        return explored and asked > 1  # first when it is seen whether the map is of this branch

    return map_workspace(
        rfrfr(),
        small_grid(),
        workers=0,
        file=file,
        tolerance=tolerance,
        progress=look,
        cancelled=enough,
    )


def test_a_map_without_the_borders_that_were_asked_for_is_not_complete(tmp_path):
    file = tmp_path / "map.nc"
    found = cancelled_while_refining(file)
    assert found.explored and not found.borders
    assert not found.complete
    assert not read_map(file, rfrfr()).complete
    assert not summary_of(found, 1e-4).complete
    assert_same(map_workspace(rfrfr(), small_grid(), workers=0, file=file), small_map())
    assert read_map(file, rfrfr()).complete


def test_a_map_without_borders_is_complete_if_none_were_asked_for(tmp_path):
    found = cancelled_while_refining(tmp_path / "map.nc", tolerance=0.0)
    assert found.complete and not found.borders


def as_written(file):
    """What changes when a file is written, and not when it is read."""
    return file.stat().st_ino, file.stat().st_mtime_ns


def test_borders_are_not_lost(tmp_path):
    """Whatever tolerance a map is gone on with, and whether it is cancelled: finer or as they were."""
    file = tmp_path / "map.nc"
    coarse = map_workspace(rfrfr(), small_grid(), workers=0, file=file, tolerance=1e-2)
    before = as_written(file)
    for tolerance in (0.0, 1e-1, 1e-2):
        again = map_workspace(rfrfr(), small_grid(), workers=0, file=file, tolerance=tolerance)
        assert_same(again, coarse)
        assert as_written(file) == before, "a map that is complete is not written again"

    early = map_workspace(
        rfrfr(), small_grid(), workers=0, file=file, tolerance=1e-5, cancelled=lambda: True
    )
    assert_same(early, coarse)
    assert not early.complete and as_written(file) == before
    assert_same(cancelled_while_refining(file), coarse)
    left = read_map(file, rfrfr())
    assert_same(left, coarse)
    assert not left.complete and left.refined_to == 1e-2
    again = map_workspace(rfrfr(), small_grid(), workers=0, file=file, tolerance=1e-2)
    assert again.complete
    assert read_map(file, rfrfr()).complete

    finer = map_workspace(rfrfr(), small_grid(), workers=0, file=file)
    assert finer.refined_to == read_map(file, rfrfr()).refined_to == 1e-5
    for border, other in zip(finer.borders, small_map().borders, strict=True):
        np.testing.assert_allclose(border.points, other.points, rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_ends_of_branches_are_as_exact_as_asked_in_a_map_that_was_explored_coarsely(
    tmp_path, tolerance
):
    """Every rod of the RFRFR robot is a metre long, and straight where its workspace ends."""
    file = tmp_path / "map.nc"
    map_workspace(rfrfr(), small_grid(), workers=0, file=file, tolerance=5e-2)
    found = map_workspace(rfrfr(), small_grid(), workers=0, file=file, tolerance=tolerance)
    assert found.complete and found.refined(tolerance)
    border = next(border for border in found.borders if border.kind == "singularity")
    bases = np.array([leg.base_position[:2] for leg in rfrfr().description.legs])
    reach = np.linalg.norm(border.points[:, None] - bases, axis=2).max(axis=1)
    assert len(reach)
    # Along the axes, to which the border is oblique, points are no nearer to it than across it.
    np.testing.assert_allclose(reach, rfrfr().description.legs[0].rod.length, atol=tolerance)
    directly = map_workspace(rfrfr(), small_grid(), workers=0, tolerance=tolerance)
    assert_same(found, directly)


def test_borders_of_fewer_cells_are_refined_again_whatever_is_asked_for(tmp_path):
    """Finer steps led to more cells: cancelled there, the map was complete with the borders it had."""
    file, robot = tmp_path / "map.nc", load_robot("two_rods")
    grid = pose_grid(robot, {"x": (-0.5, 0.5), "y": (-0.2, 0.7)}, resolution=0.1)
    coarse = map_workspace(robot, grid, workers=0, file=file, tolerance=0.03)
    more = False
    for patience in range(1, 20):  # until it is cancelled with cells to be left
        asked = itertools.count(1)
        left = map_workspace(
            robot,
            grid,
            workers=0,
            file=file,
            tolerance=1e-3,
            cancelled=lambda asked=asked, patience=patience: next(asked) > patience,
        )
        more = left.reached.sum() > coarse.reached.sum()
        if more:
            break
    assert more and not left.explored
    found = map_workspace(robot, grid, workers=0, file=file, tolerance=0.03)
    assert found.complete
    passed = np.argwhere(found.cells.edges == EdgeState.PASSED)
    ways = {(cell, found.grid.neighbours[cell, column]) for cell, column in passed.tolist()}
    ends = next(border for border in found.borders if border.kind == "singularity")
    assert not ways & set(map(tuple, ends.cells.tolist()))


def test_files_that_do_not_say_what_their_borders_were_refined_to_are_read(tmp_path):
    file = tmp_path / "map.nc"
    old = as_dataset(small_map())
    del old.attrs["tolerance"], old.attrs["refined_to"]
    old.to_netcdf(file, engine="scipy")
    found = read_map(file, rfrfr())
    assert_same(found, small_map())
    assert found.complete and found.refined_to == np.inf
    assert_same(cancelled_while_refining(file), small_map())
    assert_same(map_workspace(rfrfr(), small_grid(), workers=0, file=file), small_map())
    assert read_map(file, rfrfr()).refined_to == 1e-5
