# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements of other units, lengths and orders: each is refused or doubted in words."""

import numpy as np
import pytest

from cpr_core import (
    InvalidQuaternion,
    InvalidRequest,
    NonFiniteInput,
    NotReached,
    estimate_wrench,
    load_robot,
    solve_forward,
    solve_home,
)
from cpr_core.identification.wrench_measurements import wrench_measurements
from cpr_core.lie import quaternion_from_rotation, rotation_exp

HOME = solve_home(load_robot("six_rfs"))
TRUE = solve_forward(HOME.robot, HOME.motors + 0.1)
POSE = np.concatenate([TRUE.platform_position, TRUE.platform_quaternion])
GIVEN = {
    "motors": TRUE.motors,
    "efforts": TRUE.efforts,
    "effort_deviation": 0.01,
    "pose": POSE,
    "pose_deviation": (1e-4, 1e-3),
}


def estimate(**changed):
    given = {**GIVEN, **changed}
    return estimate_wrench(TRUE.robot, given.pop("motors"), **given)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 1.6, 3.0])
def test_what_is_left_is_measured_less_modelled_in_deviations(angle):
    efforts, position = TRUE.efforts + np.arange(6.0), TRUE.platform_position + [0.01, -0.02, 0.03]
    turn = angle * np.array([2.0, -3.0, 6.0]) / 7.0
    rotation = rotation_exp(turn) @ TRUE.platform_rotation
    pose = np.concatenate([position, quaternion_from_rotation(rotation)])
    of_efforts, of_pose = np.linspace(0.1, 0.6, 6), (1e-4, 1e-3)

    def left(efforts, pose):
        given = (TRUE.motors, efforts, of_efforts, pose, of_pose, TRUE)
        return wrench_measurements(TRUE.robot, *given).residual(TRUE)

    pushed = np.arange(6.0) / of_efforts
    seen = np.concatenate([turn / 1e-3, np.array([0.01, -0.02, 0.03]) / 1e-4])
    np.testing.assert_allclose(left(efforts, None), pushed, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(left(None, pose), seen, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(left(efforts, pose), [*pushed, *seen], rtol=1e-12, atol=1e-9)


def test_controlled_coordinates_are_no_pose_of_the_platform():
    """One word for two things: Equilibrium.pose is what solve_inverse takes."""
    home = solve_home(load_robot("delta"))
    with pytest.raises(InvalidRequest, match="pose: expected 7 numbers") as caught:
        estimate_wrench(home.robot, home.motors, pose=home.pose, pose_deviation=(1e-4, 1e-3))
    told = "Equilibrium.pose has the coordinates that this robot controls (x y z)"
    meant = "give [*platform_position, *platform_quaternion]"
    assert caught.value.problem.endswith(f", got 3; {told}: {meant}")
    whole = [*home.platform_position, *home.platform_quaternion]
    estimate_wrench(home.robot, home.motors, pose=whole, pose_deviation=(1e-4, 1e-3))


def test_deviations_count_as_they_are_now_whoever_holds_their_array():
    deviations = np.full(6, 0.01)
    before = estimate(effort_deviation=deviations)
    deviations[:] = 0.02
    after = estimate(effort_deviation=deviations)
    assert np.all(np.diag(after.covariance) > np.diag(before.covariance))
    np.testing.assert_array_equal(after.covariance, estimate(effort_deviation=0.02).covariance)


@pytest.mark.parametrize("deviation", ["0.01", True, [0.1, "0.1"], [[0.1], 0.1], [None] * 6])
def test_deviations_are_numbers(deviation):
    with pytest.raises(InvalidRequest, match=r"effort_deviation: expected numbers .*, got"):
        estimate(effort_deviation=deviation)


@pytest.mark.parametrize("name", ["motors", "efforts", "pose"])
def test_numbers_have_to_be_finite(name):
    for bad in (np.nan, np.inf):
        values = np.array(GIVEN[name])
        values[1] = bad
        with pytest.raises(NonFiniteInput, match=f"{name}: .*finite"):
            estimate(**{name: values})
    with pytest.raises(NonFiniteInput, match="effort_deviation"):
        estimate(effort_deviation=np.nan)


@pytest.mark.parametrize(
    ("name", "length"), [("motors", 6), ("efforts", 6), ("effort_deviation", 6), ("pose", 7)]
)
def test_lengths_are_named(name, length):
    with pytest.raises(InvalidRequest, match=f"{name}: expected {length} numbers.*, got 5"):
        estimate(**{name: np.ones(5)})
    with pytest.raises(InvalidRequest, match="pose_deviation: expected 2 numbers"):
        estimate(pose_deviation=1e-3)


def test_deviations_are_needed_and_positive():
    for name in ("effort_deviation", "pose_deviation"):
        with pytest.raises(InvalidRequest, match=f"{name}: expected standard deviations"):
            estimate(**{name: None})
        zero = np.zeros(6 if name == "effort_deviation" else 2)
        with pytest.raises(InvalidRequest, match=f"{name}: expected numbers above 0"):
            estimate(**{name: zero})
    with pytest.raises(InvalidRequest, match="efforts, a pose or both"):
        estimate(efforts=None, pose=None)
    with pytest.raises(InvalidRequest, match="all are infinite"):
        estimate(pose=None, effort_deviation=np.inf)


def test_what_is_all_infinite_is_named():
    """The efforts were named, given or not."""
    nothing = {"efforts": None, "effort_deviation": None, "pose_deviation": (np.inf, np.inf)}
    with pytest.raises(InvalidRequest, match=r"^pose_deviation: .*all are infinite$"):
        estimate(**nothing)
    with pytest.raises(InvalidRequest, match=r"^effort_deviation and pose_deviation: expected a f"):
        estimate(effort_deviation=np.inf, pose_deviation=(np.inf, np.inf))
    point = solve_home(load_robot("rfrfr"))
    pose = np.concatenate([point.platform_position, point.platform_quaternion])
    with pytest.raises(
        InvalidRequest, match=r"^pose_deviation: .*a point platform has no rotation"
    ):
        estimate_wrench(point.robot, point.motors, pose=pose, pose_deviation=(np.inf, 1e-3))


def test_a_pose_far_out_of_the_plane_is_told():
    """It was projected into the plane, without a word."""
    home = solve_home(load_robot("four_rfr"))
    position, turn = home.platform_position, home.platform_rotation

    def felt(shift, tilt, deviations=(1e-3, 1e-3)):
        rotation = rotation_exp(np.array([0.0, tilt, 0.0])) @ turn
        pose = [*(position + [0.0, 0.0, shift]), *quaternion_from_rotation(rotation)]
        return estimate_wrench(home.robot, home.motors, pose=pose, pose_deviation=deviations)

    with pytest.raises(InvalidRequest, match=r"^pose: z is 0.05 m, of a robot in the plane z = 0"):
        felt(0.05, 0.0)
    with pytest.raises(InvalidRequest, match=r"^pose: the orientation leads out .* by 0.1 rad"):
        felt(0.0, 0.1)
    with pytest.raises(InvalidRequest, match=r"z is -0\.(\d+)000\d+ m.*at most 0\.\1, in the"):
        felt(-0.020000002 * home.robot.mean_length, 0.0)
    with pytest.raises(InvalidRequest, match=r"by 0\.0200000\d+ rad: expected at most 0\.02,"):
        felt(0.0, 0.020000002)
    for near in (felt(0.005, 0.015), felt(0.05, 0.0, (np.inf, 1e-3)), felt(0.0, 0.1, (1e-3, 0.02))):
        assert near.wrench_world == pytest.approx(np.zeros(6), abs=1e-3)


@pytest.mark.parametrize("deviation", [1e-200, 1e-31, 1e31, 1e200])
def test_deviations_whose_squares_are_no_numbers_are_refused(deviation):
    """Their reciprocals squared were nothing, and what was not known was known exactly."""
    for name, value in (
        ("effort_deviation", deviation),
        ("pose_deviation", (1e-3, deviation)),
    ):
        with pytest.raises(InvalidRequest, match=f"{name}: expected numbers from 1e-30 to 1e"):
            estimate(**{name: value})
    for edge in (1e-30, 1e30):
        assert np.isfinite(estimate(pose=None, effort_deviation=edge).covariance).all()


def test_a_quaternion_in_the_order_of_ros_is_told():
    with pytest.raises(InvalidRequest, match="looks like x y z w, expected w x y z"):
        estimate(pose=np.concatenate([POSE[:3], POSE[[4, 5, 6, 3]]]))
    with pytest.raises(InvalidQuaternion, match="unit length"):
        estimate(pose=np.concatenate([POSE[:3], 2.0 * POSE[3:]]))


def test_a_pose_in_millimetres_is_told():
    with pytest.raises(InvalidRequest, match=r"pose: .*millimetres"):
        estimate(pose=np.concatenate([1000.0 * POSE[:3], POSE[3:]]))


@pytest.mark.parametrize("name", ["six_rfs", "six_rus", "four_rfr", "three_rfs"])
@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_efforts_in_other_units_are_doubted(name, factor):
    robot = load_robot(name)
    home = solve_home(robot)
    efforts = factor * home.efforts
    given = {"efforts": efforts, "effort_deviation": 0.01 * np.abs(efforts).max()}
    try:
        found = estimate_wrench(robot, home.motors, **given)
    except NotReached as error:
        told = str(error)
    else:
        told = found.doubt
        assert told in found.words
        again = estimate_wrench(robot, home.motors, **given, start=found)
        assert again.doubt == told
    assert ("N mm?" if factor > 1.0 else "kN m?") in told


def test_units_are_doubted_of_what_is_measured_now_and_not_of_what_was():
    """A tracked estimate kept the doubt of its first measurements, or the lack of one."""
    robot = load_robot("rfrfr")
    motors = solve_home(robot).motors + 0.3
    pushed = robot.default_loads.with_(wrench_world=[0, 0, 0, 0.05, 0.1, 0])
    true = solve_forward(robot, motors, loads=pushed)
    pose = [*true.platform_position, *true.platform_quaternion]
    given = {"pose": pose, "pose_deviation": (1e-4, 1e-3), "effort_deviation": 1e-3}
    wrong = estimate_wrench(robot, motors, efforts=true.efforts / 1000.0, **given)
    assert "kN m?" in wrong.doubt
    right = estimate_wrench(robot, motors, efforts=true.efforts, start=wrong, **given)
    assert right.doubt == ""
    np.testing.assert_allclose(right.wrench_world, pushed.wrench_world, atol=1e-6)
    again = estimate_wrench(robot, motors, efforts=true.efforts / 1000.0, start=right, **given)
    assert "kN m?" in again.doubt
    assert estimate_wrench(robot, motors, start=again, **given | {"efforts": None}).doubt == ""


def test_there_is_a_start_of_the_same_robot():
    with pytest.raises(InvalidRequest, match="start: expected an equilibrium of the same robot"):
        estimate(start=solve_home(load_robot("six_rfs", modes=4)))
    with pytest.raises(InvalidRequest, match="start"):
        estimate(start=3)
    with pytest.raises(InvalidRequest, match="robot"):
        estimate_wrench("six_rfs", TRUE.motors, efforts=TRUE.efforts, effort_deviation=1.0)
    other = estimate()
    with pytest.raises(InvalidRequest, match="start: expected an equilibrium of the same robot"):
        estimate_wrench(
            load_robot("rfrfr"), [0.0, 0.0], efforts=[0.0, 0.0], effort_deviation=1.0, start=other
        )


def test_motors_that_no_equilibrium_has_are_refused():
    with pytest.raises(NotReached):
        estimate(motors=TRUE.motors + [3.0, -3.0, 3.0, -3.0, 3.0, -3.0])


def test_efforts_that_no_stable_equilibrium_has_are_refused():
    with pytest.raises(
        NotReached,
        match="no wrench was found near the start that explains the measurements: no stable ",
    ):
        estimate(pose=None, efforts=TRUE.efforts + [3.0, 3.0, -3.0, 3.0, -3.0, 3.0])
