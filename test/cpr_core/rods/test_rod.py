# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a rod whose stiffness varies is compared with: the uniform one that is as soft."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cpr_core import estimate_wrench, kinemato_statics, load_robot, solve_home
from cpr_core.rods.quadrature import rod_grid
from cpr_core.rods.rod import Rod
from cpr_core.rods.sections import CircularSection

YOUNG, SHEAR, LENGTH = 2.1e11, 8.2e10, 0.8


def two_legs(*rods):
    """A planar robot of two equal legs, a motor and these rods in series each."""
    material = {"young_modulus": YOUNG, "shear_modulus": SHEAR}
    legs = [
        {
            "base": {"position": [0.2 * side, 0, 0], "tangent": [0, 1, 0]},
            "chain": [
                {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{side + 2}"},
                *({"rod": material | rod} for rod in rods),
            ],
            "tip": {"type": "revolute", "position": [0, 0, 0]},
        }
        for side in (-1, 1)
    ]
    return load_robot(
        {
            "name": "two_legs",
            "space": "planar",
            "rod": {"length": LENGTH, "section": circular(0.001), **material},
            "strain": {"bending_3": 8},
            "platform": {"shape": "point"},
            "legs": legs,
            "controlled": ["x", "y"],
            "home": {"motors": [-0.3, 0.3], "bow": "outward"},
        }
    )


def circular(radius):
    return {"shape": "circular", "radius": radius}


def cone(pieces, base=0.0013, tip=0.0009):
    """The same cone in one rod or in several."""
    radii = np.linspace(base, tip, pieces + 1).tolist()
    ends = itertools.pairwise(radii)
    return [{"length": LENGTH / pieces, "section": circular(list(both))} for both in ends]


def units(robot):
    model = kinemato_statics(solve_home(robot))
    values = [model.singular_values(problem) for problem in ("forward", "inverse")]
    return robot.wrench_units, np.concatenate([each[:2] for each in values])


@pytest.mark.parametrize("pieces", [2, 5])
def test_how_a_cone_is_cut_changes_neither_units_nor_singular_values(pieces):
    """In eight pieces it was half as stiff as in one, and as far from singularities."""
    whole, parts = units(two_legs(*cone(1))), units(two_legs(*cone(pieces)))
    assert_allclose(parts[0], whole[0], rtol=1e-12)
    assert_allclose(parts[1], whole[1], rtol=1e-6)  # of other strain modes


def test_neither_does_whether_modulus_or_profile_says_how_stiff_it_is():
    plain = {"length": LENGTH, "section": circular(0.001)}
    profile = {"at": [0, 0.5, 1], "stiffness": [4.0, 4.0, 4.0]}
    softer = plain | {"young_modulus": YOUNG / 4, "shear_modulus": SHEAR / 4, "profile": profile}
    for found, expected in zip(units(two_legs(softer)), units(two_legs(plain)), strict=True):
        assert_allclose(found, expected, rtol=1e-9)


def given(torsion, bending_2, bending_3):
    """A section with these stiffnesses."""
    stiffness = {"torsion": torsion, "bending_2": bending_2, "bending_3": bending_3}
    return {"length": LENGTH, "section": {"shape": "given", "mass": 0.02} | stiffness}


@pytest.mark.parametrize(("torsion", "bending_2"), [(0.16, 1.6), (16.0, 0.16), (1e4, 1e5)])
def test_what_the_plane_does_not_feel_decides_nothing_there(torsion, bending_2):
    """Singular values of a leaf spring were as small as it is thin, and all of a wrench was felt."""
    leaf, even = two_legs(given(torsion, bending_2, 0.16)), two_legs(given(0.16, 0.16, 0.16))
    for found, expected in zip(units(leaf), units(even), strict=True):
        assert_allclose(found, expected, rtol=1e-12)
    felt = [
        estimate_wrench(robot, home.motors, efforts=home.efforts, effort_deviation=0.1, start=home)
        for robot, home in ((robot, solve_home(robot)) for robot in (leaf, even))
    ]
    assert felt[0].words == felt[1].words
    assert_allclose(felt[0].covariance, felt[1].covariance, rtol=1e-6, atol=1e-9)


def test_in_space_a_strip_counts_by_the_way_it_bends():
    rod = two_legs(given(1.0, 5.0, 0.16)).description.legs[0].rods[0].rod
    assert rod.mean_rigidity(planar=False) == pytest.approx(0.16)
    turned = two_legs(given(1.0, 0.16, 5.0)).description.legs[0].rods[0].rod
    assert turned.mean_rigidity(planar=False) == pytest.approx(0.16)
    assert turned.mean_rigidity(planar=True) == pytest.approx(5.0)


@pytest.mark.parametrize("tip", [0.9, 0.3, 0.01])
def test_the_mean_rigidity_of_a_cone_is_that_of_its_integral(tip):
    rod = two_legs(*cone(1, base=0.001, tip=0.001 * tip)).description.legs[0].rods[0].rod
    softness = (tip**-3 - 1.0) / (3.0 * (1.0 - tip))
    assert rod.mean_rigidity(planar=True) == pytest.approx(rod.rigidities[2] / softness, rel=1e-10)


def test_that_of_a_profile_lies_between_its_ends_and_nearer_to_the_softer_one():
    profile = {"at": [0, 0.25, 1], "stiffness": [1.0, 3.0, 1.0]}
    plain = {"length": LENGTH, "section": circular(0.001), "profile": profile}
    rod = two_legs(plain).description.legs[0].rods[0].rod
    # On every stretch the factor is linear: int ds / f = length ln(f1 / f0) / (f1 - f0).
    expected = rod.rigidities[2] * 2.0 / np.log(3.0)
    assert rod.mean_rigidity(planar=True) == pytest.approx(expected, rel=1e-12)


def test_a_cone_weighs_and_is_strained_as_thick_as_it_is():
    base, tip, density = 0.0013, 0.0009, 7800.0
    section, sigma = CircularSection(base, tip), np.array([0.0, 0.5, 1.0])
    rod = Rod(LENGTH, section, YOUNG, SHEAR, density)
    grid = rod_grid(4)
    mass = LENGTH * grid.weights @ rod.mass_at(grid.nodes)
    volume = np.pi * LENGTH / 3.0 * (base**2 + base * tip + tip**2)
    assert mass == pytest.approx(density * volume, rel=1e-12)
    strains = rod.bending_strain_at(sigma, np.tile([9.0, 3.0, 4.0], (3, 1)))
    assert_allclose(strains, 5.0 * np.array([base, 0.5 * (base + tip), tip]), rtol=1e-12)
