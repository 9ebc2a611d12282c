# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Bending strains: curvature times the distance of the outermost fibre."""

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import (
    DescriptionError,
    StrainLimitExceeded,
    bending_strains,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_home,
    trace,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.model.assessment import Assessment
from cpr_core.rods.sections import AnnularSection, CircularSection, GivenSection, RectangularSection
from cpr_core.solving.limits import margins


@pytest.mark.parametrize("name", shipped_robots())
def test_they_are_the_largest_curvature_along_the_leg(name):
    robot = load_robot(name)
    expected = []
    for leg, shape in zip(robot.description.legs, leg_shapes(solve_home(robot), 400), strict=True):
        for number, element in enumerate(leg.rods):
            at_rest = element.rod.rest_curvature_at(np.zeros(1))
            bent = (shape.curvature[shape.rod == number] - at_rest)[:, 1:]
            expected.append(element.rod.section.radius * np.linalg.norm(bent, axis=1).max())
    # The quadrature nodes may miss the top of a smooth curve by little.
    np.testing.assert_allclose(bending_strains(solve_home(robot)), expected, rtol=2e-2)


def test_stress_free_curvature_is_no_strain():
    content = shipped_content("rfrfr")
    content["rod"]["rest_curvature"] = {"bending_3": [0.7]}
    robot = load_robot(content)
    bent = [
        0.001 * np.abs(shape.curvature[:, 2] - 0.7).max()
        for shape in leg_shapes(solve_home(robot), 400)
    ]
    np.testing.assert_allclose(bending_strains(solve_home(robot)), bent, rtol=2e-2)


@pytest.mark.parametrize(
    ("section", "expected"),
    [
        (CircularSection(0.002), 0.002 * 5.0),
        (AnnularSection(0.003, 0.001), 0.003 * 5.0),
        (RectangularSection(width=0.01, height=0.002), 0.001 * 3.0 + 0.005 * 4.0),
        (GivenSection(1.0, 1.0, 1.0, outer_radius=0.004), 0.004 * 5.0),
    ],
)
def test_sections(section, expected):
    strain = section.bending_strain(np.array([3.0, -3.0]), np.array([-4.0, 4.0]))
    np.testing.assert_allclose(strain, expected)


@pytest.mark.parametrize("rest", [0.0, 2.0])
def test_rods_that_are_fed_have_the_strain_of_their_curvature_there(rest):
    content = shipped_content("gough_stewart")
    content["rod"]["rest_curvature"] = {"bending_3": [rest]}
    robot = load_robot(content)
    longer = solve_forward(robot, solve_home(robot).motors + 0.05)
    expected = [
        0.001 * np.hypot(shape.curvature[:, 1], shape.curvature[:, 2] - rest).max()
        for shape in leg_shapes(longer, 400)
    ]
    np.testing.assert_allclose(bending_strains(longer), expected, rtol=2e-2)


def test_a_yield_strain_needs_a_known_thickness():
    content = shipped_content("rfrfr")
    content["rod"] = {
        "length": 1.0,
        "section": {"shape": "given", "torsion": 0.1, "bending_2": 0.165, "bending_3": 0.165},
        "yield_strain": 0.01,
    }
    with pytest.raises(DescriptionError, match=r"rod\.section: missing field 'outer_radius'"):
        load_robot(content)
    content["rod"]["section"]["outer_radius"] = 0.001
    assert load_robot(content).yield_strains.tolist() == [0.01, 0.01]


@pytest.mark.parametrize("wrong", [0.0, -0.01, "much"])
def test_a_yield_strain_is_a_positive_number(wrong):
    content = shipped_content("rfrfr")
    content["rod"]["yield_strain"] = wrong
    with pytest.raises(DescriptionError, match=r"rod\.yield_strain"):
        load_robot(content)


@pytest.fixture(scope="module")
def one_given():
    """The first leg has a limit; the second is as stiff, but nobody knows how thick it is."""
    content = shipped_content("rfrfr")
    rod = content["rod"]
    stiffness = rod["young_modulus"] * np.pi / 4.0 * rod["section"]["radius"] ** 4
    stiff = dict.fromkeys(("torsion", "bending_2", "bending_3"), stiffness)
    content["legs"][0]["rod"] = rod | {"yield_strain": 0.005}
    content["legs"][1]["rod"] = {"length": rod["length"], "section": {"shape": "given"} | stiff}
    return solve_home(load_robot(content))


def test_they_are_not_known_of_a_rod_of_unknown_thickness(one_given):
    """They were zero, as of one that is not bent."""
    first, second = bending_strains(one_given)
    known = bending_strains(solve_home(load_robot("rfrfr")))
    assert first == pytest.approx(known[0], rel=1e-9)
    assert np.isnan(second)
    way = trace(one_given.robot, motors=one_given.motors + 0.01, points=3)
    assert (
        np.isnan(way.bending_strains[:, 1]).all() and np.isfinite(way.bending_strains[:, 0]).all()
    )


def test_limits_of_the_others_are_kept(one_given):
    reserve = Assessment(one_given).strain_reserve
    assert reserve == pytest.approx(1.0 - bending_strains(one_given)[0] / 0.005, rel=1e-12)
    assert margins(one_given) == pytest.approx([reserve], rel=1e-12)
    with pytest.raises(StrainLimitExceeded, match=r"^leg1: ") as raised:
        solve_forward(one_given.robot, one_given.motors + [1.5, -1.5])
    assert bending_strains(raised.value.last)[0] == pytest.approx(0.005, rel=1e-6)
    assert raised.value.value == pytest.approx(0.005, rel=1e-6)
