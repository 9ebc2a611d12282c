# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How many eigenvalues of pencils shaped as robots are lie below a shift, against LAPACK."""

import numpy as np
import pytest
from helpers.kernel_entry import entry
from helpers.whole_pencil import ROBOTS, WholePencil
from scipy import linalg

from cpr_core.kernels import pencil_kernel


@entry
def eliminate_pencil(robot, pencil, free, shift):
    measure = pencil_kernel.Measure(pencil.gram, False, pencil.weights, 1.0, free)
    return pencil_kernel.eliminate_pencil(pencil, measure, shift)


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_negative_pivots_count_the_eigenvalues_below(name, free):
    rng, whole = np.random.default_rng(4), WholePencil(name)
    for _ in range(40):
        whole.fill(rng)
        expected = linalg.eigvalsh(*whole.matrices(free))
        for shift in (-3.0, 0.5, expected[0] - 1e-6, expected[0] + 1e-6, 2.5):
            below = eliminate_pencil(whole.kernel_arrays, whole.pencil, free, shift)
            assert below == np.sum(expected < shift)
