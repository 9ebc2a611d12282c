# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""All equilibria at given motors."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from helpers.rigid_leg import rigid_leg

from benchmarks.robustness import distance, residual
from cpr_core import InvalidRequest, MotorLimitExceeded, load_robot, solve_forward, solve_home
from cpr_core.reference.conjugate_points import conjugate_points
from cpr_core.reference.continuous_rods import solve_continuous
from cpr_core.solving.assembly import turned_over
from cpr_core.solving.find_equilibria import (
    FoundEquilibrium,
    find_equilibria,
    merged_equilibria,
)
from cpr_core.solving.limits import check_limits

SIX = [5.86, 5.56, 5.86, 5.46, 5.86, 5.26]


@pytest.fixture(scope="module")
def found():
    return find_equilibria(load_robot("rfrfr"), [2.59, 0.55], starts=200)


def test_each_is_an_equilibrium_at_the_motors(found):
    assert len(found) >= 6
    for entry in found:
        assert residual(entry.equilibrium) < 1e-10
        np.testing.assert_allclose(entry.equilibrium.motors, [2.59, 0.55], atol=1e-12)
        assert entry.stable == (entry.equilibrium.spectrum_locked.index == 0)
    energies = [entry.equilibrium.energy for entry in found]
    assert energies == sorted(energies)
    assert sum(entry.starts for entry in found) <= 200


def test_none_comes_twice(found):
    for number, entry in enumerate(found):
        for other in found[:number]:
            assert distance(entry.equilibrium, other.equilibrium) > 1e-4


def test_home_is_among_them_and_the_only_one_of_its_branch(found):
    robot = found[0].equilibrium.robot
    assert [entry.from_home for entry in found] == [True] + [False] * (len(found) - 1)
    assert distance(found[0].equilibrium, solve_home(robot)) < 1e-9


def test_mirror_images_come_in_pairs():
    """At mirrored motors the robot is its own mirror image, and so are its equilibria together."""
    robot = load_robot("rfrfr")
    found = find_equilibria(robot, [np.pi - 0.55, 0.55], starts=200, seed=4)
    places = np.array([entry.equilibrium.platform_position for entry in found])
    often = [entry.equilibrium.platform_position for entry in found if entry.starts > 3]
    assert len(often) >= 4
    for place in often:
        mirrored = place * [-1.0, 1.0, 1.0]
        assert np.abs(places - mirrored).max(axis=1).min() < 1e-6


def test_of_mirror_images_the_first_known_comes_first():
    """Their energies are the same but for rounding, which differs between computers."""
    robot = rigid_leg()
    home, image, *others = find_equilibria(robot, solve_home(robot).motors, starts=60)
    assert home.from_home
    assert home.equilibrium.energy == pytest.approx(image.equilibrium.energy, rel=1e-9)
    assert all(entry.equilibrium.energy > home.equilibrium.energy + 1e-6 for entry in others)
    for pair in ((home, image), (image, home)):
        merged = merged_equilibria(pair[:1], pair[1:])
        assert [entry.equilibrium for entry in merged] == [entry.equilibrium for entry in pair]


def test_the_same_in_other_processes(found):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        again = find_equilibria(
            load_robot("rfrfr"), [2.59, 0.55], starts=20, seed=0, executor=executor
        )
    serial = find_equilibria(load_robot("rfrfr"), [2.59, 0.55], starts=20, seed=0)
    assert [entry.starts for entry in again] == [entry.starts for entry in serial]
    for entry, expected in zip(again, serial, strict=True):
        assert distance(entry.equilibrium, expected.equilibrium) < 1e-12
    robot = again[0].equilibrium.robot
    assert all(entry.equilibrium.robot is robot for entry in again)


def test_no_leg_holds_turned_over():
    """Its tip joint would hold half a turn away from how it is built; most of this robot's would."""
    robot = load_robot("planar_body")
    found = find_equilibria(robot, solve_home(robot).motors, starts=50)
    assert len(found) >= 2
    assert [turned_over(entry.equilibrium) for entry in found] == [None] * len(found)


def test_progress_is_told():
    seen = []
    find_equilibria(load_robot("rfrfr"), [2.59, 0.55], starts=10, progress=seen.append)
    np.testing.assert_allclose(seen, np.arange(1, 11) / 10)


def test_bad_questions_are_refused():
    with pytest.raises(InvalidRequest, match="starts: expected at least 1"):
        find_equilibria(load_robot("rfrfr"), [2.59, 0.55], starts=0)
    with pytest.raises(InvalidRequest, match=r"starts: expected a whole number, got 2\.5"):
        find_equilibria(load_robot("rfrfr"), [2.59, 0.55], starts=2.5)
    with pytest.raises(InvalidRequest, match="motors: expected 2 numbers"):
        find_equilibria(load_robot("rfrfr"), [2.59])


@pytest.mark.slow(seconds=45)
def test_the_six_rfs_robot_has_dozens_of_equilibria_and_few_stable_ones():
    robot = load_robot("six_rfs")
    # Threads that wait for each other take a fifth more of a processor that other tests want too.
    with ThreadPoolExecutor(1) as single_thread:
        searches = [
            find_equilibria(robot, SIX, starts=4000, seed=seed, executor=single_thread)
            for seed in (0, 1)
        ]
    for found in searches:
        assert len(found) >= 40
        first = found[0].equilibrium
        assert found[0].from_home
        assert first.energy == pytest.approx(2.05804, abs=2e-5)
        # One is stable however the motors are read: home.
        assert [entry.equilibrium.index_free for entry in found].count(0) == 1
        assert first.index_locked == first.index_free == 0
        # One more is stable with the motors held, its platform turned over by 147 degrees.
        stable = [entry.equilibrium for entry in found if entry.stable]
        assert len(stable) == 2
        assert stable[1].energy == pytest.approx(2.36825, abs=1e-5)
        assert stable[1].index_free == 1
    low = [
        [entry.equilibrium for entry in found if entry.equilibrium.energy < 3.0]
        for found in searches
    ]
    assert len(low[0]) == len(low[1]) >= 10
    for equilibrium, other in zip(*low, strict=True):
        assert equilibrium.energy == pytest.approx(other.energy, abs=1e-9)
        assert distance(equilibrium, other) < 1e-6


def test_the_second_stable_equilibrium_is_one_of_continuous_rods():
    """No conjugate point on any rod: Till and Rucker's test, by another method than H_r."""
    robot = load_robot("six_rfs")
    found = find_equilibria(robot, SIX, starts=300, seed=0)
    second = next(entry.equilibrium for entry in found[1:] if entry.stable)
    continuous = solve_continuous(second)
    np.testing.assert_allclose(continuous.platform_position, second.platform_position, atol=1e-4)
    assert len(conjugate_points(continuous)) == 0
    third = next(entry.equilibrium for entry in found if entry.equilibrium.index_locked == 1)
    assert len(conjugate_points(solve_continuous(third))) == 1
    # Not on the branch of home: straight back to it along no motor path at all.
    assert distance(solve_forward(robot, SIX), second) > 0.1


def test_where_energy_decides_nothing_none_is_called_stable():
    robot = load_robot("six_rfs")
    moment = robot.default_loads.with_(wrench_world=[0, 0, 0.01, 0, 0, 0])
    found = find_equilibria(robot, SIX, starts=100, loads=moment)
    assert any(each.equilibrium.index_locked == 0 for each in found)
    assert not any(each.stable for each in found)


@pytest.mark.parametrize(("name", "distinct"), [("delta", 1), ("three_prs", 2)])
def test_whole_turns_of_passive_joints_count_where_a_spring_is_wound(name, distinct):
    """A joint without one, of a universal joint of delta, is where it was."""
    home = solve_home(load_robot(name))
    joint, index = home.robot.passive_joints[0]
    assert (joint.stiffness > 0.0) == (distinct == 2)
    record = home.record.copy()
    record[index] += 2.0 * np.pi
    both = [FoundEquilibrium(each, False, 1) for each in (home, replace(home, record=record))]
    merged = merged_equilibria(both[:1], both[1:])
    assert [found.starts for found in merged] == [2 // distinct] * distinct


def test_what_no_motor_or_rod_bears_is_said():
    """It is found all the same: equilibria are asked for, and whether there are others."""
    within = find_equilibria(load_robot("rfrfr"), [2.6, 0.5], starts=5)
    assert [found.beyond for found in within] == [""] * len(within)
    found = find_equilibria(load_robot("three_rfs"), [4.0, 5.4, 5.4], starts=20)
    assert found
    for each in found:
        with pytest.raises(MotorLimitExceeded, match=r"motor1: position 4.*4\.2, 6\.2") as refused:
            check_limits(each.equilibrium)
        assert each.beyond == str(refused.value)
