# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers that measurements hardly tell are doubted, and those that end where descriptions do."""

import numpy as np
import pytest
from helpers.simulated_measurements import DEVIATIONS, OFFSETS, equilibria, measured, payload

import cpr_core
from cpr_core import CalibrationWarning, calibrate, propose_poses
from cpr_core.identification.number_doubts import border_doubts, hardly_told

YOUNG = "rod.young_modulus"


def found_with(robot, home, force, seed):
    """Young's modulus and a zero, by what a payload shows of them."""
    truth = robot.with_parameters({YOUNG: 200e9})
    rows = equilibria(truth, home, count=5, loads=payload(robot, force))
    return calibrate(robot, measured(rows, seed=seed), (YOUNG, OFFSETS[0]), DEVIATIONS)


@pytest.mark.parametrize(("force", "seed"), [(-3e-3, 0), (-3e-3, 1), (-1e-2, 1), (-1e-2, 2)])
def test_a_modulus_that_a_small_load_does_not_tell_is_doubted(robot, home, force, seed):
    """It came out as stiff as no material is, or seven times too soft, and nothing was said."""
    with pytest.warns(CalibrationWarning, match=f"^{YOUNG} is hardly told: its standard deviation"):
        found = found_with(robot, home, force, seed)
    assert found.undetermined == ()
    assert found.standard_deviations[0] > 0.5 * found.values[0]
    assert not any(OFFSETS[0] in doubt for doubt in found.doubts)


def test_a_number_at_the_border_of_descriptions_is_told(robot, home):
    with pytest.warns(CalibrationWarning, match=f"{YOUNG} ends next to what no robot has .*stiff"):
        found = found_with(robot, home, -3e-3, 0)
    assert found.values[0] == pytest.approx(2e12, rel=1e-2)
    assert len(found.doubts) == 2


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(3))
def test_what_is_told_is_not_doubted(robot, home, seed):
    assert found_with(robot, home, -0.1, seed).doubts == ()


def test_numbers_that_may_vanish_are_told_to_be_small():
    robot = cpr_core.load_robot("delta")
    mass, place = "platform.mass", "legs[0].tip.position[0]"
    described = robot.parameter_values([mass])
    little, deviations = np.array([1e-3]), np.array([0.1 * described[0]])
    unit = np.ones(1)
    assert hardly_told(robot, [mass], little, deviations, unit, described) == ()
    [doubt] = hardly_told(robot, [mass], little, 10.0 * deviations, unit, described)
    assert doubt.startswith("platform.mass is hardly told") and "cannot be negative" in doubt
    for at in (place, OFFSETS[0].replace("motor", "chain[0]"), "legs[0].base.tangent[2]"):
        assert hardly_told(robot, [at], little, np.array([1.0]), 2.0 * unit) == ()
        assert hardly_told(robot, [at], little, np.array([1.0]), unit, 2.0 * unit) == ()
        [doubt] = hardly_told(robot, [at], little, np.array([1.0]), unit)
        assert "may have any sign" in doubt
    assert hardly_told(robot, [mass], little, np.array([np.inf]), unit) == ()


def test_values_well_within_are_at_no_border():
    robot = cpr_core.load_robot("delta")
    mass = ["platform.mass"]
    described = robot.parameter_values(mass)
    for value, deviation, at_border in ((1e-4, 5e-5, False), (1e-9, 5e-5, True), (0.0, 1.0, True)):
        other = robot.with_parameters({mass[0]: value})
        given = np.array([value]), np.array([deviation]), described
        assert bool(border_doubts(other, mass, *given)) == at_border
        assert not border_doubts(other, mass, given[0], np.array([np.inf]), described)


def test_proposed_poses_say_what_they_would_hardly_tell(robot):
    asked = (YOUNG, OFFSETS[0]), DEVIATIONS, 5
    [doubt] = propose_poses(robot, *asked, loads=[payload(robot, -1e-2)], reach=0.3).doubts
    assert doubt.startswith(f"{YOUNG} is hardly told")
    assert propose_poses(robot, *asked, loads=[payload(robot)], reach=0.3).doubts == ()
    assert propose_poses(robot, *asked, reach=0.3).doubts == ()  # not determined, which is said
