# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The picture of a calibration: who reads across its panels reads of one parameter."""

from types import SimpleNamespace

import numpy as np

from cpr_core.drawing import calibration_plot


def test_parameters_have_one_order_and_what_is_not_determined_is_no_zero(monkeypatch, tmp_path):
    """They went up on the left and down on the right; no correlation was as white as one of 0."""
    figures = []
    monkeypatch.setattr(calibration_plot, "save_figure", lambda figure, _: figures.append(figure))
    unknown = np.nan
    calibration_plot.plot_calibration(
        SimpleNamespace(
            rows=(SimpleNamespace(residual=lambda size: [size, 2.0 * size]),),
            before=(3.0,),
            after=(0.1,),
            start=np.array([1.0, 0.0, 0.0]),
            values=np.array([1.0, 0.1, 0.2]),
            intervals=np.array([[unknown, unknown], [0.0, 0.2], [0.1, 0.3]]),
            parameters=("rod.young_modulus", "offset", "position"),
            correlations=np.array([[unknown] * 3, [unknown, 1, -1], [unknown, -1, 1]]),
            robot=SimpleNamespace(description=SimpleNamespace(name="robot")),
            fit=1.0,
        ),
        tmp_path / "picture.png",
    )
    changes, correlations = figures[0].axes[1:3]
    assert changes.yaxis_inverted() and correlations.yaxis_inverted()
    names = [label.get_text() for label in changes.get_yticklabels()]
    assert [name.split()[-1] for name in names] == ["1", "2", "3"]
    assert [label.get_text() for label in correlations.get_yticklabels()] == ["1", "2", "3"]
    told = [(text.get_text().strip(), text.get_position()[1]) for text in changes.texts]
    assert told == [("not determined", 0)]
    (bars,) = changes.containers[0].lines[2]
    ends = [segment[:, 0].tolist() for segment in bars.get_segments()]
    np.testing.assert_allclose(ends, [[0.0, 0.2], [0.1, 0.3]])
    residuals = {line.get_label(): line.get_ydata().tolist() for line in figures[0].axes[0].lines}
    assert residuals == {"before": [3.0, 6.0], "after": [0.1, 0.2]}
    grey = correlations.get_facecolor()
    assert grey[0] == grey[1] == grey[2] < 0.9
