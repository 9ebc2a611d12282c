# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of maps: what a field is, which cell is where, and what is red."""

import numpy as np
import pytest
from helpers.workspace_cases import small_map
from matplotlib.collections import QuadMesh

from cpr_core.drawing import map_plots
from cpr_core.drawing.map_plots import fields_of, plot_map


@pytest.fixture(scope="module")
def found():
    return small_map()


def meshes(found, monkeypatch, **options):
    """Numbers of what is drawn cell by cell, row by row of the picture."""
    figures = []
    monkeypatch.setattr(map_plots, "save_figure", lambda figure, file: figures.append(figure))
    plot_map(found, "picture.png", **options)
    drawn = [each for each in figures[0].axes[0].collections if isinstance(each, QuadMesh)]
    shape = found.grid.shape[::-1]
    return [np.ma.filled(each.get_array().astype(float), np.nan).reshape(shape) for each in drawn]


def test_every_cell_is_where_its_axes_say(found, monkeypatch):
    (drawn,) = meshes(found, monkeypatch, field="energy")
    np.testing.assert_array_equal(drawn.T.ravel(), found.cells.energy)
    assert np.unique(found.cells.energy[found.reached]).size > 4


def test_what_is_near_a_border_of_stability_is_red(found, monkeypatch):
    condition = found.inverse_condition_number
    threshold = float(np.nanmedian(condition))
    index, red = meshes(found, monkeypatch, threshold=threshold)
    np.testing.assert_array_equal(red.T.ravel() == 1.0, condition < threshold)
    np.testing.assert_array_equal(
        np.isfinite(index.T.ravel()), found.reached & ~(condition < threshold)
    )


def test_fields_are_what_they_are_called(found):
    fields, reached = fields_of(found), found.reached
    smallest = found.cells.eigenvalues[reached].min(axis=1)
    np.testing.assert_array_equal(fields["smallest_eigenvalue"][reached], smallest)
    for name in ("forward_margin", "inverse_margin", "inverse_condition_number"):
        np.testing.assert_array_equal(fields[name], getattr(found, name))
    assert not np.array_equal(fields["forward_margin"], fields["inverse_margin"])
