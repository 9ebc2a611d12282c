# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot that follows timed trajectories."""

import pytest
from helpers.drive import robot
from helpers.followed_trajectories import Follower


@pytest.fixture
def rfrfr():
    return Follower(robot("rfrfr"))
