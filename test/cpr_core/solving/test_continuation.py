# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Walks: the same end however it is reached, events where they are, limits, time."""

import re

import numpy as np
import pytest
from helpers.ring_robots import four_legs

from benchmarks.robustness import RANGES, distance, regularity
from cpr_core import (
    InvalidRequest,
    Loads,
    MotorLimitExceeded,
    NoForwardSolution,
    NotReached,
    StrainLimitExceeded,
    TimeLimitExceeded,
    UnstableEquilibrium,
    bending_strains,
    critical_load,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace,
    trace_through,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.solving.continuation import follow
from cpr_core.solving.targets import MotorTarget

PATHS = {
    "rfrfr": ([2.59, 0.55], [5.76, 3.67]),
    "six_rfs": ([5.86, 5.56, 5.86, 5.46, 5.86, 5.26], [7.95, 7.65, 4.29, 3.89, 3.77, 3.17]),
}
GRAVITY = {"rfrfr": [0.0, -9.81, 0.0], "six_rfs": [0.0, 0.0, -9.81]}


def walked(robot, start, target, requests):
    """Straight to motors in a number of requests."""
    first = start.motors
    equilibrium = start
    for number in range(1, requests + 1):
        fraction = number / requests
        equilibrium = solve_forward(
            robot, (1.0 - fraction) * first + fraction * np.array(target), start=equilibrium
        )
    return equilibrium


@pytest.mark.parametrize("heavy", [False, True])
@pytest.mark.parametrize("name", PATHS)
def test_paper_paths_end_the_same_however_many_requests_they_take(name, heavy):
    robot = load_robot(name)
    first, last = PATHS[name]
    loads = Loads.none().with_(gravity=GRAVITY[name]) if heavy else None
    start = solve_forward(robot, first, loads=loads)
    ends = [walked(robot, start, last, requests) for requests in (50, 5, 1)]
    for end in ends[1:]:
        assert distance(end, ends[0]) < 1e-9
    for requests in (50, 5, 1):
        assert distance(walked(robot, ends[0], first, requests), start) < 1e-9


@pytest.mark.parametrize("modes", [5, 12])
def test_the_rfrfr_robot_loses_stability_twice_on_its_way_down(modes):
    robot = load_robot("rfrfr", modes=modes)
    start = solve_inverse(robot, [0.0, 0.8])
    target = [0.0, -0.2]
    assert solve_inverse(robot, target, start=start).index_locked == 2
    with pytest.raises(UnstableEquilibrium, match="stability is lost") as caught:
        solve_inverse(robot, target, start=start, stable_only=True)
    event = caught.value.event
    assert (event.kind, event.index_before, event.index_after) == ("stability", 0, 1)
    assert caught.value.last is event.equilibrium
    assert event.equilibrium.index_locked == 0
    # Where the smallest eigenvalue vanishes, by a root search that knows nothing of events.
    low, high = event.fraction - 1e-4, event.fraction + 1e-4

    def smallest(fraction):
        place = [0.0, 0.8 - fraction]
        return solve_inverse(robot, place, start=start).spectrum_locked.smallest

    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if smallest(middle) > 0.0 else (low, middle)
    assert event.fraction == pytest.approx(low, abs=1e-8)


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_rfs"])
def test_a_load_beyond_the_critical_one_stops_at_the_fold(name):
    robot = load_robot(name)
    down = [0.0, -1.0, 0.0] if robot.planar else [0.0, 0.0, -1.0]
    start = solve_forward(robot, solve_home(robot).motors + 0.02 * np.arange(robot.motor_count))
    critical = critical_load(start, down)
    assert critical.kind == "fold"
    wrench = start.loads.wrench_world + np.concatenate(
        [np.zeros(3), 1.7 * critical.value * np.array(down)]
    )
    with pytest.raises(NoForwardSolution, match="the branch turns back") as caught:
        solve_forward(
            robot, start.motors, start=start, loads=start.loads.with_(wrench_world=wrench)
        )
    event = caught.value.event
    assert event.kind == "fold"
    assert 1.7 * event.fraction == pytest.approx(1.0, abs=3e-8)
    # The last equilibrium belongs to the loads it says, and can be gone on from.
    last = event.equilibrium
    np.testing.assert_allclose(
        last.loads.wrench_world[3:] - start.loads.wrench_world[3:],
        critical.value * np.array(down),
        rtol=1e-7,
    )
    assert distance(solve_forward(robot, start.motors, start=last, loads=start.loads), start) < 1e-7


def test_a_column_meets_a_bifurcation_not_a_fold():
    """The straight column under its axial load: the branch goes on, unstable."""
    from helpers.columns import AT_TIP, BENDING, LENGTH, column

    from cpr_core.description import joints, motors

    robot = column(motors.Welded(), joints.Fixed(AT_TIP), modes=8)
    critical = np.pi**2 * BENDING / (2.0 * LENGTH) ** 2
    loads = Loads.none().with_(wrench_world=[0, 0, 0, -2.0 * critical, 0, 0])
    walk = follow(solve_home(robot), MotorTarget(np.zeros(0)), loads)
    assert walk.stopped is None
    kinds = {event.kind for event in walk.events}
    assert kinds == {"bifurcation"}
    assert walk.events[0].fraction == pytest.approx(0.5, abs=1e-6)
    assert walk.last.index_locked > 0
    with pytest.raises(UnstableEquilibrium, match="cross") as caught:
        solve_forward(robot, [], loads=loads, stable_only=True)
    assert caught.value.fraction == pytest.approx(0.5, abs=1e-6)


STEEP = [
    {"wrench_world": [0, 0, 0, 15.0, 0, 0]},
    {"wrench_world": [0, 0, 0, -25.0, 0, 0]},
    {"wrench_body": [0, 0, 0, 0, 10.0, 0]},
    {"wrench_body": [0, 0, 2.0, 0, 0, 0]},
    {"wrench_world": [0.5, -2.1, -2.8, -2.9, -8.6, -5.8]},
]


@pytest.mark.parametrize("wrench", STEEP, ids=str)
def test_heavy_loads_at_once_end_as_loads_step_by_step(wrench):
    """Where one step would jump to an equilibrium that is far away, and several do not."""
    robot = load_robot("gough_stewart")
    loads = Loads.none().with_(**wrench)
    slow = follow(
        solve_home(robot),
        MotorTarget(solve_home(robot).motors),
        loads,
        keep=tuple(np.linspace(0, 1, 301)),
    )
    fast = follow(solve_home(robot), MotorTarget(solve_home(robot).motors), loads)
    assert (fast.stopped is None) == (slow.stopped is None)
    if slow.stopped is None:
        assert distance(fast.last, slow.last) < 1e-7
    else:
        assert fast.stopped.kind == slow.stopped.kind
        assert fast.stopped.fraction == pytest.approx(slow.stopped.fraction, abs=1e-8)


@pytest.mark.parametrize("force", [-3.2, -3.7, -3.8, -3.9, -4.9, -6.2])
def test_symmetric_paths_go_on_symmetrically_or_stop(force):
    """Two eigenvalues vanish together; no branch without the symmetry may be taken."""
    robot = load_robot("three_rfs")
    loads = Loads.none().with_(wrench_world=[0, 0, 0, 0, 0, force])
    target = MotorTarget(solve_home(robot).motors + 0.3)
    for keep in ((), tuple(np.linspace(0, 1, 101))):
        walk = follow(solve_home(robot), target, loads, keep=keep)
        assert np.abs(walk.last.platform_position[:2]).max() < 1e-4
        if walk.stopped is not None:
            assert walk.stopped.kind == "bifurcation"


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "three_rfs"])
def test_folds_by_effort_are_where_the_free_robot_loses_stability(name):
    """Motors moved far, their efforts asked for from home: reached while stable, else up to a fold."""
    robot = load_robot(name)
    random, home = np.random.default_rng(7), solve_home(robot)
    reached, folds = 0, []
    for _ in range(20):
        away = random.uniform(-1.0, 1.0, robot.motor_count) * RANGES[name]
        try:
            efforts = solve_forward(robot, home.motors + away).efforts
        except NotReached:
            continue  # no equilibrium, no efforts to ask for
        try:
            found = solve_forward_by_effort(robot, efforts)
        except NoForwardSolution as end:
            assert end.event.kind == "fold"
            folds.append(end.last)
            continue
        np.testing.assert_allclose(found.efforts, efforts, atol=1e-8)
        assert found.index_free == 0
        reached += 1
    for last in folds:
        assert last.spectrum_free.eigenvalues[0] > 0.0
        assert regularity(last, "efforts") < 1e-2 * regularity(home, "efforts")
    assert reached > 0
    assert len(folds) > 0


def test_motor_limits_end_a_way_where_they_are_reached():
    robot = load_robot("planar_body")
    with pytest.raises(MotorLimitExceeded, match=r"motor\d: position .* of the way") as caught:
        solve_inverse(robot, [0.005, 0.0, 0.0])
    error = caught.value
    lower, upper = error.limits
    number = robot.motor_names.index(error.motor)
    reached = error.last.motors[number]
    assert lower - 1e-9 <= reached <= upper + 1e-9
    assert min(reached - lower, upper - reached) < 1e-6
    assert error.event.kind == "motor_limit"
    with pytest.raises(MotorLimitExceeded, match=r"motor2: position 2 rad is outside") as caught:
        solve_forward(robot, [0.5, 2.0, 0.5])
    assert caught.value.fraction == pytest.approx(1.0 / 1.5, abs=1e-8)


def test_a_limit_passed_within_a_step_is_seen():
    """The target keeps the limit, the way to it does not."""
    robot = load_robot("planar_body")
    start = solve_forward(robot, [1.49, 0.5, 0.5])
    end = solve_forward(robot, [1.49, -0.5, 0.9])
    pose = [*end.platform_position[:2], np.arctan2(*end.platform_rotation[[1, 0], 0])]
    dense = [
        equilibrium.motors[0] for equilibrium in unlimited_way(start, pose, np.linspace(0, 1, 101))
    ]
    assert len(dense) == 101
    assert max(dense) > 1.5
    with pytest.raises(MotorLimitExceeded, match="motor1: position"):
        solve_inverse(robot, pose, start=start)


def unlimited_way(start, pose, fractions):
    """Parts of the way to a pose, each from the start, by a robot without limits."""
    import yaml

    text = shipped_robots()["planar_body"].read_text().replace("e9 ", ".0e+9 ")
    content = yaml.safe_load(text)
    for leg in content["legs"]:
        del leg["motor"]["limits"]
    free = load_robot(content)
    unlimited_start = solve_forward(free, start.motors)
    first = np.array(
        [
            *unlimited_start.platform_position[:2],
            np.arctan2(*unlimited_start.platform_rotation[[1, 0], 0]),
        ]
    )
    for fraction in fractions:
        part = (1.0 - fraction) * first + fraction * np.array(pose)
        yield solve_inverse(free, part, start=unlimited_start)


def test_rods_end_a_way_where_they_would_yield():
    import yaml

    text = shipped_robots()["rfrfr"].read_text().replace("e9 ", ".0e+9 ")
    content = yaml.safe_load(text)
    content["rod"]["yield_strain"] = 0.005
    robot = load_robot(content)
    with pytest.raises(StrainLimitExceeded, match=r"leg\d: bending strain 0\.005") as caught:
        solve_forward(robot, [4.5, -1.5])
    error = caught.value
    assert re.search(r"strain 0\.0050*[1-9]\d* is above its yield strain 0\.005,", str(error))
    assert error.event.kind == "strain_limit"
    assert bending_strains(error.last).max() == pytest.approx(0.005, rel=1e-6)
    beyond = error.last.motors + 1e-3 * (np.array([4.5, -1.5]) - solve_home(robot).motors)
    free = load_robot("rfrfr")
    assert bending_strains(solve_forward(free, beyond)).max() > 0.005


def test_a_time_limit_is_kept_and_says_how_far_it_came():
    """No time at all: how long anything takes does not matter to the test."""
    robot = load_robot("six_rfs")
    with pytest.raises(TimeLimitExceeded, match="the time allowed was over") as caught:
        solve_forward(robot, solve_home(robot).motors + 1.0, time_limit=0.0)
    assert caught.value.fraction == 0.0
    assert caught.value.event.kind == "time_limit"
    assert caught.value.last is solve_home(robot)
    solve_forward(robot, solve_home(robot).motors + 0.1, time_limit=600.0)
    for wrong in (-1.0, np.nan):
        with pytest.raises(InvalidRequest, match="time_limit: expected a time"):
            solve_forward(robot, solve_home(robot).motors + 0.1, time_limit=wrong)


def test_stable_only_starts_from_something_stable():
    robot = load_robot("rfrfr")
    unstable = solve_inverse(robot, [0.0, -0.2], start=solve_inverse(robot, [0.0, 0.8]))
    with pytest.raises(UnstableEquilibrium, match="the start is unstable"):
        solve_inverse(robot, [0.0, -0.3], start=unstable, stable_only=True)


def test_loads_without_potential_decide_no_stability():
    robot = load_robot("six_rfs")
    turning = Loads.none().with_(wrench_world=[0, 0, 0.01, 0, 0, 0])
    equilibrium = solve_forward(robot, solve_home(robot).motors + 0.1, loads=turning)
    assert equilibrium.converged
    with pytest.raises(UnstableEquilibrium, match="not decided by energy"):
        solve_forward(robot, solve_home(robot).motors + 0.1, loads=turning, stable_only=True)


def test_starts_of_another_robot_are_refused():
    with pytest.raises(InvalidRequest, match="same robot"):
        solve_forward(load_robot("rfrfr"), [2.6, 0.5], start=solve_home(load_robot("rfrfr")))


@pytest.mark.parametrize("efforts", [[0.0475613, 0.59519384], [-0.05443538, -0.30131647]])
def test_a_step_does_not_jump_over_two_folds_to_the_next_stable_part_of_the_branch(efforts):
    # Beyond the two folds stable equilibria go on, with the same index: only their distance tells.
    robot = load_robot("rfrfr")
    ends = []
    for requests in (1, 100):
        first, equilibrium = solve_home(robot).efforts, solve_home(robot)
        with pytest.raises(NotReached) as stopped:
            for number in range(1, requests + 1):
                fraction = number / requests
                target = (1.0 - fraction) * first + fraction * np.array(efforts)
                equilibrium = solve_forward_by_effort(robot, target, start=equilibrium)
        assert stopped.value.event.kind == "fold"
        ends.append(stopped.value.event.equilibrium)
    assert distance(*ends) < 1e-3


@pytest.mark.parametrize("name", ["rfrfr", "planar_body"])
def test_a_request_just_before_a_fold_is_reached(name):
    # The branch turns back a millionth of the way behind the target.
    robot = load_robot(name)
    home = solve_home(robot)
    pose = home.pose
    pose[0] += 3.0
    with pytest.raises(NotReached) as stopped:
        solve_inverse(robot, pose)
    assert stopped.value.event.kind == "fold"
    fold = stopped.value.event.equilibrium
    for before in (1e-3, 1e-5, 1e-6, 1e-7):
        fraction = stopped.value.event.fraction * (1.0 - before)
        target = (1.0 - fraction) * home.pose + fraction * pose
        reached = solve_inverse(robot, target)
        assert np.abs(reached.pose - target).max() < 1e-9
        assert distance(reached, fold) < 40.0 * np.sqrt(before)


def straight_to(robot, force, last, requests):
    """Motors from home on, all to the same position in equal steps, and the robot pushed at home."""
    home = solve_home(robot)
    loads = robot.default_loads.with_(wrench_world=[0.0, 0.0, 0.0, *force])
    start = solve_forward(robot, home.motors, loads=loads)
    parts = np.arange(1, requests + 1)[:, None] / requests
    return start, (1.0 - parts) * start.motors + parts * np.full(robot.motor_count, last)


@pytest.mark.parametrize("requests", [1, 4, 5, 7, 10])
def test_a_step_behind_a_tight_bend_does_not_lead_to_the_other_arm_of_a_fold(requests):
    """In five requests it was reached, on a branch that does not lead there."""
    force = [-0.13998033694556347, -0.031112230289479334, -0.025078292555498448]
    start, rows = straight_to(four_legs(), force, 4.417350412866821, requests)
    through = trace_through(start.robot, motors=rows, start=start)
    assert not through.reached
    assert through.stopped.kind == "fold"
    assert through.stopped.fraction == pytest.approx(0.9438762570, abs=1e-8)
    last = start
    with pytest.raises(NoForwardSolution) as refused:
        for row in rows:
            last = solve_forward(start.robot, row, start=last)
    assert refused.value.event.kind == "fold"
    assert distance(refused.value.last, through.last) < 1e-3  # of a fold, where anything moves far


@pytest.mark.parametrize("requests", [1, 4, 7])
def test_a_step_does_not_jump_over_two_folds_that_are_near_in_the_motors(requests):
    """The branch turns back and forth again within 1e-5 of the way; four requests went past both."""
    robot, force = load_robot("three_rfr_hubs"), [-0.13462270631599219, 0.11765082589908249, 0.0]
    last = solve_home(robot).motors[0] - 1.5459707398328082
    start, rows = straight_to(robot, force, last, requests)
    through = trace_through(robot, motors=rows, start=start)
    assert through.stopped.kind == "fold"
    assert through.stopped.fraction == pytest.approx(0.894662, abs=1e-6)
    beyond = trace(robot, motors=rows[-1], start=start, points=5, past_folds=True)
    folds = [event for event in beyond.events if event.kind == "fold"]
    changes = [(event.index_before, event.index_after) for event in folds[:3]]
    assert changes == [(0, 1), (1, 0), (0, 1)]
    assert folds[1].fraction == pytest.approx(folds[0].fraction, abs=2e-5)


@pytest.mark.parametrize("requests", [1, 3, 4, 5, 7])
def test_an_event_begins_with_the_index_that_the_walk_has(requests):
    """One of a branch near by ended some of these, from index 1 to 0, where index 0 had led."""
    force = [-0.0011952903577967576, 0.013586565179592485, 0.014585986283372617]
    robot = load_robot("three_rfs")
    last = solve_home(robot).motors[0] - 1.0155121172822252
    start, rows = straight_to(robot, force, last, requests)
    through = trace_through(robot, motors=rows, start=start)
    assert through.reached
    assert [event.kind for event in through.events] == ["singularity", "singularity"]


@pytest.mark.parametrize("requests", [6, 7, 14])
def test_what_another_branch_does_beside_this_one_is_no_event_of_this_one(requests):
    """Seven requests ended at a fold from index 1 to 0, though index 0 had led there."""
    force = [0.20791098900107377, 0.013011287847761066, -0.2759277128171896]
    start, rows = straight_to(load_robot("three_rfs"), force, 4.331341732527697, requests)
    through = trace_through(start.robot, motors=rows, start=start)
    assert through.reached
    assert {event.kind for event in through.events} == {"singularity"}
    assert through.indices_locked.max() == 0
    single = solve_forward(start.robot, rows[-1], start=start)
    assert distance(single, through.last) < 1e-8
