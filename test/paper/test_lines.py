# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Eigenvalues and conjugate points along the lines of Figs. 7 and 13; the maps of Figs. 6 and 12."""

import numpy as np
import pytest

from paper.stability import line_of, workspace_of


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


def test_the_workspace_is_mapped_with_its_borders():
    found = workspace_of("rfrfr", 5, 0.1)
    assert 100 < found.reached.sum() < found.grid.size
    assert found.complete
    unstable = found.index_locked[found.reached] > 0
    np.testing.assert_array_equal(found.cells.eigenvalues[found.reached, 0] < 0.0, unstable)
    border = next(candidate for candidate in found.borders if candidate.kind == "stability")
    on_line = border.points[np.abs(border.points[:, 0]) < 1e-12]
    assert np.abs(on_line[:, 1] - 0.01641).min() < 1e-4  # with 5 modes
