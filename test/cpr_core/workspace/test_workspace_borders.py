# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Borders of maps: where direct solves find them, and where the design of the method has them."""

import numpy as np
import pytest
from helpers.workspace_cases import just_beyond, rfrfr, small_grid, small_map
from scipy.optimize import brentq

from cpr_core import InvalidRequest, NoInverseSolution, load_robot, solve_inverse
from cpr_core.workspace import EdgeState, map_workspace, pose_grid
from cpr_core.workspace.borders import Border


def of_kind(found, kind):
    return {border.kind: border for border in found.borders}[kind]


def on_line(border, x):
    """Points on a line x of the grid, with the indices below and above, from below."""
    selected = np.abs(border.points[:, 0] - x) < 1e-9
    order = np.argsort(border.points[selected, 1])
    columns = (border.points[selected, 1], border.before[selected], border.after[selected])
    return list(zip(*[column[order].tolist() for column in columns], strict=True))


def test_the_locked_crossings_of_the_rfrfr_robot():
    """Continuous rods on x = 0: 0.0357109 and -0.0573989 (docs/stability.md)."""
    robot = rfrfr(16)
    grid = pose_grid(robot, {"x": [-0.02, 0.02], "y": [-0.1, 0.1]}, resolution=0.01)
    found = map_workspace(robot, grid, start=solve_inverse(robot, [0.0, 0.1]))
    low, high = on_line(of_kind(found, "stability"), 0.0)
    assert low[0] == pytest.approx(-0.0573989, abs=2e-5)
    assert high[0] == pytest.approx(0.0357109, abs=2e-5)
    assert (low[1:], high[1:]) == ((2, 1), (1, 0))


def test_the_locked_crossing_of_the_six_rfs_slice():
    """x = -0.4 of the slice z = 0.635 m, ZYZ (pi/8, pi/3, 0): y = 0.16700."""
    robot = load_robot("six_rfs", modes=8)
    held = {"z": 0.635, "phi": np.pi / 8, "theta": np.pi / 3}
    grid = pose_grid(robot, {"x": [-0.41, -0.39], "y": [0.14, 0.19]}, held, resolution=0.01)
    found = map_workspace(robot, grid)
    ((y, before, after),) = on_line(of_kind(found, "stability"), -0.4)
    assert y == pytest.approx(0.16700, abs=5e-5)
    assert (before, after) == (0, 1)


@pytest.mark.parametrize("kind", ["stability", "stability_free"])
def test_points_are_where_an_eigenvalue_vanishes(kind):
    found, border = small_map(), of_kind(small_map(), kind)
    single = np.abs(border.before - border.after) == 1
    assert np.any(single)
    for number in np.flatnonzero(single).tolist():
        cell, other = border.cells[number]
        exact = _crossing(
            found, kind, cell, other, min(border.before[number], border.after[number])
        )
        np.testing.assert_allclose(border.points[number], exact, atol=1.1e-5)


def _crossing(found, kind, cell, other, number):
    """Where the eigenvalue of a number vanishes between two cells, by direct solves."""
    first, last, start = found.place(cell), found.place(other), found.equilibrium(cell)

    def eigenvalue(fraction):
        equilibrium = solve_inverse(found.robot, first + fraction * (last - first), start=start)
        spectrum = equilibrium.spectrum_locked if kind == "stability" else equilibrium.spectrum_free
        return spectrum.eigenvalues[number]

    return first + brentq(eigenvalue, 0.0, 1.0, xtol=1e-9) * (last - first)


def test_the_branch_ends_at_the_singular_border():
    found = small_map()
    border = of_kind(found, "singularity")
    assert len(border.points)
    for point, (cell, other) in zip(border.points, border.cells, strict=True):
        first, last = found.place(cell), just_beyond(found, cell, other)
        with pytest.raises(NoInverseSolution) as failure:
            solve_inverse(found.robot, last, start=found.equilibrium(cell))
        exact = first + failure.value.fraction * (last - first)
        np.testing.assert_allclose(point, exact, atol=1e-4)


def test_the_singular_border_crosses_the_ways_that_a_branch_ends_on():
    """All of them but those that are passed the other way."""
    robot = rfrfr(3)
    grid = pose_grid(robot, {"x": [-0.6, 0.6], "y": [-0.6, 0.7]}, resolution=0.1)
    found = map_workspace(robot, grid, workers=0)
    ways = {
        (cell, int(grid.neighbours[cell, column])): state
        for (cell, column), state in np.ndenumerate(found.cells.edges)
    }
    expected = {
        way
        for way, state in ways.items()
        if state in (EdgeState.BLOCKED, EdgeState.FLIPPED) and ways[way[::-1]] != EdgeState.PASSED
    }
    border = of_kind(found, "singularity")
    assert {(cell, other) for cell, other in border.cells.tolist()} == expected
    assert len(border.cells) == len(expected) > 10


def test_borders_converge_when_the_grid_is_refined_twice():
    """Points are exact on every grid; lines between them come nearer to the points of the finest."""
    robot = rfrfr(8)
    start = solve_inverse(robot, [0.0, 0.3])
    borders = []
    for resolution in (0.08, 0.04, 0.02):
        grid = pose_grid(robot, {"x": [-0.4, 0.4], "y": [-0.16, 0.24]}, resolution=resolution)
        borders.append(of_kind(map_workspace(robot, grid, start=start), "stability"))
    fine = borders[-1]
    outer = np.minimum(fine.before, fine.after) == 0
    points = fine.points[outer & (fine.points[:, 1] > -0.08)]
    assert len(points) > 20
    coarse, middle = (np.mean(_distances(points, border)) for border in borders[:2])
    assert middle < 0.5 * coarse
    assert middle < 1e-3


def _distances(points, border):
    """Distance of points from the nearest line of a border."""
    first, last = border.points[border.segments[:, 0]], border.points[border.segments[:, 1]]
    along = last - first
    from_first = points[:, None] - first
    length = np.maximum(np.sum(along**2, axis=1), 1e-30)
    fraction = np.clip(np.sum(from_first * along, axis=2) / length, 0.0, 1.0)
    return np.linalg.norm(from_first - fraction[..., None] * along, axis=2).min(axis=1)


def test_the_tolerance_is_kept():
    rough = map_workspace(rfrfr(), small_grid(), tolerance=1e-2)
    fine = map_workspace(rfrfr(), small_grid(), tolerance=1e-7)
    for kind in ("stability", "stability_free"):
        rough_border, fine_border = of_kind(rough, kind), of_kind(fine, kind)
        np.testing.assert_array_equal(rough_border.cells, fine_border.cells)
        assert np.abs(rough_border.points - fine_border.points).max() < 1e-2
        np.testing.assert_allclose(of_kind(small_map(), kind).points, fine_border.points, atol=1e-5)
    # Finer than numbers are: the same, and it ends.
    finest = map_workspace(rfrfr(), small_grid(), tolerance=1e-17)
    for kind in ("stability", "stability_free"):
        fine_border, finest_border = of_kind(fine, kind), of_kind(finest, kind)
        np.testing.assert_allclose(fine_border.points, finest_border.points, rtol=0.0, atol=2e-7)
    with pytest.raises(InvalidRequest, match="tolerance"):
        map_workspace(rfrfr(), small_grid(), tolerance=-1.0)


def test_lines_go_through_all_points():
    border = of_kind(small_map(), "singularity")
    lines = border.polylines()
    assert sum(len(line) - 1 for line in lines) == len(border.segments) > 0
    for line in lines:
        assert np.linalg.norm(np.diff(line, axis=0), axis=1).max() < 0.1 * np.sqrt(2) + 1e-9


def test_an_open_line_is_one_from_end_to_end_wherever_its_points_are_numbered():
    points, none = np.array([[1.0, 0.0], [0.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), np.zeros(0, int)
    border = Border("singularity", points, none, none, none, np.array([[1, 0], [2, 0], [3, 2]]))
    (line,) = border.polylines()
    np.testing.assert_array_equal(line[:, 0], [0.0, 1.0, 2.0, 3.0])


def test_a_closed_line_ends_where_it_begins():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [5.0, 5.0], [6.0, 5.0]])
    none = np.zeros(6, np.int64)
    segments = np.array([[0, 1], [2, 1], [2, 3], [3, 0], [4, 5]])
    border = Border("stability", points, np.zeros((6, 2), np.int64), none, none, segments)
    lines = sorted(border.polylines(), key=len)
    assert [len(line) for line in lines] == [2, 5]
    np.testing.assert_array_equal(lines[1][0], lines[1][-1])
