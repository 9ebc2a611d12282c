"""Smallest eigenvalues of arrow-shaped pencils, against LAPACK on the whole matrices."""

import numpy as np
import pytest
from scipy import linalg

from cpr_core.pencil_kernel import smallest_eigenvalue

SIZES, WIDTH, EXTENT = np.array([4, 7, 0, 5]), 3, 8


def packed(whole):
    """Legs and corner of a symmetric arrow-shaped matrix."""
    legs = np.zeros((len(SIZES), EXTENT, EXTENT + WIDTH))
    inner = SIZES.sum()
    for leg, (start, size) in enumerate(zip(np.cumsum(SIZES) - SIZES, SIZES, strict=True)):
        span = slice(start, start + size)
        legs[leg, :size, :size] = np.triu(whole[span, span])
        legs[leg, :size, EXTENT:] = whole[span, inner:]
    return legs, np.triu(whole[inner:, inner:])


def arrow(rng):
    """A random symmetric matrix in which a leg touches itself and the platform."""
    inner = SIZES.sum()
    whole = np.zeros((inner + WIDTH, inner + WIDTH))
    whole[inner:] = rng.standard_normal((WIDTH, inner + WIDTH))
    for start, size in zip(np.cumsum(SIZES) - SIZES, SIZES, strict=True):
        whole[start : start + size, start : start + size] = rng.standard_normal((size, size))
    return whole + whole.T


def smallest(hessian, mass, scale=1.0):
    (legs, corner), (masses, corner_mass) = packed(hessian), packed(mass)
    return smallest_eigenvalue(legs, masses, corner, corner_mass, SIZES, scale, 1.0)


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("shift", [0.0, 30.0])
def test_random_pencils_definite_or_not(seed, shift):
    rng = np.random.default_rng(seed)
    mass = 0.05 * arrow(rng)
    mass += np.eye(len(mass)) * (1.0 - min(0.0, linalg.eigvalsh(mass)[0]))
    hessian = arrow(rng) + shift * mass
    expected = linalg.eigvalsh(hessian, mass)
    found = smallest(hessian, mass)
    assert found == pytest.approx(expected[0], rel=1e-10, abs=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
def test_equal_and_nearly_equal_eigenvalues(gap):
    """Several legs that are the same, and a platform that does not see them."""
    size = SIZES.sum() + WIDTH
    hessian, identity = np.diag(2.0 + 0.1 * np.arange(size)), np.eye(size)
    for number, place in enumerate((0, 5, 12, size - 1)):
        hessian[place, place] = 1.0 + gap * (number != 2)
    assert smallest(hessian, identity) == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_the_unit_does_not_matter(scale):
    rng = np.random.default_rng(3)
    hessian = arrow(rng)
    expected = linalg.eigvalsh(hessian)[0]
    found = smallest(scale * hessian, np.eye(len(hessian)), scale)
    assert found == pytest.approx(scale * expected, rel=1e-11)


def test_zero_is_an_eigenvalue_as_any_other():
    rng = np.random.default_rng(5)
    whole = arrow(rng)
    whole -= linalg.eigvalsh(whole)[0] * np.eye(len(whole))
    assert smallest(whole, np.eye(len(whole))) == pytest.approx(0.0, abs=1e-11)
