# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The largest eigenvalue of a tridiagonal matrix, and how far its vector reaches, against LAPACK."""

import numpy as np
import pytest
from helpers.kernel_entry import entry
from scipy import linalg

from cpr_core.kernels import eigenvalue_kernel

PRECISION = 1e-10


@entry
def largest(diagonal, beside, size):
    return eigenvalue_kernel.largest_of_tridiagonal(diagonal, beside, size, PRECISION)


@entry
def last_entry(diagonal, beside, size, value):
    return eigenvalue_kernel.last_entry(diagonal, beside, size, value)


def of_lanczos(values, rng):
    """A tridiagonal matrix with these eigenvalues; behind it what is not to be read."""
    first, size = rng.normal(size=len(values)), len(values)
    basis, _ = np.linalg.qr(np.vander(values / max(values), size, increasing=True) * first[:, None])
    matrix = basis.T @ np.diag(values) @ basis
    diagonal, beside = np.full(size + 2, np.nan), np.full(size + 2, np.nan)
    diagonal[:size], beside[: size - 1] = np.diag(matrix), np.diag(matrix, 1)
    return diagonal, beside


@pytest.mark.parametrize("size", [1, 2, 3, 5, 12])
@pytest.mark.parametrize("spread", [1.01, 10.0, 1e8])
def test_the_largest_one_is_that_of_lapack(size, spread):
    rng = np.random.default_rng(size)
    for scale in (1e-9, 1.0, 1e12):
        values = scale * np.geomspace(1.0, spread, size) * rng.uniform(1.0, 1.001, size)
        diagonal, beside = of_lanczos(values, rng)
        expected, vectors = linalg.eigh_tridiagonal(diagonal[:size], beside[: size - 1])
        found = largest(diagonal, beside, size)
        assert found == pytest.approx(expected[-1], rel=2.0 * PRECISION)
        last = last_entry(diagonal, beside, size, expected[-1])
        assert last == pytest.approx(abs(vectors[-1, -1]), rel=1e-4, abs=1e-7)


def test_the_largest_one_of_what_is_not_coupled_is_met():
    for diagonal in ([3.0, 1.0, 2.0], [1.0, 2.0, 2.0], [0.0, 0.0, 0.0], [5.0]):
        count = len(diagonal)
        assert largest(np.array(diagonal), np.zeros(count), count) == max(diagonal)
