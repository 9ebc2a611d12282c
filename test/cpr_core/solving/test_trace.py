# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whole paths: arrays, events, folds passed, progress."""

import itertools

import numpy as np
import pytest
from helpers.turntable import turntable

from benchmarks.robustness import distance
from cpr_core import (
    InvalidRequest,
    critical_load,
    load_robot,
    solve_forward,
    solve_home,
    solve_inverse,
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
