# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Several who measure the platform, all of them believed: the worst of what they say counts."""

from itertools import cycle

import numpy as np
import pytest
from helpers.closed_loop import TARGET

from cpr_core import load_robot, solve_home
from cpr_ros.closed_loop.loop_status import Loop
from cpr_ros.closed_loop.measured_arrival import MeasuredArrival
from cpr_ros.closed_loop.several_cameras import RecentPoses
from cpr_ros.following.pose_coordinates import pose_coordinates


def arrivals(bench, apart, tolerance, seconds=4.0):
    """How often a new setpoint is reached where two cameras measure it, some way apart [rod lengths]."""
    sides = cycle([0.0, apart * bench.robot.mean_length])
    bench.several, bench.seen = True, lambda pose: pose + [next(sides), 0.0]
    bench.follow(TARGET + [0.02, 0.0])
    wanted, count = MeasuredArrival(tolerance * bench.robot.mean_length, 0.0), 0
    for _ in range(round(seconds / 0.02)):
        bench.tick()
        count += wanted.met(bench.status)
    assert bench.status.loop == Loop.CLOSED
    return count


def test_a_setpoint_is_not_reached_where_only_one_of_two_cameras_sees_it_there(bench):
    """SUCCESS to a tolerance that was a thirtieth of what they differed by, without a word."""
    assert arrivals(bench, 0.03, 1e-3) == 0
    length = bench.robot.mean_length
    assert bench.status.position_error == pytest.approx(0.015 * length, rel=0.2)
    assert "several publish the measured pose, and differ by 0.03 rod lengths" in bench.status.text


def test_a_tolerance_that_both_cameras_keep_is_reached(bench):
    assert arrivals(bench, 0.03, 0.02) > 0


def test_cameras_that_agree_reach_what_one_would(bench):
    assert arrivals(bench, 0.0005, 1e-3) > 0
    assert bench.status.text == ""
    bench.several, bench.seen = False, lambda pose: pose
    bench.run(2.0)
    assert bench.status.position_error < 1e-6


def test_two_cameras_that_part_and_agree_again_are_told_as_long_as_they_are_apart(bench):
    arrivals(bench, 0.03, 1e-3)
    bench.seen = lambda pose: pose
    bench.run(3.0)
    np.testing.assert_allclose(bench.status.position_error, 0.0, atol=1e-5)
    assert bench.status.text == ""


def test_what_several_say_is_found_once_for_every_pose(monkeypatch):
    """It is asked for several times a tick, of a hundred poses and more."""
    home = solve_home(load_robot("six_rfs"))
    space = pose_coordinates(home.robot)
    poses, nowhere = RecentPoses(space), space.way(home.pose, home.pose)
    assert poses.errors(home.pose) is None and poses.apart() == ""
    for number, off in enumerate([0.0, 0.03, 0.01]):
        shift = np.eye(len(nowhere))[0] * off
        poses.take(space.moved(home.pose, shift), shift, 1.0 + 0.1 * number)
    position, rotation = poses.errors(home.pose)
    assert (position, rotation) == (pytest.approx(0.03), pytest.approx(0.0, abs=1e-7))
    assert "differ by 0.02 " in poses.apart()
    with monkeypatch.context() as patched:
        patched.setattr(space, "way", None)
        patched.setattr(space, "size", None)
        assert poses.errors(home.pose.copy()) == (position, rotation)
        assert "differ by 0.02 " in poses.apart()
    ahead = space.moved(home.pose, np.eye(len(nowhere))[0] * 0.1)
    assert poses.errors(ahead)[0] == pytest.approx(0.1)
    poses.take(home.pose, nowhere, 1.3)
    assert "differ by 0.03 " in poses.apart()
    poses.take(home.pose, nowhere, 1.65)  # the first two are forgotten
    assert poses.errors(home.pose)[0] == pytest.approx(0.01)
