# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the way down along a null space learns of its objective."""

import numpy as np
import pytest

from cpr_core.solving import descent


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_curvature_of_all_motors_is_that_along_the_directions_and_positive_across(count):
    """The null space turns on the way: what is flat across it would be divided by later."""
    random = np.random.default_rng(count)
    directions = np.linalg.qr(random.normal(size=(6, count)))[0]
    root = random.normal(size=(count, count))
    curvature = root @ root.T + np.eye(count)
    whole = descent._whole(curvature, directions)
    np.testing.assert_allclose(directions.T @ whole @ directions, curvature, rtol=1e-12)
    values = np.linalg.eigvalsh(whole)
    assert values[0] >= (1.0 - 1e-12) * np.linalg.eigvalsh(curvature)[0]
    assert values[-1] <= (1.0 + 1e-12) * np.linalg.eigvalsh(curvature)[-1]


def test_a_learnt_curvature_explains_how_the_slope_changed():
    random = np.random.default_rng(5)
    root = random.normal(size=(5, 5))
    exact = root @ root.T + 0.1 * np.eye(5)
    curvature = np.eye(5)
    for _ in range(4):
        moved = random.normal(size=5)
        curvature = descent._learnt(curvature, moved, exact @ moved)
        np.testing.assert_allclose(curvature @ moved, exact @ moved, rtol=1e-10)
        assert np.linalg.eigvalsh(curvature)[0] > 0.0
    assert descent._learnt(curvature, moved, -exact @ moved) is curvature  # no minimum that way
