# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a pose imposes, and how far it is: quickly at the end of a way, as everywhere else on it."""

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import load_robot, solve_forward, solve_home
from cpr_core.kernels.record_layout import IMPOSED_MOTORS, POSITION, ROTATION
from cpr_core.lie import roll_pitch_yaw, rotation_exp
from cpr_core.solving.requests import target_of
from cpr_core.solving.targets import PoseTarget, apart

CONTROLLED = {
    "rfrfr": ["x", "y"],
    "planar_body": ["x", "y", "angle"],
    "three_rfs": ["roll", "pitch", "z"],
    "six_rfs": ["x", "y", "z", "orientation"],
}


def robot_with(name):
    content = shipped_content(name)
    content["controlled"] = CONTROLLED[name]
    return load_robot(content, modes=3)


@pytest.mark.parametrize("name", CONTROLLED)
def test_poses_are_as_far_as_their_numbers_are_apart(name):
    random, home = np.random.default_rng(5), solve_home(robot_with(name))
    for size in (1e-6, 1e-3, 0.1, 1.0, 3.0):
        rotation = home.platform_rotation @ rotation_exp(size * random.uniform(-1.0, 1.0, 3))
        position = home.platform_position + size * random.uniform(-1.0, 1.0, 3)
        target = PoseTarget(rotation, position)
        first, last = (
            np.concatenate([turn.ravel(), place])[:IMPOSED_MOTORS]
            for turn, place in (
                (home.platform_rotation, home.platform_position),
                (rotation, position),
            )
        )
        expected = float(apart(home.robot, "pose", first, last))
        assert target.distance(home) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", CONTROLLED)
def test_the_end_of_a_way_is_where_the_way_leads(name):
    random, home = np.random.default_rng(6), solve_home(robot_with(name))
    pose = home.pose.copy()
    pose[: len(CONTROLLED[name])] += random.uniform(-0.05, 0.05, len(CONTROLLED[name]))
    if "orientation" in CONTROLLED[name]:
        pose[3:] = [0.96, 0.0, 0.28, 0.0]
    target = target_of(home, "pose", pose)
    end, before = target.given(home), target.given(home, 1.0 - 1e-9)
    assert np.abs(end - target.given(home, 0.0)).max() > 1e-3
    np.testing.assert_allclose(end, before, atol=1e-8)


@pytest.mark.parametrize("fraction", [-1e-3, 1.0 + 1e-5, 1.5])
@pytest.mark.parametrize("name", CONTROLLED)
def test_ways_go_straight_on_beyond_their_ends(name, fraction):
    """Single angles stayed at the end: walks by arc length, which step over it, were lost next to it."""
    home = solve_home(robot_with(name))
    change = 0.02 * np.cos(np.arange(len(home.pose)))
    if "orientation" in CONTROLLED[name]:
        change[3:] = 0.0  # no turn
    target = target_of(home, "pose", home.pose + change)
    beyond = target_of(home, "pose", home.pose + fraction * change)
    np.testing.assert_allclose(target.given(home, fraction), beyond.given(home), atol=1e-12)


@pytest.mark.parametrize("fraction", [0.5, 1.0])
def test_angles_that_are_not_controlled_are_those_near_by(fraction):
    robot = robot_with("three_rfs")
    home = solve_home(robot)
    near = solve_forward(robot, home.motors + [0.1, -0.1, 0.05])
    yaw, at_home = (roll_pitch_yaw(each.platform_rotation)[2] for each in (near, home))
    assert abs(yaw - at_home) > 1e-6
    given = target_of(home, "pose", home.pose + 0.01).given(home, fraction, near)[0]
    roll, pitch, kept = roll_pitch_yaw(given[ROTATION:POSITION].reshape(3, 3))
    assert kept == pytest.approx(yaw, abs=1e-12)
    begin = roll_pitch_yaw(home.platform_rotation)[:2]
    np.testing.assert_allclose([roll, pitch], begin + 0.01 * fraction, atol=1e-12)
