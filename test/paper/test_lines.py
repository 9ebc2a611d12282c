"""Eigenvalues and conjugate points along the lines of Figs. 7 and 13; the sweeps of Figs. 6 and 12."""

import numpy as np
import pytest

from cpr_core import solve_inverse
from paper.cases import RFRFR
from paper.stability import line_of, workspace_of
from paper.sweep import sweep


def check(line, expected, marked):
    assert len(line.crossings) == len(expected)
    for crossing, value in zip(line.crossings, expected, strict=True):
        assert crossing.eigenvalue == pytest.approx(value, abs=1e-4)
        assert crossing.conjugate == pytest.approx(crossing.eigenvalue, abs=1e-4)
        assert (crossing.before, crossing.after) == (crossing.order, crossing.order + 1)
    for point in line.samples:
        assert len(point.conjugate) == point.index
        assert point.index == np.sum(point.eigenvalues < 0.0)
        assert (point.determinants.min() < 0.0) == (point.index > 0)
    assert len(line.marked) == len(line.places) == marked


def test_the_line_of_the_rfrfr_robot():
    calls = []
    line = line_of("rfrfr", 16, 12, lambda: calls.append(1))
    check(line, (0.035711, -0.057399), 5)
    assert len(calls) == len(line.samples) == 12
    assert line.crossings[0].five_modes == pytest.approx(0.01641, abs=1e-4)


@pytest.mark.slow
def test_the_line_of_the_six_rfs_robot():
    check(line_of("six_rfs", 12, 6, lambda: None), (0.167003,), 3)


def test_a_sweep_reaches_grid_points_on_the_branch():
    start = solve_inverse(RFRFR.robot(5), [0.0, 0.6])
    xs, ys = np.linspace(-0.2, 0.2, 5), np.linspace(0.4, 1.2, 9)
    reached = sweep(start, lambda x, y: (x, y), xs, ys)
    assert 20 < len(reached) < 45  # the rods are too short for the top of the grid
    for (i, j), there in reached.items():
        assert there.platform_position[:2] == pytest.approx([xs[i], ys[j]])
        direct = solve_inverse(start.robot, [xs[i], ys[j]], start=start)
        assert there.motors == pytest.approx(direct.motors, abs=1e-8)


def test_the_workspace_knows_where_it_is_unstable():
    workspace = workspace_of("rfrfr", 5, 0.1)
    reached = np.isfinite(workspace.index)
    assert 100 < reached.sum() < reached.size
    assert np.all((workspace.smallest[reached] < 0) == (workspace.index[reached] > 0))
    assert np.all(np.isnan(workspace.inverse_condition) == ~reached)
