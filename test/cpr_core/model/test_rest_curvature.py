# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods that are curved at rest, also in waves and directions that their strain modes do not have."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.differences import check_residual, check_tangent
from helpers.yaml_content import shipped_content
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from cpr_core import (
    DescriptionError,
    Loads,
    Robot,
    choose_modes,
    derivatives,
    error_of,
    leg_shapes,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.description.loads import PointForce
from cpr_core.lie import rotation_log
from cpr_core.model.bending_strain import bending_strains
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.rods.rod import StrainModes, strain_series
from cpr_core.rods.strain_basis import BSplines, Chebyshev, Legendre, Monomials

#: In waves about d3, about d2, and twisted.
CURVED = {
    "torsion": [3.0, -1.0],
    "bending_2": [0.5, 1.0, 2.0],
    "bending_3": [1.0, 0, 0, 0, 0, 0, 2.0],
}
WAVES = [0.0] * 9 + [3.0]


def curved(name, rest, **strain):
    content = shipped_content(name)
    content["rod"]["rest_curvature"] = rest
    return load_robot(content | {"strain": strain})


def one_rod(rest, strain, **home):
    """A rod on a motor, with nothing to hold it."""
    rod = {"length": 0.5, "section": {"shape": "circular", "radius": 0.001}}
    rod |= {"young_modulus": 2e11, "shear_modulus": 8e10, "rest_curvature": rest}
    ends = {"tangent": [0, 0, 1], "normal": [1, 0, 0]}
    return load_robot(
        {
            "name": "one_rod",
            "space": "spatial",
            "rod": rod,
            "strain": strain,
            "legs": [
                {
                    "base": {"position": [0, 0, 0], **ends},
                    "motor": {"type": "revolute", "axis": [0, 1, 0]},
                    "tip": {"type": "fixed", "position": [0, 0, 0], **ends},
                }
            ],
            "controlled": ["x"],
            "home": {"motors": [0.0]} | (home or {"bow": [1, 0, 0]}),
        }
    )


@pytest.mark.parametrize("basis", [Legendre(), Chebyshev(), Monomials(), BSplines(2, (0.4,))])
@pytest.mark.parametrize("counts", [(0, 0, 4), (4, 4, 4)])
def test_modes_and_what_is_beyond_them_are_the_whole(basis, counts):
    rod, sigma = load_robot("rfrfr").description.legs[0].rod, np.linspace(0.0, 1.0, 7)
    modes = StrainModes(counts, basis)
    rod = replace(rod, rest_curvature=strain_series(CURVED))
    assert not modes.hold(rod.rest_curvature)
    taken = np.zeros((7, 3))
    for column, direction in enumerate(modes.directions):
        taken[:, direction] += modes.values(sigma)[:, column] * rod.rest_strain(modes)[column]
    beyond = rod.rest_beyond_at(modes, sigma)
    assert_allclose(taken + beyond, rod.rest_curvature_at(sigma), atol=1e-12)
    missing = np.array(counts) == 0
    assert_allclose(beyond[:, missing], rod.rest_curvature_at(sigma)[:, missing], atol=0.0)
    within = replace(rod, rest_curvature=strain_series({"bending_3": [1.0, -0.5, 0.3]}))
    assert modes.hold(within.rest_curvature)
    assert not within.rest_beyond_at(modes, sigma).any()
    values = modes.values(sigma)[:, modes.directions == 2]
    taken = values @ within.rest_strain(modes)[modes.directions == 2]
    assert_allclose(taken, within.rest_curvature_at(sigma)[:, 2], atol=1e-12)


@pytest.mark.parametrize("strain", [{}, {"torsion": 2, "bending_2": 1, "bending_3": 1}])
def test_without_loads_it_has_its_shape_with_any_modes(strain):
    """Integrated as it is: 0.2 m off where what the modes lack was left out."""
    robot = one_rod(CURVED, strain)
    home, rod = solve_home(robot), robot.description.legs[0].rod

    def slope(arc, state):
        frame = state[3:].reshape(3, 3)
        torsion, second, third = rod.rest_curvature_at(np.array([arc / rod.length]))[0]
        turn = np.array([[0, -third, second], [third, 0, -torsion], [-second, torsion, 0]])
        return np.concatenate([frame[:, 0], (frame @ turn).ravel()])

    leg = robot.description.legs[0]
    start = np.concatenate([leg.base_position, leg.base_rotation.ravel()])
    end = solve_ivp(slope, (0.0, rod.length), start, rtol=1e-12, atol=1e-13).y[:, -1]
    assert_allclose(home.platform_position, end[:3], atol=1e-9)
    frame = home.platform_rotation @ leg.joint.rotation()
    assert_allclose(frame, end[3:].reshape(3, 3), atol=1e-9)
    assert home.energy == pytest.approx(0.0, abs=1e-12)
    assert home.stable and bending_strains(home).max() < 1e-12
    shape = leg_shapes(home, 40)[0]
    assert_allclose(shape.position[-1], home.platform_position, atol=1e-9)
    sigma = shape.arc_length / rod.length
    assert_allclose(shape.curvature, rod.rest_curvature_at(sigma), atol=1e-9)


@pytest.mark.filterwarnings("ignore:.*give a better position")
@pytest.mark.parametrize(
    "home", [{"joints": {}}, {"platform": {"position": [0, 0, 0.5]}}, {"bow": [-1, 0, 0]}]
)
@pytest.mark.parametrize("bend", [1.0, 4.0, 9.0])
def test_a_rod_that_nothing_holds_is_at_rest_however_home_is_told(home, bend):
    """Not turned as the tip, the platform ended half a turn off, where the joint seems to be closed."""
    rest = {"torsion": [bend], "bending_3": [bend]}
    expected = solve_home(one_rod(rest, {}))
    found = solve_home(one_rod(rest, {}, **home))
    assert_allclose(found.platform_position, expected.platform_position, atol=1e-9)
    assert_allclose(found.platform_rotation, expected.platform_rotation, atol=1e-9)


def loads_of(planar):
    force = np.array([0.2, -0.3, 0.0 if planar else 0.4])
    return Loads.none().with_(
        gravity=[1.0, -9.0, 0.0 if planar else 3.0], points=[PointForce("leg1", 0.35, force)]
    )


@pytest.mark.parametrize(("name", "strain"), [("rfrfr", {"bending_3": 4}), ("six_rfs", {})])
def test_derivatives_are_those_of_the_energy(name, strain):
    rest = CURVED if name == "six_rfs" else {"bending_3": CURVED["bending_3"]}
    robot = curved(name, rest, **strain)
    robot = Robot(replace(robot.description, stations=(0.35,)))
    check_tangent(robot, loads_of(robot.planar))
    check_residual(robot, loads_of(robot.planar))


@pytest.mark.parametrize(("modes", "most"), [(3, 5e-4), (5, 1e-5), (8, 3e-6)])
@pytest.mark.parametrize("waves", [WAVES, [0.0] * 12 + [3.0], [0.0] * 28 + [2.0]])
def test_waves_need_no_modes_of_their_own_and_the_error_is_told(waves, modes, most):
    """They were 0.3 mm off, whatever the modes below their number, and the estimate a thousandth."""
    coarse, fine = (curved("rfrfr", {"bending_3": waves}, bending_3=count) for count in (modes, 40))
    found = solve_forward(coarse, solve_home(fine).motors + 0.2)
    true = solve_forward(fine, found.motors).platform_position - found.platform_position
    assert np.linalg.norm(true) < most
    assert_allclose(error_of(found).position, true, atol=0.3 * np.linalg.norm(true))


@pytest.mark.parametrize(("modes", "least"), [(5, 5e-5), (12, 3e-8)])
def test_they_are_those_of_continuous_rods(modes, least):
    robot = curved("six_rfs", CURVED, torsion=modes, bending_2=modes, bending_3=modes)
    found = solve_forward(robot, solve_home(robot).motors + 0.1)
    rods = solve_continuous(found)
    true = rods.platform_position - found.platform_position
    assert np.linalg.norm(true) < least
    assert_allclose(error_of(found).position, true, atol=0.2 * np.linalg.norm(true))
    turn = rotation_log(rods.platform_rotation @ found.platform_rotation.T)
    assert_allclose(error_of(found).rotation, turn, atol=0.2 * np.linalg.norm(turn))


def test_chosen_modes_are_exact_enough():
    chosen = choose_modes(curved("rfrfr", {"bending_3": WAVES}, bending_3=5), 1e-5)
    fine = curved("rfrfr", {"bending_3": WAVES}, bending_3=40)
    motors = solve_home(fine).motors + 0.1
    ends = [solve_forward(robot, motors).platform_position for robot in (chosen, fine)]
    assert np.linalg.norm(ends[1] - ends[0]) < 1e-5
    assert max(rod.modes.counts[2] for rod in chosen.description.rods) < 8


@pytest.mark.parametrize(
    "path", ["rod.rest_curvature.torsion[0]", "rod.rest_curvature.bending_3[6]"]
)
def test_what_is_beyond_the_modes_is_a_parameter(path):
    robot = curved("six_rfs", CURVED, torsion=0, bending_2=3, bending_3=3)
    found = solve_forward(robot, solve_home(robot).motors + 0.1)
    told = derivatives(found, [path], ("pose", "efforts"))
    value, step = robot.parameter_values([path])[0], 1e-3
    ends = [
        solve_forward(changed, found.motors, start=solve_home(changed))
        for changed in (robot.with_parameters({path: value + way * step}) for way in (-1.0, 1.0))
    ]
    slope = (ends[1].platform_position - ends[0].platform_position) / (2.0 * step)
    assert np.linalg.norm(slope) > 1e-6
    assert_allclose(told.position[:, 0], slope, rtol=1e-4, atol=1e-9)
    slope = (ends[1].efforts - ends[0].efforts) / (2.0 * step)
    assert_allclose(told.efforts[:, 0], slope, rtol=1e-4, atol=1e-9)


def fed_content(**strain):
    """A rod that motors feed and that is twisted and curved at rest."""
    content = shipped_content("gough_stewart")
    content["rod"]["rest_curvature"] = {"torsion": [0.5], "bending_3": [0.2]}
    return content | {"strain": strain}


def test_a_fed_rod_has_modes_where_it_is_curved_at_rest():
    with pytest.raises(DescriptionError, match=r"legs\[0\].*expected strain modes of torsion too"):
        load_robot(fed_content(torsion=0, bending_2=3, bending_3=3))
    robot = load_robot(fed_content(torsion=1, bending_2=3, bending_3=3))
    without = Robot(robot.description.with_mode_counts([(0, 3, 3)] * 6))
    with pytest.raises(DescriptionError, match="modes of torsion"):
        solve_home(without)
    chosen = load_robot(fed_content(tolerance=1e-4))
    assert all(rod.modes.counts[0] > 0 for rod in chosen.description.rods)


def test_efforts_that_feed_rods_curved_at_rest_are_what_their_energy_changes_by():
    """What comes out of a feed has to be bent out of the shape it has at rest."""
    robot = load_robot(fed_content(torsion=1, bending_2=3, bending_3=3))
    home, step = solve_home(robot), 1e-4
    for motor, effort in enumerate(home.efforts):
        way = step * np.eye(robot.motor_count)[motor]
        ahead, behind = (solve_forward(robot, home.motors + by) for by in (way, -way))
        change = (ahead.energy - behind.energy) / (2.0 * step)
        assert effort == pytest.approx(change, rel=1e-5, abs=1e-5 * np.abs(home.efforts).max())
