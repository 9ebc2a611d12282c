# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Nothing that a test starts is heard outside; a follower of each paper robot, without ROS."""

import pytest
from helpers.drive import Drive, robot

from cpr_ros.process.own_domain import enter_own_domain

#: On this machine only.
_OWN_DOMAIN = enter_own_domain()


@pytest.fixture
def rfrfr() -> Drive:
    return Drive(robot("rfrfr"))


@pytest.fixture
def six_rfs() -> Drive:
    return Drive(robot("six_rfs"))
