# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cantilever under loads and with profiles, against the beams of textbooks."""

import numpy as np
import pytest
from helpers.cantilever import BENDING, LENGTH, cantilever
from scipy.integrate import quad

from cpr_core import InvalidRequest, Loads, load_robot, solve_forward, solve_home
from cpr_core.description.loads import DistributedForce, PointForce


def deflection(content, loads=None):
    robot = load_robot(content)
    return solve_forward(robot, [], loads=loads).platform_position[1]


def test_a_point_force_bends_like_the_textbook_beam():
    force, at = 1e-5, 0.4 * LENGTH
    loads = Loads.none().with_(points=[PointForce("leg1", 0.4, np.array([0.0, force, 0.0]))])
    expected = force * at**2 * (3.0 * LENGTH - at) / (6.0 * BENDING)
    assert deflection(cantilever(), loads) == pytest.approx(expected, rel=1e-4)


def test_a_triangular_load_bends_like_the_textbook_beam():
    force = np.array([[0.0, 1e-4, 0.0], [0.0, 0.0, 0.0]])
    loads = Loads.none().with_(distributed=[DistributedForce("leg1", np.array([0.0, 1.0]), force)])
    expected = 1e-4 * LENGTH**4 / (30.0 * BENDING)
    assert deflection(cantilever(), loads) == pytest.approx(expected, rel=1e-7)


def test_loads_of_the_description_act_from_home_on():
    content = cantilever()
    content["loads"] = {
        "points": [{"leg": "leg1", "at": 0.7, "force": [0, 1e-5, 0]}],
        "distributed": [
            {"leg": "leg1", "at": [0, 0.5, 1], "force": [[0, 0, 0], [0, 1e-4, 0], [0, 0, 0]]}
        ],
        "platform_force": [0, 2e-5, 0],
    }
    at = 0.7 * LENGTH
    expected = 1e-5 * at**2 * (3.0 * LENGTH - at) / (6.0 * BENDING)
    expected += 2e-5 * LENGTH**3 / (3.0 * BENDING)
    hat, _ = quad(
        lambda s: (1.0 - abs(2.0 * s / LENGTH - 1.0)) * s**2 * (3.0 * LENGTH - s),
        0.0,
        LENGTH,
        points=[0.25],
    )
    expected += 1e-4 * hat / (6.0 * BENDING)
    found = solve_home(load_robot(content)).platform_position[1]
    assert found == pytest.approx(expected, rel=1e-4)


def test_a_tapered_rod_bends_as_its_stiffness_says():
    content = cantilever(profile={"at": [0, 0.5, 1], "stiffness": [1.0, 0.6, 0.5]})
    content["strain"] = {"basis": "bsplines", "degree": 5, "knots": [0.5]}
    force = 1e-5

    def compliance(s):
        return (LENGTH - s) ** 2 / (BENDING * np.interp(s / LENGTH, [0, 0.5, 1], [1.0, 0.6, 0.5]))

    expected = force * quad(compliance, 0.0, LENGTH, points=[0.25])[0]
    loads = Loads.none().with_(wrench_world=[0, 0, 0, 0, force, 0])
    assert deflection(content, loads) == pytest.approx(expected, rel=1e-4)


def test_the_mass_of_a_tapered_rod_is_what_its_profile_says():
    section = {"shape": "given", "torsion": 1, "bending_2": 1, "bending_3": 1, "mass": 0.2}
    content = cantilever(section=section, profile={"at": [0, 0.3, 1], "mass": [1.0, 0.5, 0.2]})
    robot = load_robot(content)
    weight = robot.load_arrays(Loads.none().with_(gravity=[0, -10.0, 0])).distributed[0, 1, -1]
    mean = 0.3 * 0.75 + 0.7 * 0.35
    assert weight == pytest.approx(-10.0 * 0.2 * mean, rel=1e-12)


@pytest.mark.parametrize("curvature", [0.5, -4.0])
def test_a_rod_curved_at_rest_is_an_arc_without_stress(curvature):
    robot = load_robot(cantilever(rest_curvature={"bending_3": [curvature]}))
    home = solve_home(robot)
    angle = curvature * LENGTH
    np.testing.assert_allclose(
        home.platform_position[:2],
        [np.sin(angle) / curvature, (1.0 - np.cos(angle)) / curvature],
        atol=1e-10,
    )
    assert home.energy == pytest.approx(0.0, abs=1e-12)
    assert home.spectrum_locked.margin == pytest.approx(1.0, abs=1e-9)


def test_forces_at_other_places_than_stations_are_refused():
    robot = load_robot(cantilever())
    off = PointForce("leg1", 0.33, np.array([0.0, 1.0, 0.0]))
    with pytest.raises(InvalidRequest, match=r"station of the robot \(0\.4\), got 0\.33"):
        solve_forward(robot, [], loads=Loads.none().with_(points=[off]))
    unknown = PointForce("arm", 0.4, np.array([0.0, 1.0, 0.0]))
    with pytest.raises(InvalidRequest, match="expected a leg out of leg1, got 'arm'"):
        solve_forward(robot, [], loads=Loads.none().with_(points=[unknown]))
