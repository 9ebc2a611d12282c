# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pictures of paths."""

import numpy as np

from cpr_core import load_robot, trace
from cpr_core.drawing import path_plots


def test_a_path_that_was_stopped_is_drawn_up_to_where(monkeypatch, tmp_path):
    """Its curves ended at the last point before: the smallest eigenvalue well above zero at a fold."""
    figures = []
    monkeypatch.setattr(path_plots, "save_figure", lambda figure, _: figures.append(figure))
    found = trace(load_robot("rfrfr"), motors=[50.0, 0.55])
    assert found.stopped.kind == "fold" and found.fractions[-1] < found.stopped.fraction
    path_plots.plot_trace(found, tmp_path / "picture.png")
    motors, eigenvalues = figures[0].axes[2:4]
    assert motors.lines[0].get_xdata()[-1] == found.stopped.fraction
    assert motors.lines[0].get_ydata()[-1] == found.last.motors[0]
    smallest = eigenvalues.lines[0].get_ydata()
    assert abs(smallest[-1]) < 1e-3 * abs(smallest[0])
    assert len(motors.lines[0].get_xdata()) == len(found.equilibria) + 1
    reached = trace(load_robot("rfrfr"), motors=[2.6, 0.56], points=5)
    path_plots.plot_trace(reached, tmp_path / "picture.png")
    np.testing.assert_array_equal(figures[1].axes[2].lines[0].get_xdata(), reached.fractions)
