# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Trajectories: the same as single solves one after the other, with every event."""

import numpy as np
import pytest

from benchmarks.robustness import distance
from cpr_core import (
    InvalidRequest,
    Loads,
    NonFiniteInput,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace,
    trace_through,
)
from cpr_core.solving import waypoints
from cpr_core.solving.find_equilibria import find_equilibria
from paper.cases import RFRFR, SIX_RFS

CASES = {case.name: case for case in (RFRFR, SIX_RFS)}
SOLVERS = {"motors": solve_forward, "poses": solve_inverse, "efforts": solve_forward_by_effort}


def one_by_one(robot, quantity, rows, start):
    """A loop of single solves."""
    found = []
    for row in rows:
        found.append(SOLVERS[quantity](robot, row, start=found[-1] if found else start))
    return found


@pytest.mark.parametrize("quantity", SOLVERS)
@pytest.mark.parametrize("name", CASES)
def test_a_trajectory_is_what_single_solves_find(name, quantity):
    robot = load_robot(name)
    path = CASES[name].path()
    start = solve_forward(robot, path[0])
    places = one_by_one(robot, "motors", path[1:12], start)
    rows = [getattr(place, "pose" if quantity == "poses" else quantity) for place in places]
    found = trace_through(robot, **{quantity: rows}, start=start, singularities=False)
    assert found.reached and not found.events and len(found.equilibria) == len(rows)
    assert found.fractions[-1] == 1.0
    for ours, theirs in zip(found.equilibria, places, strict=True):
        assert ours.converged
        assert distance(ours, theirs) < 1e-7
        assert (ours.index_locked, ours.index_free) == (theirs.index_locked, theirs.index_free)
    assert found.motors.shape == (len(rows), robot.motor_count)
    # The predictions learn: fewer Newton steps than alone.
    alone = sum(place.iterations for place in places)
    if quantity == "motors":
        assert sum(equilibrium.iterations for equilibrium in found.equilibria) < alone


def test_every_numbering_of_equilibria_works():
    robot = load_robot("rfrfr")
    found = trace_through(robot, motors=solve_home(robot).motors + 0.01 * np.arange(5.0)[:, None])
    motors = [equilibrium.motors[0] for equilibrium in found.equilibria]
    assert motors == [equilibrium.motors[0] for equilibrium in found.equilibria[:]]
    assert found.equilibria[-1].motors[0] == motors[-1] == found.last.motors[0]
    assert [equilibrium.motors[0] for equilibrium in found.equilibria[::2]] == motors[::2]
    with pytest.raises(IndexError):
        found.equilibria[5]


def test_far_requests_loads_and_heavy_rods_are_walked_to():
    robot = load_robot("rfrfr")
    loads = Loads.none().with_(gravity=[0.0, -9.81, 0.0])
    rows = [
        solve_home(robot).motors + 0.7,
        solve_home(robot).motors - 0.6,
        solve_home(robot).motors - 0.61,
    ]
    found = trace_through(robot, motors=rows, loads=loads)
    first = solve_forward(robot, rows[0], loads=loads)
    places = [first, *one_by_one(robot, "motors", rows[1:], first)]
    assert max(distance(*pair) for pair in zip(found.equilibria, places, strict=True)) < 1e-8
    assert found.equilibria[0].loads is loads


def test_following_forces_are_walked_to():
    robot = load_robot("six_rfs")
    loads = Loads.none().with_(wrench_body=[0.0, 0.0, 0.0, 0.1, 0.0, 0.0])
    rows = solve_home(robot).motors + 0.02 * np.arange(4.0)[:, None]
    found = trace_through(robot, motors=rows, loads=loads)
    first = solve_forward(robot, rows[0], loads=loads)
    assert distance(found.last, one_by_one(robot, "motors", rows[1:], first)[-1]) < 1e-8


def test_poses_under_following_forces_are_what_single_solves_find(monkeypatch):
    """The first one is walked to, as it brings the loads; all others at once."""
    robot = load_robot("six_rfs")
    loads = Loads.none().with_(wrench_body=[0.0, 0.0, 0.0, 0.1, 0.0, 0.0])
    start = solve_home(robot)
    places = [solve_forward(robot, start.motors, start=start, loads=loads)]
    places += one_by_one(
        robot, "motors", start.motors + 0.01 * np.arange(1.0, 8.0)[:, None], *places
    )
    walked = []
    walk_to = waypoints.walk_to
    monkeypatch.setattr(
        waypoints,
        "walk_to",
        lambda *given, **options: walked.append(1) or walk_to(*given, **options),
    )
    poses = [place.pose for place in places]
    found = trace_through(robot, poses=poses, start=start, loads=loads, singularities=False)
    assert len(walked) == 1
    for ours, theirs in zip(found.equilibria, places, strict=True):
        assert distance(ours, theirs) < 1e-7
        assert ours.signs == theirs.signs


def test_stability_that_is_lost_is_an_event_at_its_place():
    robot = load_robot("rfrfr")
    start = solve_inverse(robot, [0.0, 0.3])
    rows = np.column_stack([np.zeros(40), np.linspace(0.29, -0.02, 40)])
    straight = trace(robot, pose=rows[-1], start=start)
    found = trace_through(robot, poses=rows, start=start)
    assert [event.kind for event in found.events] == [event.kind for event in straight.events]
    loss, straight_loss = found.events[0], straight.events[0]
    assert distance(loss.equilibrium, straight_loss.equilibrium) < 1e-6
    halted = trace_through(robot, poses=rows, start=start, stable_only=True)
    assert not halted.reached and halted.stopped.kind == "stability"
    assert all(equilibrium.index_locked == 0 for equilibrium in halted.equilibria)
    assert len(halted.equilibria) == int(halted.stopped.fraction * len(rows))
    assert distance(halted.last, loss.equilibrium) < 1e-6


def test_efforts_are_not_followed_from_where_free_motors_are_unstable():
    robot = load_robot("six_rfs")
    start = next(
        each.equilibrium
        for each in find_equilibria(robot, SIX_RFS.path()[0], starts=300)
        if each.stable and each.equilibrium.index_free > 0
    )
    rows = start.efforts + np.outer(np.linspace(0.001, 0.01, 10), np.ones(6))
    found = trace_through(robot, efforts=rows, start=start, stable_only=True)
    assert found.stopped.kind == "stability" and not len(found.equilibria)
    assert trace_through(robot, efforts=rows, start=start).equilibria


@pytest.mark.parametrize("limit", [0.0, 0.05, None])
def test_time_is_limited_between_requests_on_which_nothing_happens(limit):
    robot = load_robot("rfrfr")
    rows = solve_home(robot).motors + np.outer(np.sin(np.linspace(0.0, 30.0, 20000)), [0.1, 0.1])
    found = trace_through(robot, motors=rows, time_limit=limit)
    if limit is None:
        assert found.reached
    else:
        assert found.stopped.kind == "time_limit"
        assert len(found.equilibria) == round(found.stopped.fraction * len(rows)) < len(rows)
    assert limit != 0.0 or not found.equilibria


def test_an_interrupt_gets_in_between_requests_on_which_nothing_happens(monkeypatch):
    """Ctrl-C came through after the last of all rows, 17 s later where these were 300,000."""
    robot, told = load_robot("rfrfr"), []
    rows = solve_home(robot).motors + 0.1 * np.sin(np.linspace(0.0, 9.0, 20000))[:, None]

    def interrupted(found, start, problem, imposed, singularities):
        told.append(len(imposed))
        if len(told) == 2:
            raise KeyboardInterrupt
        return run(found, start, problem, imposed, singularities)

    run = waypoints._run
    monkeypatch.setattr(waypoints, "_run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        trace_through(robot, motors=rows)
    monkeypatch.undo()
    assert sum(told) <= 4096
    assert trace_through(robot, motors=rows).reached


def test_inverse_singularities_on_the_way_of_motors_are_events_where_they_are_asked_for():
    robot, path = load_robot("six_rfs"), SIX_RFS.path()
    start = solve_forward(robot, path[0])
    found = trace_through(robot, motors=path[1:], start=start)
    assert [event.kind for event in found.events] == ["singularity"]
    assert 50.0 * found.events[0].fraction == pytest.approx(47.81, abs=0.01)
    assert not trace_through(robot, motors=path[1:], start=start, singularities=False).events


def test_limits_stop_a_trajectory_where_they_are_passed():
    robot = load_robot("gough_stewart")
    lower = robot.description.legs[0].drive.limits.lower
    rows = np.tile(solve_home(robot).motors, (60, 1))
    rows[:, 0] = np.linspace(solve_home(robot).motors[0], lower - 0.01, 60)
    found = trace_through(robot, motors=rows)
    assert found.stopped.kind == "motor_limit"
    assert found.last.motors[0] == pytest.approx(lower, abs=1e-6)
    assert found.equilibria[-1].motors[0] >= lower


@pytest.mark.parametrize(
    ("requests", "error", "says"),
    [
        ({}, InvalidRequest, "got none"),
        ({"motors": [[1.0, 2.0]], "efforts": [[1.0, 2.0]]}, InvalidRequest, "motors and efforts"),
        ({"motors": [1.0, 2.0]}, InvalidRequest, "rows of 2 numbers"),
        ({"motors": [[1.0, 2.0, 3.0]]}, InvalidRequest, r"shape \(1, 3\)"),
        ({"poses": []}, InvalidRequest, r"x y"),
        ({"motors": [["a", "b"]]}, InvalidRequest, "numbers"),
        ({"motors": [[1.0, 2.0], [1.0, np.nan]]}, NonFiniteInput, "row 1"),
    ],
)
def test_wrong_requests_are_refused(requests, error, says):
    with pytest.raises(error, match=says):
        trace_through(load_robot("rfrfr"), **requests)


def test_numbers_that_are_not_finite_are_told_before_lengths():
    """A NaN is no length above 0 either, but that is not what is wrong with it."""
    robot = load_robot("gough_stewart")
    rows = np.tile(solve_home(robot).motors, (2, 1))
    rows[1, 2] = np.nan
    with pytest.raises(NonFiniteInput, match="row 1"):
        trace_through(robot, motors=rows)
