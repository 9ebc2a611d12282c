# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shape functions against their definitions in numpy and scipy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import special
from scipy.interpolate import BSpline

from cpr_core.errors import CprError
from cpr_core.rods.quadrature import rod_grid
from cpr_core.rods.rod import StrainModes
from cpr_core.rods.strain_basis import STRAIN_BASES, BSplines, Chebyshev, Legendre, Monomials

SIGMA = np.concatenate([[0.0, 1.0, 0.5], np.random.default_rng(1).uniform(0.0, 1.0, 40)])
POLYNOMIALS = {
    Legendre: lambda k, sigma: special.eval_legendre(k, 2.0 * sigma - 1.0),
    Chebyshev: lambda k, sigma: np.cos(k * np.arccos(2.0 * sigma - 1.0)),
    Monomials: lambda k, sigma: sigma**k,
}
SPLINES = [
    BSplines(degree=0, knots=(0.3, 0.7)),
    BSplines(degree=1, knots=(0.5,)),
    BSplines(degree=2, knots=(0.25, 0.5, 0.75)),
    BSplines(degree=3, knots=()),
    BSplines(degree=3, knots=(0.5,)),
    BSplines(degree=3, knots=(0.5, 0.5)),
    BSplines(degree=4, knots=(0.1, 0.9)),
]


def mode_count(basis):
    return len(basis.knots) + basis.degree + 1


@pytest.mark.parametrize("kind", POLYNOMIALS)
@pytest.mark.parametrize("modes", [1, 2, 5, 12])
def test_polynomials_are_the_first_of_their_family(kind, modes):
    expected = np.column_stack([POLYNOMIALS[kind](k, SIGMA) for k in range(modes)])
    found = kind().values(SIGMA, modes)
    assert found.shape == (len(SIGMA), modes)
    assert_allclose(found, expected, rtol=0.0, atol=2e-13)


@pytest.mark.parametrize("kind", POLYNOMIALS)
def test_more_modes_leave_the_first_ones_alone(kind):
    assert_allclose(kind().values(SIGMA, 9)[:, :4], kind().values(SIGMA, 4), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("kind", POLYNOMIALS)
def test_the_first_mode_is_constant_curvature_and_polynomials_have_no_breakpoints(kind):
    assert np.array_equal(kind().values(SIGMA, 1), np.ones((len(SIGMA), 1)))
    assert kind().breakpoints == ()


@pytest.mark.parametrize("basis", [*(kind() for kind in POLYNOMIALS), *SPLINES], ids=repr)
def test_zero_modes_are_an_empty_row(basis):
    assert basis.values(SIGMA, 0).shape == (len(SIGMA), 0)


def test_legendre_modes_are_orthogonal():
    points, weights = np.polynomial.legendre.leggauss(12)
    values = Legendre().values(0.5 * (points + 1.0), 10)
    gram = values.T @ (0.5 * weights[:, None] * values)
    assert_allclose(gram, np.diag(1.0 / (2.0 * np.arange(10) + 1.0)), rtol=0.0, atol=1e-14)


def test_chebyshev_modes_are_orthogonal_in_their_weight():
    angle = (np.arange(16) + 0.5) * np.pi / 16
    values = Chebyshev().values(0.5 * (np.cos(angle) + 1.0), 10)
    gram = values.T @ values / 16
    assert_allclose(gram, np.diag([1.0, *[0.5] * 9]), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_b_splines_are_those_of_scipy(basis):
    degree, modes = basis.degree, mode_count(basis)
    knots = np.r_[np.zeros(degree + 1), basis.knots, np.ones(degree + 1)]
    found = basis.values(SIGMA, modes)
    assert found.shape == (len(SIGMA), modes)
    for k in range(modes):
        expected = BSpline(knots, np.eye(modes)[k], degree)(SIGMA)
        assert_allclose(found[:, k], expected, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_b_splines_are_a_partition_of_unity(basis):
    values = basis.values(SIGMA, mode_count(basis))
    assert np.all(values >= 0.0)
    assert_allclose(values.sum(axis=1), 1.0, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_b_splines_are_clamped_at_both_ends(basis):
    values = basis.values(np.array([0.0, 1.0]), mode_count(basis))
    unit = np.eye(mode_count(basis))
    assert_allclose(values, unit[[0, -1]], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_b_splines_are_zero_outside_their_support(basis):
    values = basis.values(SIGMA, mode_count(basis))
    assert np.all(np.count_nonzero(values, axis=1) <= basis.degree + 1)


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
@pytest.mark.parametrize("change", [-1, 1])
def test_b_splines_refuse_another_number_of_modes(basis, change):
    expected = mode_count(basis)
    modes = expected + change
    with pytest.raises(CprError, match=rf"has {expected} modes, not {modes}") as caught:
        basis.values(SIGMA, modes)
    assert f"degree {basis.degree}" in str(caught.value)
    assert f"{len(basis.knots)} interior knots" in str(caught.value)


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_b_splines_break_at_their_knots(basis):
    assert basis.breakpoints == basis.knots


def test_bases_are_known_by_name():
    assert STRAIN_BASES["legendre"] is Legendre
    assert STRAIN_BASES["chebyshev"] is Chebyshev
    assert STRAIN_BASES["monomials"] is Monomials
    assert STRAIN_BASES["bsplines"] is BSplines


@pytest.mark.parametrize("counts", [(0, 0, 5), (0, 4, 3), (2, 1, 3), (1, 0, 0)])
@pytest.mark.parametrize("kind", POLYNOMIALS)
def test_strain_modes_stack_torsion_and_both_bendings(counts, kind):
    modes = StrainModes(counts, kind())
    assert modes.total == sum(counts)
    expected = [direction for direction, count in enumerate(counts) for _ in range(count)]
    assert modes.directions.tolist() == expected
    values = modes.values(SIGMA)
    assert values.shape == (len(SIGMA), modes.total)
    for direction, count in enumerate(counts):
        mine = values[:, modes.directions == direction]
        assert_allclose(mine, kind().values(SIGMA, count), rtol=0.0, atol=0.0)


def test_a_basis_of_ones_own_needs_two_members_only():
    class Cosines:
        breakpoints = ()

        def values(self, sigma, modes):
            return np.cos(np.pi * np.outer(sigma, np.arange(modes)))

    values = StrainModes((0, 2, 3), Cosines()).values(SIGMA)
    assert_allclose(values[:, 4], np.cos(2.0 * np.pi * SIGMA), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("basis", [Legendre(), Chebyshev(), Monomials(), BSplines(2, (0.5,))])
def test_projection_of_a_strain_is_the_nearest_in_the_mean_square(basis):
    counts = (0, 4, 4)
    modes, grid = StrainModes(counts, basis), rod_grid(20, basis.breakpoints)
    curvature = np.column_stack([np.exp(grid.nodes), np.sin(5.0 * grid.nodes), grid.nodes**6])
    coordinates = modes.project(curvature, grid)
    values = modes.values(grid.nodes)
    for component in (1, 2):
        mine = modes.directions == component
        rest = curvature[:, component] - values[:, mine] @ coordinates[mine]
        assert_allclose(values[:, mine].T @ (grid.weights * rest), 0.0, atol=1e-13)
        assert np.abs(rest).max() > 1e-4


def test_projection_of_a_strain_the_modes_have_is_itself():
    modes, grid = StrainModes((2, 3, 5)), rod_grid(16, ())
    coordinates = np.random.default_rng(0).normal(size=10)
    curvature = (modes.values(grid.nodes) * coordinates) @ np.eye(3)[modes.directions]
    assert_allclose(modes.project(curvature, grid), coordinates, atol=1e-13)


@pytest.mark.parametrize("kind", POLYNOMIALS)
@pytest.mark.parametrize("modes", [1, 2, 7])
def test_a_single_place_has_the_values_it_has_among_others(kind, modes):
    expected = kind().values(SIGMA, modes)
    found = [kind().values(SIGMA[k : k + 1], modes)[0] for k in range(len(SIGMA))]
    assert_allclose(found, expected, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("basis", [*(kind() for kind in POLYNOMIALS), *SPLINES], ids=repr)
def test_what_modes_can_do_richer_ones_can_too(basis):
    count = mode_count(basis) if isinstance(basis, BSplines) else 5
    modes = StrainModes((0, 0, count), basis)
    richer = modes.richer(2)
    assert richer.counts[:2] == (0, 0) and richer.total > count
    values, sigma = modes.values(np.sort(SIGMA)), np.sort(SIGMA)
    combined = richer.values(sigma)
    found = combined @ np.linalg.lstsq(combined, values, rcond=None)[0]
    assert_allclose(found, values, atol=1e-12)


@pytest.mark.parametrize("basis", [Legendre(), BSplines()], ids=repr)
def test_modes_hold_no_strain_in_a_direction_without_any(basis):
    modes, nothing, bent = StrainModes((0, 0, 5), basis), np.zeros(0), np.array([1.5])
    assert modes.hold((nothing, nothing, bent))
    assert not modes.hold((nothing, bent, nothing))
