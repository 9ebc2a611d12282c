# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measured poses that are believed, and such that are not."""

import re

import pytest
from helpers.closed_loop import PERIOD
from helpers.drive import robot

from cpr_core import solve_home, solve_inverse, trace
from cpr_ros.closed_loop.measured_pose import MeasuredPose
from cpr_ros.closed_loop.pose_history import PoseHistory
from cpr_ros.following.pose_coordinates import PoseCoordinates


@pytest.fixture(scope="module")
def way():
    """Equilibria of the planar robot on its way, a tick apart; it goes 0.01 rod lengths a tick."""
    planar = robot("rfrfr")
    home = solve_home(planar)
    return trace(planar, pose=home.pose + [0.0, -0.3], points=31).equilibria


def test_a_jump_and_the_motion_of_the_platform_are_told_apart(way):
    """A pose was said to have jumped by 0.1, while the platform moved by 0.1."""
    coordinates = PoseCoordinates(way[0].robot)
    history = PoseHistory(coordinates)
    measured = MeasuredPose(history, timeout=0.0)
    history.add(100.0, way[0], "")
    measured.take(way[0].pose, 100.0, 0.0, jump=1e-6, settling=10.0)
    history.add(101.0, way[10], "")
    for now in (101.0, 101.2):
        seen = way[10].pose - [0.0, 2e-6 * way[0].robot.mean_length]
        measured.take(seen, now, 0.0, jump=1e-6, settling=10.0)
    words = r"the measured pose jumped by (\S+) rod lengths or rad, the platform moved by (\S+)"
    change, moved = map(float, re.fullmatch(words, measured.problem).groups())
    assert change > moved


@pytest.mark.parametrize("ticks", [0, 5, 15, 25, 240])
@pytest.mark.parametrize("told", [True, False])
def test_a_camera_that_is_late_is_believed_while_the_robot_moves(way, ticks, told):
    """However late, if its stamps say so; else up to a fifth of a second.

    The robot begins from rest, so that for a while the late pictures are all alike: of the time before.
    """
    coordinates = PoseCoordinates(way[0].robot)
    history = PoseHistory(coordinates)
    measured = MeasuredPose(history, timeout=0.0)
    delay = ticks * PERIOD
    believed = []
    for tick in range(-40, len(way)):
        now = 100.0 + tick * PERIOD
        history.add(now, way[max(0, tick)], "")
        seen = way[max(0, tick - ticks)].pose
        believed.append(measured.take(seen.copy(), now, told * delay, jump=0.02, settling=0.1))
    assert all(believed) == (told or delay <= 0.2)


def test_where_the_platform_rested_for_long_is_remembered_after_it_has_moved(way):
    """A picture of the moment before was compared with the place after it."""
    history = PoseHistory(PoseCoordinates(way[0].robot))
    for time, number in ((0.0, 0), (100.0, 1), (100.1, 2), (103.0, 3), (107.0, 4)):
        history.add(time, way[number], "")
    seen = [history.at(time).equilibrium for time in (102.0, 102.9, 103.0, 106.9, 107.0, 110.0)]
    assert [way.index(each) for each in seen] == [2, 2, 3, 3, 4, 4]
    history = PoseHistory(PoseCoordinates(way[0].robot))
    history.add(0.0, way[0], "")
    history.add(100.0, way[1], "")
    assert history.at(99.9).equilibrium is way[0]
    assert history.travelled(100.0) - history.travelled(99.9) > 0.0


@pytest.mark.parametrize(("moved", "believed"), [(1.9e-3, True), (2.1e-3, False)])
def test_numbers_stay_the_same_for_a_small_motion_and_no_farther(way, moved, believed):
    """A camera that hangs is told before the correction takes out what it does not see."""
    coordinates = PoseCoordinates(way[0].robot)
    history = PoseHistory(coordinates)
    measured = MeasuredPose(history, timeout=0.0)
    history.add(100.0, way[0], "")
    assert measured.take(way[0].pose, 100.0, 0.0, jump=0.02, settling=0.1)
    there = way[0].pose - [0.0, moved * way[0].robot.mean_length]
    history.add(101.0, solve_inverse(way[0].robot, there, start=way[0]), "")
    assert measured.take(way[0].pose, 102.0, 0.0, jump=0.02, settling=0.1) == believed
    assert believed == ("does not change" not in measured.problem)
