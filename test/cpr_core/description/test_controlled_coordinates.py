# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The table of controlled coordinates: its axes, what is read of a platform, and the way back agree."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cpr_core.description.controlled_coordinates import (
    CONTROLLED_COORDINATES,
    meant_by,
    numbers_of,
    pose_of,
)
from cpr_core.lie import quaternion_from_rotation, rotation_exp, rotation_from_angles

POSITION = np.array([0.3, -0.2, 0.7])


def read(name, position, rotation):
    return pose_of((name,), position, rotation, lambda: quaternion_from_rotation(rotation))


@pytest.mark.parametrize("name", CONTROLLED_COORDINATES)
def test_a_pose_is_met_where_it_leads(name):
    turn = (0.0, 0.0, -2.1) if name == "angle" else (0.4, -0.5, 2.6)
    pose = read(name, POSITION, rotation_from_angles(*turn))
    assert len(pose) == len(numbers_of((name,)))
    position, rotation = meant_by((name,), pose, np.zeros(3), np.eye(3))
    assert_allclose(read(name, position, rotation), pose, rtol=1e-14)
    # What it does not say stays.
    assert CONTROLLED_COORDINATES[name].turns or np.array_equal(rotation, np.eye(3))
    assert np.count_nonzero(position) == (not CONTROLLED_COORDINATES[name].turns)


@pytest.mark.parametrize("name", CONTROLLED_COORDINATES)
def test_a_coordinate_is_moved_by_its_axes(name):
    moved = []
    for axis, twist in enumerate(1e-3 * np.eye(6)):
        pose = read(name, POSITION + twist[3:], rotation_exp(twist[:3]))
        if np.abs(pose - read(name, POSITION, np.eye(3))).max() > 1e-5:
            moved.append(axis)
    assert tuple(moved) == CONTROLLED_COORDINATES[name].axes


def test_two_single_angles_leave_the_third():
    rotation = rotation_from_angles(0.1, 0.2, 0.3)
    _, turned = meant_by(("pitch", "roll"), np.array([0.5, -0.4]), POSITION, rotation)
    assert_allclose(turned, rotation_from_angles(-0.4, 0.5, 0.3), atol=1e-15)
