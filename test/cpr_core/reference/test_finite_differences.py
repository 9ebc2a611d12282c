# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Finite differences: Table II, first order, exact tangent."""

import numpy as np
import pytest
from helpers.reference_paths import numbers, read
from helpers.rough_homes import continuous_home
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose

from cpr_core import InvalidRequest, Loads, NoForwardSolution, load_robot
from cpr_core.reference.finite_differences import (
    follow_finite_differences,
    solve_finite_differences,
)


@pytest.fixture(scope="module")
def home():
    return continuous_home(load_robot("rfrfr"))


@pytest.mark.parametrize(
    ("elements", "mean", "worst"),
    [(50, 12.94, 53.44), (100, 6.59, 27.76), (500, 1.34, 5.71), (1000, 0.67, 2.86)],
)
def test_errors_on_the_path_are_those_of_table_ii(home, elements, mean, worst):
    rows = read("rfrfr_forward_path.csv")
    motors = [numbers(row, "q1", "q2") for row in rows]
    points = follow_finite_differences(solve_finite_differences(home, elements), motors)
    errors = [
        1e3 * np.linalg.norm(point.platform_position[:2] - numbers(row, "x", "y"))
        for point, row in zip(points, rows, strict=True)
    ]
    assert max(point.residual for point in points) < 1e-10
    assert np.mean(errors) == pytest.approx(mean, rel=0.03)
    assert np.max(errors) == pytest.approx(worst, rel=0.03)


def test_errors_are_of_first_order(home):
    errors = [
        np.linalg.norm(solve_finite_differences(home, n).platform_position - home.platform_position)
        for n in (200, 400)
    ]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.02)


def test_tangent_agrees_with_differences_and_is_symmetric(home):
    found = solve_finite_differences(home, 12)
    generator = np.random.default_rng(3)
    point = found.unknowns + 0.1 * generator.normal(size=len(found.unknowns))
    _, tangent = found.model.evaluate(found.motors, point)
    for direction in generator.normal(size=(5, len(point))):
        ahead = found.model.evaluate(found.motors, point + 1e-6 * direction)[0]
        behind = found.model.evaluate(found.motors, point - 1e-6 * direction)[0]
        assert_allclose(tangent @ direction, (ahead - behind) / 2e-6, atol=1e-7)
    assert abs(tangent - tangent.T).max() == 0.0


def test_curvature_follows_the_moment(home):
    found = solve_finite_differences(home, 1000)
    assert_allclose(found.curvatures[:, -1], 0.0, atol=1e-8)  # hinged tips
    rigidity = home.robot.description.legs[0].rod.rigidities[2]
    assert_allclose(found.curvatures[:, 0], home.base_wrenches[:, 2] / rigidity, rtol=5e-3)


def test_motors_that_turn_the_other_way_make_the_same_robot(home):
    content = shipped_content("rfrfr")
    content["legs"][1]["motor"]["axis"] = [0, 0, -1]
    content["home"]["motors"][1] *= -1.0
    expected = solve_finite_differences(home, 50)
    found = solve_finite_differences(continuous_home(load_robot(content)), 50)
    assert_allclose(found.platform_position, expected.platform_position, atol=1e-12)
    assert_allclose(found.curvatures, expected.curvatures, atol=1e-9)


def test_what_it_does_not_cover_is_refused(home):
    with pytest.raises(InvalidRequest, match="planar robot"):
        solve_finite_differences(continuous_home(load_robot("six_rfs")), 50)
    heavy = Loads.none().with_(gravity=[0.0, -9.81, 0.0])
    with pytest.raises(InvalidRequest, match="expected none"):
        solve_finite_differences(continuous_home(home.robot, loads=heavy), 50)
    content = shipped_content("rfrfr")
    content["rod"]["density"], content["platform"]["mass"] = 0.0, 0.05
    with pytest.raises(
        InvalidRequest, match="expected none"
    ):  # the platform weighs, the rods do not
        solve_finite_differences(continuous_home(load_robot(content), loads=heavy), 50)
    with pytest.raises(InvalidRequest, match="at least 2"):
        solve_finite_differences(home, 1)
    start = solve_finite_differences(home, 50)
    with pytest.raises(NoForwardSolution, match="no equilibrium near"):
        follow_finite_differences(start, [start.motors + [40.0, 0.0]])
