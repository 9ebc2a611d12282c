# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Proposed poses tell more than random ones, and the robot can be there."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.simulated_measurements import DEVIATIONS, PATHS, measured, payload

import cpr_core
from cpr_core import InvalidRequest, StandardDeviations, calibrate, propose_poses


@pytest.fixture(scope="module")
def proposed(robot):
    return propose_poses(robot, PATHS, DEVIATIONS, 6, loads=[payload(robot)])


def test_they_are_within_reach_and_stable(robot, proposed):
    home = cpr_core.solve_home(robot)
    assert len(proposed.equilibria) == 6
    for each in proposed.equilibria:
        assert np.abs(each.motors - home.motors).max() <= 0.5
        assert each.stable and each.margin >= 0.2


def test_far_away_they_are_as_far_from_instability_as_is_asked(robot):
    """Where most is told the robot is soft: asked for no margin, they are next to where it buckles."""
    near, usual, far = (
        min(each.margin for each in propose_poses(robot, PATHS, DEVIATIONS, 6, **more).equilibria)
        for more in ({"reach": 1.5, "margin": 0.0}, {"reach": 1.5}, {"reach": 1.5, "margin": 0.4})
    )
    assert near < 0.1
    assert 0.2 <= usual < 0.4 <= far


def test_their_standard_deviations_are_those_of_a_calibration(robot, proposed):
    found = calibrate(robot, measured(proposed.equilibria, seed=0), PATHS, DEVIATIONS)
    assert proposed.standard_deviations == pytest.approx(found.standard_deviations, rel=0.1)


def test_they_tell_more_than_random_ones(proposed):
    assert np.all(proposed.standard_deviations < 1.05 * proposed.random)
    assert np.prod(proposed.standard_deviations) < 0.5 * np.prod(proposed.random)


def test_what_they_would_not_tell_is_named(robot):
    found = propose_poses(robot, PATHS[:2], DEVIATIONS, 3)  # without load
    assert found.undetermined == ("rod.young_modulus is not determined",)
    assert np.isinf(found.standard_deviations[0]) and found.standard_deviations[1] < 0.01
    known = propose_poses(robot, PATHS[:2], replace(DEVIATIONS, efforts=0.01), 3)
    assert known.undetermined == ()
    for paths in (PATHS[:1], (PATHS[0], "rod.section.radius"), ("platform.mass",)):
        hidden = propose_poses(robot, paths, DEVIATIONS, 3)
        assert hidden.undetermined == tuple(f"{path} is not determined" for path in paths)
        assert np.all(np.isinf(hidden.standard_deviations))


@pytest.mark.parametrize(
    ("other", "says"),
    [
        ({"position": 0.5}, "position: a standard deviation of 0.5 m looks like millimetres"),
        ({"rotation": 0.11}, "rotation: a standard deviation of 0.11 rad looks like degrees"),
    ],
)
def test_deviations_in_another_unit_are_told_before_anything_is_measured(
    robot, proposed, other, says
):
    assert proposed.doubts == ()
    found = propose_poses(
        robot, PATHS[1:2], replace(DEVIATIONS, **other), 3, loads=[payload(robot)]
    )
    assert [doubt.startswith(says) for doubt in found.doubts] == [True]


def test_random_poses_that_tell_nothing_leave_parameters_as_uncertain_as_they_were(robot):
    """Young's modulus shows under the payload only, which one candidate in five has."""
    loads = [robot.default_loads] * 4 + [payload(robot)]
    found = propose_poses(robot, PATHS[:2], DEVIATIONS, 1, loads=loads, reach=0.3)
    assert np.isfinite(found.standard_deviations[0]) and np.isinf(found.random[0])
    more = propose_poses(robot, PATHS[:2], DEVIATIONS, 8, loads=loads, reach=0.3)
    assert np.all(more.standard_deviations < 1.05 * more.random) and np.isfinite(more.random).all()


def test_loads_without_potential_are_refused_by_name(robot):
    turned = robot.default_loads.with_(wrench_world=[0, 0, 0.01, 0, 0, -1])
    with pytest.raises(InvalidRequest, match=r"loads: expected loads with a potential"):
        propose_poses(robot, PATHS, DEVIATIONS, 3, loads=[robot.default_loads, turned])


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"count": 0}, "at least 1"),
        ({"count": 10**17}, "at most 1000,"),
        ({"reach": 0.0}, "positive distance"),
        ({"deviations": StandardDeviations(motors=1e-3)}, "position, rotation or efforts"),
        ({"margin": 0.999}, "only 0 of 40 random motor positions"),
        ({"seed": -1}, "seed: expected at least 0, got -1"),
        ({"seed": 1.5}, "seed: expected a whole number, got 1.5"),
        ({"loads": None}, "loads: expected a list of Loads, got None"),
    ],
)
def test_arguments_that_cannot_be(robot, arguments, text):
    given = {"parameters": PATHS, "deviations": DEVIATIONS, "count": 2} | arguments
    with pytest.raises(InvalidRequest, match=text):
        propose_poses(robot, **given)


def test_what_is_of_another_kind_is_named(robot, proposed):
    with pytest.raises(InvalidRequest, match=r"deviations: expected StandardDeviations\(position"):
        propose_poses(robot, PATHS, {"position": 1e-3}, 6)
    with pytest.raises(InvalidRequest, match="loads: expected a list of Loads, got one"):
        propose_poses(robot, PATHS, DEVIATIONS, 6, loads=payload(robot))
    with pytest.raises(InvalidRequest, match="deviations: expected StandardDeviations"):
        calibrate(robot, measured(proposed.equilibria, seed=0), PATHS, {"position": 1e-3})


def test_paths_that_name_the_same_number_are_refused(robot):
    """They were proposed for, and a calibration by them was refused."""
    paths = ("legs[1].motor.offset", "legs[0,1].motor.offset")
    with pytest.raises(InvalidRequest, match="name the same number"):
        propose_poses(robot, paths, DEVIATIONS, 3)


def test_the_way_goes_by_home_where_the_one_from_pose_to_pose_is_not_free():
    """A robot that was driven along the rows was halted by instabilities on four ways of twenty."""
    robot = cpr_core.load_robot("six_rus")
    found = propose_poses(robot, "legs[0].tip.position[0]", DEVIATIONS, 6, reach=0.8)
    assert any(found.home_first) and not all(found.home_first)
    home = cpr_core.solve_home(robot)
    ways = zip((home, *found.equilibria), found.equilibria, found.home_first, strict=False)
    for before, each, home_first in ways:
        start = home if home_first else before
        reached = cpr_core.solve_forward(robot, each.motors, start=start, stable_only=True)
        assert reached.platform_position == pytest.approx(each.platform_position, abs=1e-9)
        if home_first:
            with pytest.raises(cpr_core.NotReached):
                cpr_core.solve_forward(robot, each.motors, start=before, stable_only=True)


def test_loads_may_be_changed_before_the_motors_move_or_afterwards():
    """In the one order 11 of 80 ways lost stability, in the other 4: none said which was meant."""
    robot = cpr_core.load_robot("rfrfr")
    both = [robot.default_loads.with_(wrench_world=[0, 0, 0, 0, force, 0]) for force in (-1.0, 1.0)]
    exact, paths = StandardDeviations(position=5e-4), ("rod.young_modulus", "legs[0].motor.offset")
    home, changes = cpr_core.solve_home(robot), 0
    for seed in range(3):
        found = propose_poses(robot, paths, exact, 8, reach=2.5, margin=0.02, loads=both, seed=seed)
        ways = zip((home, *found.equilibria), found.equilibria, found.home_first, strict=False)
        for before, each, home_first in ways:
            start = home if home_first else before
            changes += bool(start.loads.differences(each.loads))
            for corner in ((start.motors, each.loads), (each.motors, start.loads)):
                at = start
                for motors, loads in (corner, (each.motors, each.loads)):
                    at = cpr_core.solve_forward(
                        robot, motors, start=at, loads=loads, stable_only=True
                    )
                assert at.platform_position == pytest.approx(each.platform_position, abs=1e-8)
    assert changes > 2
