# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Cross-sections: area and second moments by summing over small squares, torsion by known values."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cpr_core.rods.sections import (
    AnnularSection,
    CircularSection,
    GivenSection,
    RectangularSection,
)

YOUNG, SHEAR, DENSITY = 210e9, 80e9, 7800.0
WIDTH, HEIGHT = 0.01, 0.001  # along d2 and d3 [m]

#: A section, and whether a point (along d2, along d3) is in it.
SHAPES = {
    "circular": (CircularSection(0.003), lambda y, z: np.hypot(y, z) < 0.003),
    "annular": (
        AnnularSection(0.004, 0.003),
        lambda y, z: (np.hypot(y, z) < 0.004) & (np.hypot(y, z) > 0.003),
    ),
    "rectangular": (
        RectangularSection(WIDTH, HEIGHT),
        lambda y, z: (np.abs(y) < 0.5 * WIDTH) & (np.abs(z) < 0.5 * HEIGHT),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_area_and_second_moments_are_integrals_over_the_section(name):
    section, inside = SHAPES[name]
    step = 5e-6
    line = np.arange(-0.006, 0.006, step) + 0.5 * step
    along_2, along_3 = np.meshgrid(line, line, indexing="ij")
    areas = inside(along_2, along_3) * step**2
    torsion, about_2, about_3 = section.rigidities(YOUNG, SHEAR)
    assert_allclose(section.mass_per_length(DENSITY), DENSITY * areas.sum(), rtol=2e-3)
    assert_allclose(about_2, YOUNG * (areas * along_3**2).sum(), rtol=5e-3)
    assert_allclose(about_3, YOUNG * (areas * along_2**2).sum(), rtol=5e-3)
    if name != "rectangular":  # Saint-Venant: the polar moment of what is round
        assert_allclose(torsion, SHEAR * (areas * (along_2**2 + along_3**2)).sum(), rtol=5e-3)


def test_torsion_of_rectangles():
    """0.140577 a^4 of a square, a b^3 / 3 (1 - 0.630249 b / a) of a strip (Timoshenko and Goodier)."""
    square = RectangularSection(0.002, 0.002).rigidities(YOUNG, SHEAR)[0]
    assert_allclose(square, SHEAR * 0.140577 * 0.002**4, rtol=1e-5)
    for strip in (RectangularSection(WIDTH, HEIGHT), RectangularSection(HEIGHT, WIDTH)):
        expected = WIDTH * HEIGHT**3 / 3.0 * (1.0 - 0.630249 * HEIGHT / WIDTH)
        assert_allclose(strip.rigidities(YOUNG, SHEAR)[0], SHEAR * expected, rtol=1e-6)


def test_the_largest_strain_is_that_of_the_outermost_point():
    curvatures = np.array([3.0, 0.0, 3.0]), np.array([0.0, 4.0, 4.0])
    round_ones = (
        CircularSection(0.003),
        AnnularSection(0.003, 0.001),
        GivenSection(1.0, 1.0, 1.0, outer_radius=0.003),
    )
    for section in round_ones:
        assert_allclose(section.bending_strain(*curvatures), [0.009, 0.012, 0.015])
    strip = RectangularSection(WIDTH, HEIGHT)  # about d2 points along d3 are strained
    assert_allclose(strip.bending_strain(*curvatures), [0.0015, 0.02, 0.0215])


def test_what_was_measured_is_taken_as_it_is():
    section = GivenSection(torsion=1.0, bending_2=2.0, bending_3=3.0, mass=4.0)
    assert section.rigidities(YOUNG, SHEAR) == (1.0, 2.0, 3.0)
    assert section.mass_per_length(DENSITY) == 4.0


def test_a_cone_with_equal_ends_is_none():
    assert CircularSection(0.001, 0.0009).tapered
    assert not CircularSection(0.001, 0.001).tapered


@pytest.mark.parametrize(("width", "height"), [(1.0, 1.0), (2.0, 3.0), (3.0, 1e-3)])
def test_torsion_of_rectangles_is_the_whole_series(width, height):
    """Twenty terms of it were too few by 7e-8 of a square."""
    torsion, _, _ = RectangularSection(width, height).second_moments
    short, long, odd = min(width, height), max(width, height), np.arange(1.0, 40_000.0, 2.0)
    series = (np.tanh(0.5 * np.pi * odd * long / short) / odd**5).sum()
    expected = long * short**3 * (1.0 / 3.0 - 64.0 / np.pi**5 * short / long * series)
    assert torsion == pytest.approx(expected, rel=1e-14)
    if width == height:
        assert torsion == pytest.approx(0.1405770149551555, rel=1e-14)
