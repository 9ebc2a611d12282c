"""Borders of maps: where direct solves find them, and where the design of the method has them."""

import numpy as np
import pytest
from scipy.optimize import brentq
from workspace_cases import rfrfr, small_grid, small_map

from cpr_core import InvalidRequest, NoInverseSolution, load_robot, solve_inverse
from cpr_core.workspace import map_workspace, pose_grid
from cpr_core.workspace.borders import Border


def of_kind(found, kind):
    return {border.kind: border for border in found.borders}[kind]


def on_line(border, x):
    """Points on a line x of the grid, with the indices below and above, from below."""
    here = np.abs(border.points[:, 0] - x) < 1e-9
    order = np.argsort(border.points[here, 1])
    rows = zip(border.points[here, 1], border.before[here], border.after[here], strict=True)
    return [list(rows)[number] for number in order]


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


def test_points_are_where_an_eigenvalue_vanishes():
    found = small_map()
    for kind, name in (("stability", "spectrum_locked"), ("stability_free", "spectrum_free")):
        border = of_kind(found, kind)
        assert len(border.points)
        for point, (cell, other) in zip(border.points, border.cells, strict=True):
            first, last = found.place(cell), found.place(other)
            start = found.equilibrium(cell)

            def smallest(fraction, first=first, last=last, start=start, name=name):
                there = solve_inverse(found.robot, first + fraction * (last - first), start=start)
                values = getattr(there, name).eigenvalues
                return values[min(start_index, there_index)]

            start_index = found.equilibrium(cell).spectrum_locked.index
            there_index = found.equilibrium(other).spectrum_locked.index
            if kind == "stability_free":
                start_index = found.equilibrium(cell).spectrum_free.index
                there_index = found.equilibrium(other).spectrum_free.index
            if abs(start_index - there_index) != 1:
                continue
            exact = first + brentq(smallest, 0.0, 1.0, xtol=1e-9) * (last - first)
            np.testing.assert_allclose(point, exact, atol=1.1e-5)


def test_the_branch_ends_at_the_singular_border():
    found = small_map()
    border = of_kind(found, "singularity")
    assert len(border.points)
    for point, (cell, other) in zip(border.points, border.cells, strict=True):
        with pytest.raises(NoInverseSolution) as failure:
            solve_inverse(found.robot, found.place(other), start=found.equilibrium(cell))
        first, last = found.place(cell), found.place(other)
        exact = first + failure.value.fraction * (last - first)
        np.testing.assert_allclose(point, exact, atol=1e-4)


def test_borders_converge_when_the_grid_is_refined_twice():
    """Lines through points that are exact: the error of the area they enclose falls with the square."""
    areas = []
    robot = rfrfr(8)
    start = solve_inverse(robot, [0.0, 0.3])
    for resolution in (0.08, 0.04, 0.02):
        grid = pose_grid(robot, {"x": [-0.4, 0.4], "y": [-0.16, 0.24]}, resolution=resolution)
        found = map_workspace(robot, grid, start=start)
        areas.append(_unstable_area(found))
    first, second = abs(areas[1] - areas[0]), abs(areas[2] - areas[1])
    assert second < 0.5 * first
    assert second < 0.01 * areas[2]


def _unstable_area(found):
    """Area below the border from index 0 to 1 and above y = -0.1, by the trapezoidal rule over its points."""
    border = of_kind(found, "stability")
    upper = np.minimum(border.before, border.after) == 0
    area = 0.0
    for one, two in border.segments:
        if upper[one] and upper[two]:
            (x1, y1), (x2, y2) = border.points[one], border.points[two]
            if min(y1, y2) > -0.1:
                area += 0.5 * abs(x2 - x1) * (y1 + y2 + 0.2)
    return area


def test_the_tolerance_is_kept():
    rough = map_workspace(rfrfr(), small_grid(), tolerance=1e-2)
    fine = map_workspace(rfrfr(), small_grid(), tolerance=1e-7)
    for kind in ("stability", "stability_free"):
        one, two = of_kind(rough, kind), of_kind(fine, kind)
        np.testing.assert_array_equal(one.cells, two.cells)
        assert np.abs(one.points - two.points).max() < 1e-2
        np.testing.assert_allclose(of_kind(small_map(), kind).points, two.points, atol=1e-5)
    with pytest.raises(InvalidRequest, match="tolerance"):
        map_workspace(rfrfr(), small_grid(), tolerance=-1.0)


def test_lines_go_through_all_points():
    border = of_kind(small_map(), "singularity")
    lines = border.polylines()
    assert sum(len(line) - 1 for line in lines) == len(border.segments)
    for line in lines:
        assert np.linalg.norm(np.diff(line, axis=0), axis=1).max() < 0.1 * np.sqrt(2) + 1e-9


def test_a_closed_line_ends_where_it_begins():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [5.0, 5.0], [6.0, 5.0]])
    none = np.zeros(6, np.int64)
    segments = np.array([[0, 1], [2, 1], [2, 3], [3, 0], [4, 5]])
    border = Border("stability", points, np.zeros((6, 2), np.int64), none, none, segments)
    lines = sorted(border.polylines(), key=len)
    assert [len(line) for line in lines] == [2, 5]
    np.testing.assert_array_equal(lines[1][0], lines[1][-1])
