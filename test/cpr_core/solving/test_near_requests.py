# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Requests near by are served by the compiled near path, and all agree on what is near."""

from itertools import product

import numpy as np
import pytest
from helpers.bordered_index import index_by_eigenvalues
from helpers.shipped_steps import SHORT_FORM, STEPS
from helpers.yaml_content import shipped_content
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.near_requests import is_walked, straight_stewart_gough, walk_near
from benchmarks.walks import PROBLEMS, SOLVERS, walk_of
from cpr_core import (
    Loads,
    MotorLimitExceeded,
    NotReached,
    UnstableEquilibrium,
    load_robot,
    solve_forward,
    solve_forward_by_effort,
    solve_home,
    solve_inverse,
    trace_through,
)
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernels.condensation_kernel import DELAYED
from cpr_core.kernels.continuation_kernel import FREELY, UNPREDICTED, WATCHED
from cpr_core.kernels.kept_factors import kept_factors
from cpr_core.kernels.natural_units import EFFORT_UNIT, LONGEST_STEP
from cpr_core.kernels.prepared_robot import continue_prepared
from cpr_core.kernels.problems import PROBLEMS as NUMBERS
from cpr_core.kernels.record_layout import (
    IMPOSED_MOTORS,
    INDEX_FREE,
    INDEX_LOCKED,
    INVERSE_SIGN,
    SIGNS,
)
from cpr_core.kernels.record_layout import STEPS as STEPS_TAKEN
from cpr_core.kernels.square_problem import Tolerances
from cpr_core.lie import rotation_exp
from cpr_core.model.equilibrium_records import new_record
from cpr_core.model.equilibrium_steps import stepped, stepped_twice
from cpr_core.solving.continuation import follow
from cpr_core.solving.near_request import ALONE, solve_near
from cpr_core.solving.path import Path
from cpr_core.solving.requests import target_of
from cpr_core.solving.targets import EffortTarget, MotorTarget, PoseTarget


def walks_among(robot, problem, count):
    """How many of random small steps are not served by the near path."""
    walked = 0

    def solve(start, request):
        nonlocal walked
        walked += is_walked(start, problem, request)
        return SOLVERS[problem](robot, request, start=start)

    walk_near(robot, problem, count, solve)
    return walked


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("modes", [3, 5, 12])
@pytest.mark.parametrize("name", shipped_robots())
def test_near_requests_need_no_walk(name, modes, problem):
    robot = load_robot(name, modes=modes)
    needed = 40 if problem == "inverse" and robot.redundancy > 0 else 0
    assert walks_among(robot, problem, 40) == needed


@pytest.fixture(scope="module", params=[3, 4, 5, 12])
def straight(request):
    return load_robot(straight_stewart_gough(), modes=request.param)


def delayed(equilibrium):
    """Whether some slot of a leg was left to the border there."""
    return equilibrium.factors["lane"][0, 0] == DELAYED


def test_straight_legs_need_no_walk_either(straight):
    assert delayed(solve_home(straight))
    assert walks_among(straight, "inverse", 100) == 0


def test_signs_with_delayed_slots_are_those_of_the_eigenvalues(straight):
    """Also where a load has bent the legs out, or made the robot unstable."""
    found, force = 0, straight.kernel_arrays.energy_unit / straight.mean_length
    for factor in (0.0, 1e-3, -1e-3, 0.1):
        loads = Loads.none().with_(wrench_world=[0, 0, 0, factor * force, 0, 0])
        equilibrium = solve_forward(straight, solve_home(straight).motors, loads=loads)
        assert (
            equilibrium.index_locked
            == index_by_eigenvalues(equilibrium)
            == equilibrium.spectrum_locked.index
        )
        assert equilibrium.index_free == equilibrium.spectrum_free.index
        found += delayed(equilibrium)
    assert found > 0


def test_predictions_from_delayed_slots_are_used(straight):
    """Half as far, a quarter is left to correct: a start that is not predicted needs more steps."""
    home = solve_home(straight)
    pose = np.append(home.platform_position, home.platform_quaternion)
    pose[:3] += 1e-4 * np.array([1.0, 0.5, 0.2])
    near = solve_inverse(straight, pose, start=home)
    target, steps = target_of(home, "pose", pose), {}
    for mode in (FREELY, UNPREDICTED):
        records, kept = new_record(straight, 1), kept_factors(straight.kernel_arrays)
        made = continue_prepared(
            straight.prepared,
            home.load_arrays,
            NUMBERS["pose"],
            target.given(home),
            mode,
            *Tolerances(),
            home.record,
            home.factors,
            records,
            kept,
        )
        assert made == 1
        steps[mode] = records[0, straight.state_size + STEPS_TAKEN]
    assert near.iterations == steps[FREELY] < steps[UNPREDICTED]


def test_predictions_do_not_depend_on_what_was_evaluated_last(straight):
    """Factors with delayed slots are not kept: the tangent of the start is evaluated again."""
    home = solve_home(straight)
    pose = np.append(home.platform_position, home.platform_quaternion)
    pose[:3] += 1e-4 * np.array([1.0, 0.5, 0.2])
    first = solve_inverse(straight, pose, start=home)
    elsewhere = 0.1 * straight.motor_units * np.array([1.0, -1.0, 0.5, 0.3, -0.2, 0.7])
    solve_forward(straight, home.motors + elsewhere, start=home)
    again = solve_inverse(straight, pose, start=home)
    np.testing.assert_array_equal(again.record, first.record)


@pytest.fixture(scope="module", params=[*SHORT_FORM, "delta", "three_prs"])
def robot(request):
    return load_robot(request.param)


def taken_as_near(start, target):
    """Whether the kernel tries a request in one watched step."""
    robot = start.robot
    records, kept = new_record(robot, 1), kept_factors(robot.kernel_arrays)
    records[:] = np.nan
    continue_prepared(
        robot.prepared,
        start.load_arrays,
        NUMBERS[target.problem],
        target.given(start),
        WATCHED,
        *Tolerances(),
        start.record,
        start.factors,
        records,
        kept,
    )
    return bool(np.isfinite(records[0, 0]))


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**31), st.floats(0.2, 0.8))
def test_kernel_and_targets_agree_on_what_is_near(robot, seed, distance):
    random = np.random.default_rng(seed)
    start, count = solve_home(robot), robot.motor_count
    direction = random.uniform(-1.0, 1.0, count)
    direction *= distance / np.abs(direction).max()
    turn, moved = random.normal(size=3), random.uniform(-1.0, 1.0, 3)
    if robot.planar:
        turn[:2] = moved[2] = 0.0
    turn *= random.uniform() * distance / np.linalg.norm(turn)
    moved *= random.uniform() * distance * robot.mean_length / np.abs(moved).max()
    efforts = EFFORT_UNIT * robot.kernel_arrays.energy_unit * direction / robot.motor_units
    for target in (
        MotorTarget(start.motors + robot.motor_units * direction),
        EffortTarget(start.efforts + efforts),
        PoseTarget(rotation_exp(turn) @ start.platform_rotation, start.platform_position + moved),
    ):
        if isinstance(target, PoseTarget):  # what is not controlled is not read
            given = target.given(start)[0]
            target = PoseTarget(given[:9].reshape(3, 3), given[9:12])
        far = target.distance(start)
        if abs(far - LONGEST_STEP) > 1e-9:
            assert taken_as_near(start, target) == (far < LONGEST_STEP), target.problem


def steps_made(start, target, record, given):
    """How many watched steps the kernel makes towards a target, from a record of the start."""
    robot = start.robot
    return continue_prepared(
        robot.prepared,
        start.load_arrays,
        NUMBERS[target.problem],
        given,
        WATCHED,
        *Tolerances(),
        record,
        start.factors,
        new_record(robot, 1),
        kept_factors(robot.kernel_arrays),
    )


@pytest.mark.parametrize(
    ("problem", "watched"),
    [
        ("motors", {INDEX_LOCKED}),
        ("efforts", {INDEX_FREE}),
        ("pose", {INDEX_LOCKED, INVERSE_SIGN}),
    ],
)
def test_a_watched_step_ends_where_a_sign_that_counts_has_changed(problem, watched):
    home = solve_home(load_robot("six_rfs"))
    target = target_of(home, problem, getattr(home, problem))
    given = target.given(home)
    assert steps_made(home, target, home.record, given) == 1
    for sign in (INDEX_LOCKED, INDEX_FREE, INVERSE_SIGN):
        record = home.record.copy()
        record[home.robot.state_size + SIGNS + sign] -= 2.0
        assert steps_made(home, target, record, given) == (sign not in watched), sign


def test_motors_that_a_pose_leaves_unknown_are_not_read(robot):
    home = solve_home(robot)
    target = target_of(home, "pose", home.pose)
    given = target.given(home).copy()
    given[0, IMPOSED_MOTORS:] = np.nan
    assert steps_made(home, target, home.record, given) == 1


def test_loads_are_as_far_as_efforts_of_the_same_size(robot):
    start, size = solve_home(robot), 0.3 * robot.kernel_arrays.energy_unit
    effort = EffortTarget(start.efforts + size / robot.motor_units)
    loads = start.loads.with_(wrench_world=[0.0, 0.0, size, 0.0, 0.0, 0.0])
    if robot.description.point_platform:
        loads = start.loads.with_(wrench_world=[0.0, 0.0, 0.0, size / robot.mean_length, 0.0, 0.0])
    path = Path(start, MotorTarget(start.motors + STEPS[robot.description.name]), loads)
    assert path.load_distance == pytest.approx(effort.distance(start), rel=1e-9)


def sliding_twice():
    """Two of its three motors do the same: every place is an inverse singularity."""

    def slide(motor, ratio):
        return {"joint": "prismatic", "axis": [1, 0, 0], "motor": motor, "ratio": ratio}

    first = {
        "base": {"position": [0, 0, 0], "tangent": [0, 1, 0]},
        "chain": [slide("motor1", 1.0), slide("motor2", 0.6), {"rod": {}}],
        "tip": {"type": "revolute", "position": [-0.05, 0, 0]},
    }
    second = {
        "base": {"position": [0.1, 0, 0], "tangent": [0, 1, 0]},
        "motor": {"type": "revolute", "axis": [0, 0, 1], "name": "motor3"},
        "tip": {"type": "revolute", "position": [0.05, 0, 0]},
    }
    content = {
        "name": "sliding_twice",
        "space": "planar",
        "rod": {
            "length": 0.4,
            "section": {"shape": "circular", "radius": 0.001},
            "young_modulus": 210e9,
            "shear_modulus": 82e9,
        },
        "strain": {"bending_3": 5},
        "platform": {"shape": "body"},
        "legs": [first, second],
        "controlled": ["x", "y", "angle"],
        "home": {"motors": [0, 0, 1.2], "platform": {"position": [-0.15, 0.33, 0]}},
    }
    return load_robot(content)


@pytest.mark.parametrize("seed", range(5))
def test_rounding_of_a_pose_moves_no_motor_at_an_inverse_singularity(seed):
    """Divided by a singular value of 1e-18 it moved two of them by metres, one against the other."""
    robot, random = sliding_twice(), np.random.default_rng(seed)
    home = solve_home(robot)
    start = solve_forward(robot, home.motors + 0.02 * random.uniform(-1.0, 1.0, 3), start=home)
    for size in (0.0, 1e-17, 1e-16, -1e-16, 3e-15):
        pose = start.pose + size * random.uniform(-1.0, 1.0, 3)
        found = solve_inverse(robot, pose, start=start)
        np.testing.assert_allclose(found.motors, start.motors, rtol=0.0, atol=1e-12)
    for size in (1e-8, 1e-4):
        with pytest.raises(NotReached):
            solve_inverse(robot, start.pose + [size, 0.0, 0.0], start=start)


@pytest.mark.parametrize(("way", "near"), [(0.045, True), (0.055, False)])
def test_by_effort_motors_have_to_be_near(way, near):
    """Between ends that are far apart a limit may be passed and kept again."""
    home = solve_home(load_robot("three_rfs"))
    ahead = solve_forward(home.robot, home.motors + [way, 0.0, 0.0], start=home)
    target = EffortTarget(ahead.efforts)
    assert (solve_near(home, target, stable_only=False) is not None) == near
    reached = solve_forward_by_effort(home.robot, ahead.efforts, start=home)
    assert reached.motors == pytest.approx(ahead.motors, abs=1e-7)


def test_efforts_themselves_need_not_be_near():
    """Columns hardly move by large ones."""
    walk = walk_of("gough_stewart", 5, "by effort")
    target = EffortTarget(walk.requests[0])
    assert target.distance(walk.start) > ALONE * LONGEST_STEP
    found = solve_near(walk.start, target, stable_only=True)
    assert found is not None
    assert np.abs(found.motors - walk.start.motors).max() < 2e-3 * found.robot.mean_length


def pushed_by(robot, random):
    """At home under a wrench in the axes of the platform: it has no potential."""
    unit = 0.2 * robot.kernel_arrays.energy_unit
    wrench = random.normal(size=6) * unit * np.array([1.0] * 3 + [1.0 / robot.mean_length] * 3)
    wrench *= (
        [0.0, 0.0, not robot.description.point_platform, 1.0, 1.0, 0.0] if robot.planar else 1.0
    )
    loads = robot.default_loads.with_(wrench_body=wrench)
    return solve_forward(robot, solve_home(robot).motors, loads=loads)


@pytest.mark.parametrize(
    ("problem", "energetic"), [("motors", True), ("pose", True), ("pose", False)]
)
def test_what_is_looked_at_halfway_is_what_a_walk_finds(problem, energetic):
    """Whether it arrives, where, and that nothing is passed on the way."""
    robots, random = [load_robot(name) for name in shipped_robots()], np.random.default_rng(3)
    found, sizes = dict.fromkeys(robots, 0), np.geomspace(0.03, 0.6, 40)
    starts = {
        robot: solve_home(robot) if energetic else pushed_by(robot, random) for robot in robots
    }
    for robot, (number, size) in product(robots, enumerate(sizes)):
        home = starts[robot]
        change = random.uniform(-1.0, 1.0, robot.motor_count) * robot.motor_units
        try:
            ahead = solve_forward(robot, home.motors + size * LONGEST_STEP * change, start=home)
        except NotReached:
            continue
        target = target_of(home, problem, getattr(ahead, problem))
        stable_only = energetic and number % 2 == 0
        near = solve_near(home, target, stable_only)
        if near is None or not ALONE < target.distance(home) / LONGEST_STEP <= 1.0:
            continue
        found[robot] += 1
        walk = follow(home, target, home.loads, stable_only=stable_only)
        assert walk.arrived
        assert not walk.events
        assert near.motors == pytest.approx(walk.last.motors, abs=1e-8)
        assert near.platform_position == pytest.approx(walk.last.platform_position, abs=1e-8)
        assert near.signs == walk.last.signs
    assert sum(count > 3 for count in found.values()) >= 7, found


def limited_to(*position):
    """The home of rfrfr whose first motor is kept between these."""
    content = shipped_content("rfrfr")
    content["legs"][0]["motor"]["limits"] = {"position": [*map(float, position)]}
    return solve_home(load_robot(content))


@pytest.mark.parametrize("part", [0.25, 0.75])
def test_a_limit_is_kept_in_either_half(part):
    free = solve_home(load_robot("rfrfr"))
    ahead = solve_forward(free.robot, free.motors + [0.4, 0.15])
    home = limited_to(-10.0, free.motors[0] + part * 0.4)
    assert ALONE < target_of(home, "pose", ahead.pose).distance(home) / LONGEST_STEP < 1.0
    with pytest.raises(MotorLimitExceeded, match="motor1: position"):
        solve_inverse(home.robot, ahead.pose, start=home)


def test_a_limit_that_is_come_to_faster_and_faster_is_kept():
    """Half of the way to it is left in the middle, and it is passed at the end."""
    free = solve_home(load_robot("rfrfr"))
    beyond = solve_forward(free.robot, free.motors - [0.02, 0.0])
    home = limited_to(free.motors[0] - 0.01, 10.0)
    start = solve_forward(home.robot, home.motors + [0.41, 0.15])
    with pytest.raises(MotorLimitExceeded, match="motor1: position"):
        solve_inverse(home.robot, beyond.pose, start=start)


@pytest.mark.parametrize(("change", "near"), [(0.004, True), (0.012, False)])
def test_a_limit_that_comes_near_as_fast_as_that_is_left_to_a_walk(change, near):
    free = solve_home(load_robot("rfrfr"))
    ahead = solve_forward(free.robot, free.motors + [change, 0.0])
    home = limited_to(-10.0, free.motors[0] + 0.02)
    assert (solve_near(home, target_of(home, "pose", ahead.pose), False) is not None) == near


def test_newton_steps_of_both_halves_count():
    home = solve_home(load_robot("rfrfr"))
    middle = solve_inverse(home.robot, home.pose + [0.045, 0.03], start=home)
    last = solve_inverse(home.robot, home.pose + [0.09, 0.06], start=middle)
    whole = solve_inverse(home.robot, last.pose, start=home)
    assert middle.iterations < whole.iterations <= middle.iterations + last.iterations
    halves = trace_through(home.robot, poses=[middle.pose, last.pose], start=home)
    assert whole.iterations == sum(half.iterations for half in halves.equilibria)


@pytest.mark.parametrize("problem", ["motors", "pose"])
@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "gough_stewart"])
def test_two_steps_in_one_call_are_those_one_after_the_other(name, problem):
    robot = load_robot(name)
    start = solve_home(robot)
    ahead = solve_forward(robot, start.motors + 0.1 * LONGEST_STEP * robot.motor_units)
    target = target_of(start, problem, getattr(ahead, problem))
    rows, steps = (target.given(start, 0.5), target.given(start)), 0
    for found, row in zip(stepped_twice(start, problem, np.vstack(rows)), rows, strict=True):
        start = stepped(start, robot, start.loads, start.load_arrays, problem, row, WATCHED)
        assert start.iterations <= found.iterations <= (steps := steps + start.iterations)
        np.testing.assert_allclose(found.configuration, start.configuration, atol=1e-8)
        np.testing.assert_allclose(found.efforts, start.efforts, atol=1e-8)
        assert found.signs == start.signs
        # From the kept factors of either step.
        unit = np.abs(start.response.matrix).max()
        np.testing.assert_allclose(
            found.response.matrix / unit, start.response.matrix / unit, atol=1e-8
        )


def test_stability_that_energy_does_not_decide_is_not_taken_for_granted():
    home = solve_home(load_robot("three_rfs"))
    loads = home.loads.with_(wrench_world=[0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
    start = solve_forward(home.robot, home.motors, loads=loads)
    assert start.index_locked == 0
    with pytest.raises(UnstableEquilibrium, match="not decided by energy"):
        solve_forward(home.robot, start.motors + 1e-3, start=start, stable_only=True)


def test_by_effort_stable_means_with_motors_that_give_way():
    home = solve_home(load_robot("delta"))
    assert (home.index_locked, home.index_free) == (0, 1)
    efforts = 1.0001 * home.efforts
    solve_forward_by_effort(home.robot, efforts, start=home)
    with pytest.raises(UnstableEquilibrium, match="the start is unstable, index 1"):
        solve_forward_by_effort(home.robot, efforts, start=home, stable_only=True)
