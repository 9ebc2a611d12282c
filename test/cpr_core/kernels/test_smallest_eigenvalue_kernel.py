# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Smallest eigenvalues of pencils shaped as robots are, against LAPACK on the whole matrices."""

import numpy as np
import pytest
from helpers.kernel_entry import entry
from helpers.whole_pencil import ROBOTS, WholePencil
from scipy import linalg

from cpr_core.kernels import smallest_eigenvalue_kernel
from cpr_core.kernels.pencil_kernel import Measure, is_diagonal


@entry
def smallest_eigenvalue(robot, pencil, free, guided):
    measure = Measure(pencil.gram, is_diagonal(pencil.gram), pencil.weights, 1.0, free)
    return smallest_eigenvalue_kernel.smallest_eigenvalue(pencil, measure, 0.0, guided)


def smallest(whole, free, guided=False):
    return smallest_eigenvalue(whole.kernel_arrays, whole.pencil, free, guided)


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_random_pencils_definite_or_not(name, free):
    rng, whole = np.random.default_rng(4), WholePencil(name)
    seen = set()
    for _ in range(40):
        whole.fill(rng)
        expected = linalg.eigvalsh(*whole.matrices(free))
        seen.add(expected[0] > 0.0)
        accuracy = 1e-10 * np.abs(expected).max()
        assert smallest(whole, free) == pytest.approx(expected[0], rel=1e-10, abs=accuracy)
    assert False in seen


@pytest.mark.parametrize("name", ROBOTS)
def test_whatever_vector_it_begins_with(name):
    """That of the matrix itself, and that of another one."""
    rng, whole = np.random.default_rng(8), WholePencil(name)
    for _ in range(20):
        whole.fill(rng)
        expected = linalg.eigvalsh(*whole.matrices(False))
        accuracy = 1e-10 * np.abs(expected).max()
        for _ in range(2):
            found = smallest(whole, False, guided=True)
            assert found == pytest.approx(expected[0], rel=1e-10, abs=accuracy)


@pytest.mark.parametrize("scale", [1.0, -1e7])
@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
def test_equal_and_nearly_equal_eigenvalues(gap, scale):
    """Legs that are the same but for a little, and a platform that does not see them."""
    whole = WholePencil("six_rfs")
    whole.fill(np.random.default_rng(2))
    legs = whole.pencil.blocks["lane"]
    for lane in range(whole.legs):
        legs[0, ..., lane] = legs[0, ..., 0]
        legs[0, 0, 0, lane] += gap * (lane == 3)
        whole.pencil.gram["lane"][0, ..., lane] = whole.pencil.gram["lane"][0, ..., 0]
    legs[0, :, whole.rows :] = 0.0
    whole.pencil.corner[:] = 50.0 * np.eye(6)
    legs[0, : whole.strains, : whole.strains, : whole.legs] *= scale
    expected = linalg.eigvalsh(*whole.matrices(True))
    assert expected[4] - expected[0] < abs(scale) * (2.0 * gap + 1e-12)
    assert smallest(whole, True) == pytest.approx(expected[0], abs=2e-11 * abs(scale))


@pytest.mark.parametrize("scale", [1e-4, 1e4, 1e7])
def test_however_large_they_are(scale):
    """Of far unstable robots too; what is found stays right to as many digits."""
    rng, whole = np.random.default_rng(6), WholePencil("six_rfs")
    for _ in range(20):
        whole.fill(rng)
        whole.pencil.blocks["lane"][0, ..., : whole.legs] *= scale
        whole.pencil.corner[:] *= scale
        expected = linalg.eigvalsh(*whole.matrices(True))
        accuracy = 1e-10 * np.abs(expected).max() + 2e-11
        assert smallest(whole, True) == pytest.approx(expected[0], rel=1e-10, abs=accuracy)


def test_zero_is_an_eigenvalue_as_any_other():
    whole = WholePencil("rfrfr")
    whole.fill(np.random.default_rng(5))
    first = linalg.eigvalsh(*whole.matrices(False))[0]
    blocks, mass = whole.pencil.blocks["lane"], whole.pencil.gram["lane"]
    blocks[0, : whole.strains, : whole.strains] -= first * mass[0]
    whole.pencil.corner[:] -= first * np.eye(whole.width)
    assert smallest(whole, False) == pytest.approx(0.0, abs=1e-11)
