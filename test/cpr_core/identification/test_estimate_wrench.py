# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Wrenches that are felt against those that were put on, in exact and in noisy measurements."""

import numpy as np
import pytest
from helpers.rigid_leg import rigid_leg
from helpers.shipped_steps import STEPS
from numpy.testing import assert_allclose

from cpr_core import NotReached, estimate_wrench, load_robot, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.identification import wrench_search
from cpr_core.model.world_response import wrench_units

ROBOTS = list(shipped_robots())
#: Robots whose motors feel every wrench, and whose pose does.
BY_EFFORTS = ["six_rfs", "rfrfr", "six_rus", "four_rfr"]
DEVIATION = (1e-4, 1e-3)


def pushed(name, size=0.2, seed=3):
    """An equilibrium away from home under a wrench, and the wrench."""
    robot = load_robot(name)
    home = solve_home(robot)
    rng, wrench = np.random.default_rng(seed), np.zeros(6)
    units = wrench_units(home.robot)
    wrench[robot.platform_axes] = size * units * rng.uniform(-1.0, 1.0, len(units))
    loads = robot.default_loads.with_(wrench_world=robot.default_loads.wrench_world + wrench)
    at = home.motors + 0.3 * np.array(STEPS[name])
    return solve_forward(robot, at, start=home, loads=loads), wrench


def pose_of(equilibrium):
    return np.concatenate([equilibrium.platform_position, equilibrium.platform_quaternion])


def one_percent(equilibrium):
    return 0.01 * np.abs(equilibrium.efforts) + 1e-4 * np.abs(equilibrium.efforts).max()


@pytest.mark.parametrize("name", BY_EFFORTS)
def test_exact_efforts_tell_the_wrench(name):
    true, wrench = pushed(name)
    found = estimate_wrench(
        true.robot, true.motors, efforts=true.efforts, effort_deviation=one_percent(true)
    )
    assert_allclose(found.wrench_world, wrench, rtol=0, atol=1e-9)
    assert len(found.felt) == len(true.robot.platform_axes) and not len(found.unfelt)
    assert 0.0 < found.observability < 1.0
    assert found.words == "all of the wrench is felt"
    assert_allclose(found.equilibrium.platform_position, true.platform_position, atol=1e-6)


@pytest.mark.parametrize("name", [*BY_EFFORTS, "three_rfs", "delta"])
def test_an_exact_pose_tells_the_wrench(name):
    """Also where a few motors do not feel it."""
    true, wrench = pushed(name, 0.05)
    found = estimate_wrench(true.robot, true.motors, pose=pose_of(true), pose_deviation=DEVIATION)
    assert not len(found.unfelt) and found.degrees_of_freedom == 0
    assert_allclose(found.wrench_world, wrench, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_an_exact_pose_and_efforts_tell_the_wrench(name):
    """Whatever is felt: measurements that leave nothing over are explained by no other wrench."""
    true, wrench = pushed(name, 0.05)
    robot = true.robot
    found = estimate_wrench(
        robot,
        true.motors,
        efforts=true.efforts,
        effort_deviation=one_percent(true),
        pose=pose_of(true),
        pose_deviation=DEVIATION,
    )
    if not len(found.unfelt):
        assert_allclose(found.wrench_world, wrench, rtol=0, atol=1e-9)
        assert found.chi_square < 1e-6 and found.consistency > 0.99
        assert found.degrees_of_freedom == robot.motor_count
    size = len(robot.platform_axes)
    assert len(found.felt) + len(found.unfelt) == size
    both = np.vstack([found.felt, found.unfelt]) / [*[robot.mean_length] * 3, 1, 1, 1]
    assert_allclose(both @ both.T, np.eye(size), atol=1e-12)


def test_what_the_last_step_takes_up_is_not_left():
    """Exact measurements leave nothing, however small their deviations: some 3 with stiff rods."""
    robot = load_robot("six_rfs").with_parameters({"rod.section.radius": 0.01})
    random, true = np.random.default_rng(1), solve_home(robot)
    wrench = random.normal(0.0, 0.1, 6) * robot.wrench_units
    loads, motors = robot.default_loads.with_(wrench_world=wrench), true.motors
    found = true = solve_forward(robot, motors, loads=loads)
    for _ in range(6):
        motors = motors + random.uniform(-2e-3, 2e-3, 6)
        true = solve_forward(robot, motors, loads=loads, start=true)
        found = estimate_wrench(
            robot,
            true.motors,
            start=found,
            efforts=true.efforts,
            effort_deviation=1e-2,
            pose=[*true.platform_position, *true.platform_quaternion],
            pose_deviation=(1e-5, 1e-4),
        )
        assert found.degrees_of_freedom == 6 and found.chi_square < 1e-3


def test_a_robot_whose_platform_a_rigid_leg_holds_feels_the_wrench():
    """Its compliance is singular; the next estimate steps along the way of the motors too."""
    robot, wrench = rigid_leg(), np.array([0.0, 0.0, 0.01, 0.1, 0.2, 0.0])
    home, loads = solve_home(robot), robot.default_loads.with_(wrench_world=wrench)
    last = None
    for step in (0.0, 0.01):
        true = solve_forward(robot, home.motors + [step, -step, 0.1 * step], loads=loads)
        last = estimate_wrench(
            robot,
            true.motors,
            efforts=true.efforts,
            effort_deviation=1e-4,
            pose=pose_of(true),
            pose_deviation=DEVIATION,
            start=last,
        )
        assert_allclose(last.wrench_world, wrench, rtol=0, atol=1e-9)
        assert last.words == "all of the wrench is felt"


def test_a_changing_wrench_is_followed_while_the_motors_move():
    """From estimate to estimate, each as exact as one from home."""
    true, _ = pushed("six_rfs")
    robot, last = true.robot, None
    for step in range(40):
        angle = 0.15 * step
        turned = 0.1 * np.array([0.1 * np.sin(angle), 0, 0.05, np.cos(angle), 0.4, np.sin(angle)])
        loads = robot.default_loads.with_(wrench_world=turned)
        true = solve_forward(robot, true.motors + 0.003, start=true, loads=loads)
        last = estimate_wrench(
            robot, true.motors, efforts=true.efforts, effort_deviation=0.01, start=last
        )
        assert_allclose(last.wrench_world, turned, rtol=0, atol=1e-9)


def test_an_estimate_goes_on_from_the_last_in_one_solve_or_two(monkeypatch):
    """Also while the motors move: what the last one told says where to."""
    true, wrench = pushed("six_rfs")
    robot, calls = true.robot, {"pushed_equilibrium": 0, "world_response": 0}

    def counting(name):
        wrapped = getattr(wrench_search, name)

        def count(*arguments):
            calls[name] += 1
            return wrapped(*arguments)

        return count

    last = estimate_wrench(robot, true.motors, efforts=true.efforts, effort_deviation=0.01)
    for name in calls:
        monkeypatch.setattr(wrench_search, name, counting(name))
    for step in range(1, 11):
        loads = robot.default_loads.with_(wrench_world=(1.0 + 0.02 * step) * wrench)
        true = solve_forward(robot, true.motors + 0.01, start=true, loads=loads)
        before = dict(calls)
        last = estimate_wrench(
            robot, true.motors, efforts=true.efforts, effort_deviation=0.01, start=last
        )
        assert calls["pushed_equilibrium"] - before["pushed_equilibrium"] <= 2
        assert calls["world_response"] - before["world_response"] == 1


def test_one_step_of_a_large_wrench_is_found_from_the_last_estimate():
    weak, _ = pushed("six_rfs", 0.01)
    strong, wrench = pushed("six_rfs", 0.5)  # of another robot object, which has the same numbers
    first = estimate_wrench(weak.robot, weak.motors, efforts=weak.efforts, effort_deviation=0.01)
    found = estimate_wrench(
        weak.robot, strong.motors, efforts=strong.efforts, effort_deviation=0.01, start=first
    )
    assert_allclose(found.wrench_world, wrench, rtol=0, atol=1e-9)


def test_what_acts_beside_it_is_not_counted():
    """A load that is known is no part of the wrench, and the next estimate knows it too."""
    true, wrench = pushed("six_rfs")
    robot = true.robot
    known = robot.default_loads.with_(wrench_world=0.25 * wrench)
    given = {"efforts": true.efforts, "effort_deviation": 0.01}
    found = estimate_wrench(robot, true.motors, **given, loads=known)
    assert_allclose(found.wrench_world, 0.75 * wrench, rtol=0, atol=1e-9)
    again = estimate_wrench(robot, true.motors, **given, start=found)
    assert_allclose(again.wrench_world, 0.75 * wrench, rtol=0, atol=1e-9)
    assert again.loads is known
    whole = estimate_wrench(robot, true.motors, **given, start=again, loads=robot.default_loads)
    assert_allclose(whole.wrench_world, wrench, rtol=0, atol=1e-9)


def test_the_wrench_in_the_axes_of_the_platform():
    true, wrench = pushed("six_rfs")
    found = estimate_wrench(true.robot, true.motors, efforts=true.efforts, effort_deviation=0.01)
    rotation = true.platform_rotation
    turned = np.concatenate([rotation @ found.wrench_body[:3], rotation @ found.wrench_body[3:]])
    assert_allclose(turned, wrench, atol=1e-9)


@pytest.mark.parametrize("with_pose", [False, True], ids=["efforts", "both"])
def test_errors_are_those_of_the_covariance(with_pose):
    """500 draws of 1 % noise: errors by covariance are a chi-square, and so is what is left."""
    true, wrench = pushed("six_rfs")
    robot, rng = true.robot, np.random.default_rng(5)
    deviation, found = 0.01 * np.abs(true.efforts), None
    errors, left = [], []
    for _ in range(500):
        efforts = true.efforts + deviation * rng.normal(size=robot.motor_count)
        given = {"efforts": efforts, "effort_deviation": deviation}
        if with_pose:
            moved = true.platform_position + DEVIATION[0] * rng.normal(size=3)
            turned = turned_by(true.platform_quaternion, DEVIATION[1] * rng.normal(size=3))
            given |= {"pose": np.concatenate([moved, turned]), "pose_deviation": DEVIATION}
        found = estimate_wrench(robot, true.motors, **given, start=found)
        error = found.wrench_world - wrench
        errors.append(error @ np.linalg.solve(found.covariance, error))
        left.append(found.chi_square)
    from scipy import stats  # takes long to import: not for every worker of the tests

    assert stats.kstest(errors, stats.chi2(6).cdf).pvalue > 0.01
    if with_pose:
        assert found.degrees_of_freedom == 6
        assert stats.kstest(left, stats.chi2(6).cdf).pvalue > 0.01
    else:
        assert found.degrees_of_freedom == 0 and not any(left)


def turned_by(quaternion, vector):
    """A quaternion turned in the world by a small rotation vector."""
    half = 0.5 * np.asarray(vector)
    w, x = quaternion[0], quaternion[1:]
    turned = np.concatenate([[w - half @ x], x + w * half + np.cross(half, x)])
    return turned / np.linalg.norm(turned)


def test_three_motors_feel_three_directions_and_the_others_are_named():
    true, wrench = pushed("three_rfs")
    robot = true.robot
    found = estimate_wrench(
        robot, true.motors, efforts=true.efforts, effort_deviation=one_percent(true)
    )
    assert found.felt.shape == (3, 6) and found.unfelt.shape == (3, 6)
    assert found.observability == 0.0
    assert found.words.startswith("a moment about z is not felt; a moment about x, ")
    assert found.words.endswith("are not felt separately: 2 ways of combining them are not felt")
    # What is felt explains the efforts, of all such wrenches the smallest.
    assert_allclose(found.equilibrium.efforts, true.efforts, atol=1e-8)
    scale = np.array([*[robot.mean_length] * 3, 1, 1, 1])
    assert_allclose(found.unfelt / scale @ (found.wrench_world / scale), 0.0, atol=1e-8)
    size = np.linalg.norm(wrench / scale)
    assert np.linalg.norm(found.wrench_world / scale) < size
    # An unfelt wrench leaves the efforts as they are, a felt one does not.
    units = robot.kernel_arrays.energy_unit / robot.mean_length
    for direction, felt in [(found.unfelt[0], False), (found.felt[0], True)]:
        more = found.equilibrium.loads.with_(
            wrench_world=found.equilibrium.loads.wrench_world + 1e-4 * units * direction
        )
        other = solve_forward(robot, true.motors, start=found.equilibrium, loads=more)
        change = np.abs(other.efforts - found.equilibrium.efforts).max()
        assert (change > 1e-6 * units * robot.mean_length) == felt


@pytest.mark.parametrize(("name", "size"), [("three_rfs", 0.4), ("three_prs", 0.4), ("delta", 0.6)])
def test_the_smallest_wrench_is_found_where_few_motors_feel_it(name, size):
    """Steps went around it, and it was said that no stable equilibrium goes on."""
    robot = load_robot(name)
    home, rng = solve_home(robot), np.random.default_rng(5)
    units = wrench_units(robot)
    for _ in range(12):
        motors = home.motors + rng.uniform(-0.2, 0.2, 3) * robot.motor_units
        wrench = np.concatenate([np.zeros(3), size * rng.uniform(-1.0, 1.0, 3)]) * units
        loads = robot.default_loads.with_(wrench_world=wrench)
        true = solve_forward(robot, motors, start=home, loads=loads)
        deviation = 1e-3 * np.abs(home.efforts).max()
        found = estimate_wrench(
            robot, motors, efforts=true.efforts, effort_deviation=deviation, start=true
        )
        assert_allclose(found.equilibrium.efforts, true.efforts, rtol=0, atol=0.02 * deviation)
        assert found.equilibrium.index_locked == 0
        in_units = found.wrench_world / units
        # Nothing of it is along what is not felt, and no other wrench known to explain them is smaller.
        assert np.linalg.norm(in_units) <= np.linalg.norm(wrench / units) * (1.0 + 1e-6)
        assert np.abs(found.directions.directions[:, 3:].T @ in_units).max() < 1e-4


def test_it_is_the_one_that_steps_by_themselves_lead_to_where_they_end(monkeypatch):
    """Mixed ones end where the wrench is stationary, which may be a larger one."""
    robot = load_robot("three_rfs")
    home, rng, units, compared = solve_home(robot), np.random.default_rng(8), wrench_units(robot), 0
    for _ in range(12):
        motors = home.motors + rng.uniform(-0.2, 0.2, 3) * robot.motor_units
        loads = robot.default_loads.with_(wrench_world=0.5 * rng.uniform(-1.0, 1.0, 6) * units)
        try:
            true = solve_forward(robot, motors, start=home, loads=loads)
        except NotReached:
            continue  # more than it bears
        measured = {"efforts": true.efforts, "effort_deviation": 1e-3 * np.abs(home.efforts).max()}
        with monkeypatch.context() as alone:
            alone.setattr(wrench_search, "_WAYS", ((1.0, False),))
            try:
                wanted = estimate_wrench(robot, motors, **measured)
            except NotReached:
                continue
        found = estimate_wrench(robot, motors, **measured)
        assert_allclose(found.wrench_world, wanted.wrench_world, rtol=0, atol=1e-12)
        compared += 1
    assert compared >= 3


def test_a_wrench_that_is_not_felt_has_a_variance_as_good_as_infinite():
    true, _ = pushed("three_rfs")
    robot = true.robot
    found = estimate_wrench(
        robot, true.motors, efforts=true.efforts, effort_deviation=one_percent(true)
    )
    natural = robot.kernel_arrays.energy_unit / robot.mean_length
    scale = np.array([*[robot.mean_length] * 3, 1, 1, 1]) * natural
    for direction, felt in [(d, True) for d in found.felt] + [(d, False) for d in found.unfelt]:
        covector = direction / (scale / natural) / scale
        deviation = np.sqrt(covector @ found.covariance @ covector)
        assert (deviation < 1.0) if felt else (deviation == pytest.approx(1000.0, rel=1e-6))


def test_what_is_told_worse_than_to_a_natural_unit_is_not_felt():
    """By motors that are measured worse and worse, the direction that they tell worst first."""
    true, _ = pushed("rfrfr")
    robot, given = true.robot, {"efforts": true.efforts}
    units = wrench_units(robot)

    def found(deviation):
        return estimate_wrench(robot, true.motors, **given, effort_deviation=deviation)

    def worst(estimate):
        plane = np.ix_(robot.platform_axes, robot.platform_axes)
        natural = estimate.covariance[plane] / np.outer(units, units)
        return np.sqrt(np.linalg.eigvalsh(natural)[-1])

    exact = found(1e-3)
    to_one = 1e-3 / worst(exact)
    assert len(exact.unfelt) == 0
    for part, unfelt in ((0.98, 0), (1.02, 1)):
        less = found(part * to_one)
        assert len(less.unfelt) == unfelt
        assert worst(less) == pytest.approx(1000.0 if unfelt else part, rel=0.01)


@pytest.mark.parametrize("exactness", [(1e-8, 1e-2), (1e-3, 1e-7)])
def test_what_is_told_well_is_felt_beside_what_is_told_far_better(exactness):
    true, wrench = pushed("six_rfs", 0.05)
    found = estimate_wrench(true.robot, true.motors, pose=pose_of(true), pose_deviation=exactness)
    assert found.observability < 1e-4
    assert len(found.felt) == 6
    assert_allclose(found.wrench_world, wrench, rtol=0, atol=1e-6)


def test_the_delta_names_the_moments_it_does_not_feel():
    """Its platform cannot turn: the motors feel forces alone."""
    true, _ = pushed("delta", 0.05)
    found = estimate_wrench(
        true.robot, true.motors, efforts=true.efforts, effort_deviation=one_percent(true)
    )
    assert found.words == (
        "a moment about x is not felt; a moment about y is not felt; a moment about z is not felt"
    )
    moment, force = found.wrench_world[:3] / true.robot.mean_length, found.wrench_world[3:]
    assert np.linalg.norm(moment) < 0.1 * np.linalg.norm(force)


def test_a_planar_robot_has_a_wrench_in_its_plane():
    true, _ = pushed("rfrfr")
    found = estimate_wrench(
        true.robot, true.motors, efforts=true.efforts, effort_deviation=one_percent(true)
    )
    assert not found.wrench_world[[0, 1, 2, 5]].any()
    assert np.diag(found.covariance)[[0, 1, 2, 5]].min() > 1.0 > found.covariance[3, 3]


def test_a_motor_without_a_sensor_is_left_out():
    true, wrench = pushed("four_rfr")
    deviation = one_percent(true)
    deviation[1] = np.inf
    wrong = true.efforts + np.array([0.0, 50.0, 0.0, 0.0])
    found = estimate_wrench(true.robot, true.motors, efforts=wrong, effort_deviation=deviation)
    assert_allclose(found.wrench_world, wrench, rtol=0, atol=1e-9)
    assert found.degrees_of_freedom == 0


def test_measurements_that_contradict_each_other_are_told():
    true, _ = pushed("four_rfr")
    deviation = one_percent(true)
    wrong = true.efforts + 10.0 * deviation * np.array([1.0, -1.0, 1.0, -1.0])
    found = estimate_wrench(true.robot, true.motors, efforts=wrong, effort_deviation=deviation)
    assert found.degrees_of_freedom == 1 and found.consistency < 1e-6
