# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whole paths: arrays, events, folds passed, progress."""

import itertools

import numpy as np
import pytest
from helpers.turntable import turntable
from helpers.yaml_content import shipped_content

from benchmarks.robustness import distance
from cpr_core import (
    InvalidRequest,
    critical_load,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
    trace_through,
)
from cpr_core.solving.trace import trace


def test_a_trace_is_the_solutions_along_the_way():
    robot = load_robot("six_rfs")
    last = solve_home(robot).motors + [0.3, -0.2, 0.2, 0.1, -0.3, 0.2]
    found = trace(robot, motors=last, points=7)
    assert found.reached
    np.testing.assert_allclose(found.fractions, np.linspace(0.0, 1.0, 7), atol=1e-15)
    for fraction, equilibrium in zip(found.fractions, found.equilibria, strict=True):
        motors = (1.0 - fraction) * solve_home(robot).motors + fraction * last
        assert distance(equilibrium, solve_forward(robot, motors)) < 1e-8
    assert found.motors.shape == found.efforts.shape == (7, 6)
    assert found.platform_positions.shape == (7, 3)
    assert found.eigenvalues_locked.shape == (7, 6)
    assert found.bending_strains.shape == (7, 6)
    assert found.indices_locked.tolist() == found.indices_free.tolist() == [0] * 7
    np.testing.assert_allclose(np.linalg.norm(found.platform_quaternions, axis=1), 1.0)
    assert found.energies[0] == solve_home(robot).energy
    assert found.last is found.equilibria[-1]


def test_the_inverse_singularity_of_the_papers_path_is_an_event():
    robot = load_robot("six_rfs", modes=12)
    found = trace(robot, motors=[7.95, 7.65, 4.29, 3.89, 3.77, 3.17])
    assert [event.kind for event in found.events] == ["singularity"]
    assert 50.0 * found.events[0].fraction == pytest.approx(47.81, abs=0.02)
    assert trace(robot, motors=found.motors[-1], singularities=False, points=2).events == ()


@pytest.mark.parametrize("given", ["motors", "efforts"])
def test_inverse_singularities_are_events_under_loads_without_a_potential_too(given):
    robot = load_robot("six_rfs")
    pushed = robot.default_loads.with_(wrench_body=[0.005, 0.002, 0.003, 0.01, 0.005, 0.0])
    start = solve_forward(robot, solve_home(robot).motors, loads=pushed)
    last = solve_forward(robot, [7.95, 7.65, 4.29, 3.89, 3.77, 3.17], start=start)
    way = {given: getattr(last, given)}
    found = trace(robot, **way, start=start, points=101)
    assert [event.kind for event in found.events] == ["singularity"]
    jacobians = np.array([each.jacobian for each in found.equilibria])
    turned = np.flatnonzero(np.diff(np.sign(np.linalg.det(jacobians))))
    assert found.fractions[turned] == pytest.approx([found.events[0].fraction], abs=0.01)
    assert trace(robot, **way, start=start, singularities=False, points=2).events == ()


def test_stability_crossings_are_events_between_the_points():
    robot = load_robot("rfrfr", modes=16)
    start = solve_inverse(robot, [0.0, 0.8])
    found = trace(robot, pose=[0.0, -0.2], start=start, points=11)
    assert [event.kind for event in found.events] == ["stability", "stability"]
    crossings = [0.8 - event.fraction for event in found.events]
    np.testing.assert_allclose(crossings, [0.0357105, -0.0573998], atol=1e-7)
    assert found.indices_locked.tolist() == [0] * 8 + [1, 2, 2]
    stopped = trace(robot, pose=[0.0, -0.2], start=start, points=11, stable_only=True)
    assert not stopped.reached
    assert stopped.stopped is stopped.events[-1]
    assert len(stopped.equilibria) == 8
    assert stopped.last is stopped.stopped.equilibrium


def test_folds_are_passed_where_asked():
    """Down through the fold, back along the unstable branch, through the next fold and on."""
    robot = load_robot("rfrfr")
    start = solve_forward(robot, solve_home(robot).motors + [0.0, 0.02])
    critical = critical_load(start, [0.0, -1.0, 0.0]).value
    loads = start.loads.with_(wrench_world=[0, 0, 0, 0, -2.0 * critical, 0])
    assert trace(robot, loads=loads, start=start).stopped.kind == "fold"
    found = trace(robot, loads=loads, start=start, past_folds=True, singularities=False)
    assert found.reached
    assert [event.kind for event in found.events] == ["fold", "fold"]
    assert found.events[0].fraction == pytest.approx(0.5, abs=1e-8)
    assert found.fractions[0] == 0.0
    assert found.fractions[-1] == pytest.approx(1.0, abs=1e-9)
    indices = found.indices_locked
    assert indices[0] == indices[-1] == 0
    assert indices.max() == 1
    # Steps of a curve, not jumps.
    steps = [distance(before, after) for before, after in itertools.pairwise(found.equilibria)]
    assert max(steps) < 0.6
    for equilibrium in found.equilibria[:: len(found.equilibria) // 10]:
        force = equilibrium.loads.wrench_world[4]
        assert np.abs(equilibrium.motors - start.motors).max() < 1e-12
        assert -2.0 * critical <= force <= 0.0


@pytest.mark.parametrize("name", ["three_rfs", "three_prs"])
def test_ways_of_angles_are_reached_where_folds_are_passed_too(name):
    """One in forty was."""
    robot = load_robot(name)
    home = solve_home(robot)
    for change in np.random.default_rng(0).uniform(-1.0, 1.0, (8, 3)) * [0.02, 0.15, 0.15]:
        plain = trace(robot, pose=home.pose + change, points=2)
        past = trace(robot, pose=home.pose + change, points=2, past_folds=True)
        assert past.reached == plain.reached
        if plain.reached:
            assert distance(past.last, plain.last) < 1e-7


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs"])
def test_gravity_may_begin_and_end_on_ways_past_folds(name):
    """Beside the ends of a way from none, or to none, it was dropped with all loads on rods."""
    robot = load_robot(name)
    home = solve_home(robot)
    assert not np.any(home.loads.gravity)
    for gravity in np.random.default_rng(1).normal(0.0, 3.0, (5, 3)):
        heavy = home.loads.with_(gravity=gravity * ([1, 1, 0] if robot.planar else 1))
        plain = trace(robot, loads=heavy, points=2)
        past = trace(robot, loads=heavy, past_folds=True)
        assert plain.reached and past.reached
        assert distance(past.last, plain.last) < 1e-7
        assert trace(robot, start=plain.last, loads=home.loads, past_folds=True).reached


@pytest.mark.parametrize("points", [51, 501])
def test_points_are_kept_where_a_walk_goes_by_arc_length_too(points):
    """Past the buckling of a column one stood at another fraction, for all that were passed."""
    content = shipped_content("planar_body")
    (leg, *_) = content["legs"]
    leg |= {"base": {"position": [0, 0, 0], "tangent": [1, 0, 0]}}
    leg |= {"motor": {"type": "revolute", "axis": [0, 0, 1]}}
    leg |= {"tip": {"type": "fixed", "position": [0, 0, 0], "tangent": [1, 0, 0]}}
    content |= {"legs": [leg], "controlled": ["angle"], "strain": {"bending_3": 8}}
    content |= {
        "home": {"motors": [0.0], "platform": {"position": [content["rod"]["length"], 0, 0]}}
    }
    robot = load_robot(content)
    (rod,) = robot.description.rods
    euler = np.pi**2 * rod.rod.rigidities[2] / (4.0 * rod.rod.length**2)
    push = solve_home(robot).loads.with_(wrench_world=[0, 0, 0, -2.01 * euler, 0, 0])
    found = trace(robot, loads=push, points=points)
    assert found.reached and [event.kind for event in found.events] == ["bifurcation"]
    assert found.events[0].fraction == pytest.approx(1.0 / 2.01, abs=1e-6)
    assert type(found.events[0].fraction) is float
    np.testing.assert_allclose(found.fractions, np.linspace(0.0, 1.0, points), atol=1e-12)
    for fraction, equilibrium in zip(found.fractions, found.equilibria, strict=True):
        force = equilibrium.loads.wrench_world[3]
        assert force == pytest.approx(-2.01 * fraction * euler, rel=1e-9)


def test_a_trace_of_nothing_has_rows_of_nothing():
    robot = load_robot("planar_body")
    found = trace_through(robot, motors=[[2.0, 0.5, 0.5], [2.1, 0.5, 0.5]])
    assert found.stopped.kind == "motor_limit" and not found.equilibria
    assert found.motors.shape == found.efforts.shape == found.bending_strains.shape == (0, 3)
    assert found.platform_positions.shape == (0, 3)
    assert found.platform_quaternions.shape == (0, 4)
    assert len(found.eigenvalues_locked) == len(found.energies) == len(found.indices_free) == 0


def test_progress_is_told():
    robot = load_robot("rfrfr")
    seen = []
    trace(robot, motors=[3.0, 0.9], points=5, progress=seen.append)
    assert seen[-1] == 1.0
    assert seen == sorted(seen)


def test_quaternions_do_not_jump():
    robot = load_robot("six_rfs")
    found = trace(
        robot, motors=solve_home(robot).motors + 3.0 * np.array([1, -1, 1, -1, 1, -1]), points=60
    )
    changes = np.abs(np.diff(found.platform_quaternions, axis=0)).max()
    assert changes < 0.5


def test_quaternions_go_on_over_whole_turns():
    """Beyond half a turn w would change its sign, once or back and forth."""
    found = trace(turntable(), motors=[14.0], points=40)
    half = 0.5 * found.motors[:, 0]
    expected = np.column_stack([np.cos(half), np.zeros((40, 2)), np.sin(half)])
    np.testing.assert_allclose(found.platform_quaternions, expected, atol=1e-9)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({}, "expected one of motors, pose and efforts, or loads, got none"),
        ({"motors": [3.0, 0.5], "pose": [0.0, 0.8]}, "got motors and pose"),
        ({"motors": [3.0]}, "motors: expected 2 numbers"),
        ({"motors": [3.0, 0.5], "points": 1}, "points: expected at least 2, got 1"),
    ],
)
def test_bad_questions_are_refused(wrong, text):
    with pytest.raises(InvalidRequest, match=text):
        trace(load_robot("rfrfr"), **wrong)
