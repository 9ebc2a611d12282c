# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Efforts of the other sign, or those behind a gear, are told; those of a strong wrench are not."""

import copy
import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from helpers.geared_robots import geared
from helpers.simulated_measurements import DEVIATIONS, PATHS, equilibria, measured, payload

from cpr_core import (
    CalibrationWarning,
    InvalidRequest,
    Measurement,
    NotReached,
    TimeLimitExceeded,
    calibrate,
    estimate_wrench,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.identification.effort_doubts import effort_unit_doubt, other_efforts
from cpr_core.model.world_response import effort_units

SIGN = "efforts look like those with the other sign (expected: what the motor does to the rod)"
POSE = {"pose_deviation": (1e-3, 5e-3)}


def pushed(robot, wrench):
    loads = robot.default_loads.with_(wrench_world=wrench)
    return solve_forward(robot, solve_home(robot).motors, loads=loads)


def pose_of(at):
    return np.concatenate([at.platform_position, at.platform_quaternion])


def deviation(robot, efforts):
    """As the node has it."""
    return np.hypot(0.01 * effort_units(robot), 0.02 * np.abs(efforts))


def told(robot, motors, efforts, **more):
    """What is said of efforts, in the answer or in the error."""
    given = {"efforts": efforts, "effort_deviation": deviation(robot, efforts), **more}
    try:
        return estimate_wrench(robot, motors, **given).doubt
    except NotReached as error:
        return str(error)


@pytest.mark.parametrize("with_pose", [False, True])
@pytest.mark.parametrize("name", ["six_rfs", "rfrfr", "four_rfr"])
def test_efforts_with_the_other_sign_are_told(name, with_pose):
    robot = load_robot(name)
    at = pushed(robot, [0, 0, 0, 0.05, 0, 0])
    more = {"pose": pose_of(at), **POSE} if with_pose else {}
    assert SIGN in told(robot, at.motors, -at.efforts, **more)
    assert told(robot, at.motors, at.efforts, **more) == ""


@pytest.mark.parametrize("with_pose", [False, True])
@pytest.mark.parametrize(
    ("name", "seen"),
    [
        ("rfrfr", "the gear: motor1 at 0.6.* N m, expected about 0.006.*; ratio is 0.01"),
        ("delta", r"the gear: motor\d at -0.2.* N m, expected about -0.00.*; ratio is 0.01"),
        ("three_prs", "the screw: motor1 at -0.2.* N m, expected about -3.8e-05; lead is 0.001"),
        ("gough_stewart", "the screw: motor4 at 0.2.* N m, expected about 1.6e-05; lead is 0.0005"),
    ],
)
def test_efforts_behind_gears_and_screws_are_told(name, seen, with_pose):
    robot, ratios = geared(name).robot, geared(name).ratios
    at = solve_home(robot)
    more = {"pose": pose_of(at), **POSE} if with_pose else {}
    match = re.compile(f"efforts look like those behind {seen}")
    assert match.search(told(robot, at.motors, at.efforts / ratios, **more))
    assert told(robot, at.motors, at.efforts, **more) == ""


@pytest.mark.parametrize(("beyond", "said"), [(6.0, False), (12.0, True)])
def test_a_motor_somewhat_beyond_its_limit_may_be_pushed_there(beyond, said):
    """A wrench makes efforts larger than those that motors hold for long, and no gear does."""
    robot, ratios = geared("rfrfr").robot, geared("rfrfr").ratios
    modelled = 0.05 * effort_units(robot)
    measured = modelled / ratios
    content = copy.deepcopy(robot.description.written.content)
    for leg, effort in zip(content["legs"], np.abs(measured), strict=True):
        for joint in leg["chain"]:
            if "motor" in joint:
                joint["limits"] = {"effort": float(effort / beyond)}
    found = [reading.doubt for reading in other_efforts(load_robot(content), measured, modelled)]
    assert any("those behind the gear" in doubt for doubt in found) == said


@pytest.mark.parametrize("behind", [True, False])
@pytest.mark.parametrize(("gear", "said"), [(4.0, False), (6.0, True)])
def test_a_gear_that_changes_efforts_little_is_not_told_from_a_wrench(gear, said, behind):
    plain, geared_robot, _ = geared("rfrfr")
    content = copy.deepcopy(geared_robot.description.written.content)
    content["home"]["motors"] = (gear * solve_home(plain).motors).tolist()
    for leg in content["legs"]:
        for joint in leg["chain"]:
            if "ratio" in joint:
                joint["ratio"] = 1.0 / gear
    robot = load_robot(content)
    modelled = 4.0 * effort_units(robot)
    measured = modelled * gear if behind else modelled / gear
    found = [reading.doubt for reading in other_efforts(robot, measured, modelled)]
    words = "those behind the gear" if behind else "those taken twice through the gear"
    assert any(words in doubt for doubt in found) == said


def test_efforts_taken_twice_through_a_gear_are_told():
    robot, ratios = geared("rfrfr").robot, geared("rfrfr").ratios
    at = solve_home(robot)
    doubt = told(robot, at.motors, at.efforts * ratios, pose=pose_of(at), **POSE)
    assert "those taken twice through the gear: motor" in doubt


def test_it_is_told_where_the_time_was_over_too():
    robot, gears = load_robot("six_rfs"), geared("rfrfr")
    at, home = solve_home(robot), solve_home(gears.robot)
    for known, motors, efforts, words in (
        (robot, at.motors, -at.efforts, SIGN),
        (gears.robot, home.motors, home.efforts / gears.ratios, "those behind the gear: motor1"),
        (robot, at.motors, 1e3 * at.efforts, "are they in N mm?"),
    ):
        exactness = 0.01 * effort_units(known)
        given = {"efforts": efforts, "effort_deviation": exactness, "time_limit": 1e-9}
        with pytest.raises(TimeLimitExceeded) as caught:
            estimate_wrench(known, motors, **given)
        assert str(caught.value).startswith("wrench: the time allowed was over; ")
        assert words in str(caught.value)


def test_it_is_told_of_what_is_measured_now_and_not_of_what_was():
    robot = load_robot("six_rfs")
    at = pushed(robot, [0, 0, 0, 0.1, 0, -0.5])
    more = {"pose": pose_of(at), "effort_deviation": deviation(robot, at.efforts), **POSE}
    wrong = estimate_wrench(robot, at.motors, efforts=-at.efforts, **more)
    assert wrong.doubt == SIGN and SIGN in wrong.words and wrong.consistency < 1e-6
    again = estimate_wrench(robot, at.motors, efforts=-at.efforts, start=wrong, **more)
    assert again.doubt == SIGN
    right = estimate_wrench(robot, at.motors, efforts=at.efforts, start=again, **more)
    assert right.doubt == ""
    moved = solve_forward(robot, at.motors + 0.05, start=at, loads=at.loads)
    more["pose"] = pose_of(moved)
    assert told(robot, moved.motors, moved.efforts, start=right, **more) == ""
    assert SIGN in told(robot, moved.motors, -moved.efforts, start=right, **more)


def test_motors_without_a_sensor_say_nothing():
    robot = load_robot("six_rfs")
    at = solve_home(robot)
    efforts, exactness = -at.efforts, deviation(robot, at.efforts)
    efforts[0], exactness[0] = 1e6, np.inf
    assert SIGN in told(robot, at.motors, efforts, effort_deviation=exactness)


@pytest.mark.parametrize("gear", [False, True])
@pytest.mark.parametrize("name", ["six_rfs", "rfrfr", "three_prs", "delta"])
def test_a_strong_wrench_is_no_other_sign_and_no_gear(name, gear):
    """Up to where the robot gives way, also where poses contradict it and where the time is over."""
    robot = geared(name).robot if gear else geared(name).plain
    home, random, changes = solve_home(robot), np.random.default_rng(3), []
    for _ in range(4):
        wrench = np.zeros(6)
        wrench[robot.platform_axes] = random.normal(size=len(robot.platform_axes))
        wrench *= 20.0 * robot.wrench_units / np.linalg.norm(wrench)
        loads = robot.default_loads.with_(wrench_world=wrench)
        try:
            at = solve_forward(robot, home.motors, loads=loads)
        except NotReached as error:
            at = error.last
        changes.append(np.abs((at.efforts - home.efforts) / effort_units(robot)).max())
        elsewhere = pose_of(at) + 0.02 * robot.mean_length * np.eye(7)[0]
        for more in (
            {},
            {"pose": pose_of(at), "start": at, **POSE},
            {"pose": elsewhere, "start": at, "pose_deviation": (1e-4, 1e-3)},
            {"time_limit": 1e-9},
        ):
            words = told(robot, at.motors, at.efforts, **more)
            assert "efforts" not in words, words
    assert max(changes) > 0.3


def test_a_screw_and_a_unit_that_are_alike_are_told_apart():
    """One that makes efforts 523 times as large, which may be N mm, too."""
    robot, ratios = geared("three_prs").robot, geared("three_prs").ratios
    efforts = solve_home(robot).efforts
    one = np.where(np.arange(3) == 2, efforts, np.nan)
    assert "behind the screw: motor3" in effort_unit_doubt(robot, one / ratios, efforts)
    assert "N mm?" in effort_unit_doubt(robot, 1e3 * one, efforts)


@pytest.mark.parametrize("gear", [False, True])
def test_calibrations_tell_them_of_all_rows_together(gear):
    name, exactness = ("rfrfr" if gear else "six_rfs"), replace(DEVIATIONS, efforts=1e-4)
    robot = geared(name).robot if gear else load_robot(name)
    truth = robot.with_parameters({PATHS[0]: 190e9})
    loads = robot.default_loads if gear else payload(robot)
    found = equilibria(truth, solve_home(robot), count=4, loads=loads)
    rows = measured(found, seed=0, deviations=exactness, efforts=True)
    factors = 1.0 / geared(name).ratios if gear else -np.ones(robot.motor_count)

    def doubts(factors):
        given = [replace(row, efforts=factors * row.efforts) for row in rows]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CalibrationWarning)
            return calibrate(robot, given, PATHS[:1], exactness).doubts

    assert doubts(np.ones(robot.motor_count)) == ()
    words = "efforts look like those behind the gear: motor" if gear else SIGN
    assert any(doubt.startswith(words) for doubt in doubts(factors))


def test_calibrations_name_the_sign_where_not_all_is_measured():
    """As in files of planar robots, which have no column for the height."""
    robot = load_robot("rfrfr")
    rows = []
    for change in (-0.1, 0.0, 0.1, 0.2):
        at = solve_forward(robot, solve_home(robot).motors + change)
        place, efforts = [*at.platform_position[:2], None], [-at.efforts[0], None]
        rows.append(Measurement(motors=at.motors, position=place, efforts=efforts))
    with pytest.warns(CalibrationWarning):
        found = calibrate(robot, rows, PATHS[:1], replace(DEVIATIONS, efforts=1e-4))
    assert SIGN in found.doubts


def test_calibrations_that_are_refused_for_units_name_the_screw():
    robot, ratios = geared("three_prs").robot, geared("three_prs").ratios
    found = equilibria(robot, solve_home(robot), count=4, loads=robot.default_loads)
    rows = [
        replace(row, efforts=at.efforts / ratios)
        for row, at in zip(measured(found, seed=0), found, strict=True)
    ]
    with pytest.raises(
        InvalidRequest, match=r"another unit\? expected N m or N; .* behind the screw"
    ):
        calibrate(robot, rows, PATHS[:1], replace(DEVIATIONS, efforts=1e-4))
