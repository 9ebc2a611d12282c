# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Lines of a robot: their colours, and the pieces they are drawn as."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from cpr_core.drawing.robot_lines import segments, shades


@pytest.mark.parametrize(
    ("fraction", "color"),
    [(0.0, (0, 0, 1)), (0.5, (0, 1, 0)), (1.0, (1, 0, 0)), (-3.0, (0, 0, 1)), (7.0, (1, 0, 0))],
)
def test_shades_go_from_blue_over_green_to_red(fraction, color):
    assert_array_equal(shades(np.array([fraction])), [color])


@pytest.mark.parametrize("counts", [(), (0,), (1,), (2,), (24, 3, 2), (1, 5, 0, 2), (0, 5)])
def test_pieces_join_neighbours_of_a_line_and_no_two_lines(counts):
    lines = [np.random.default_rng(count).normal(size=(count, 3)) for count in counts]
    expected = [[line[k], line[k + 1]] for line in lines for k in range(len(line) - 1)]
    assert_array_equal(segments(*lines), np.reshape(expected, (-1, 2, 3)))
